"""`ntp import-demo`: a demonstration from a table of poses that was recorded elsewhere."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.display import answers, messages
from ntp_dsl.cli.options import Library, Seed, Task
from ntp_dsl.cli.outputs import check_no_input
from ntp_dsl.common.text import counted
from ntp_dsl.language.diagnostics.diagnostics import NtpError


def command(
    library: Library,
    task: Task,
    file: Annotated[
        Path | None, typer.Argument(metavar="[FILE]", help="CSV or Parquet, one row a frame.")
    ] = None,
    map: Annotated[
        Path | None, typer.Option(metavar="FILE", help="TOML that says what the columns are.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The demonstration to write, in Parquet.")
    ] = None,
    template: Annotated[
        bool, typer.Option("--template", help="Print a map for the task's objects, to be edited.")
    ] = False,
    seed: Seed = 0,
) -> int:
    """Convert a table of tracked poses into a demonstration: names, units and frames are told by a map.

    The objects are those of the task, as drawn from the seed. Gaps in the tracking of up to half a second
    are bridged.

    Example: ntp import-demo block_stacking block_stacking --template > map.toml
             ntp import-demo block_stacking block_stacking poses.csv --map map.toml --out mine.demo.parquet
    """
    from ntp_dsl.demonstrations import foreign_tables
    from ntp_dsl.demonstrations.demonstration_files import write_demonstration
    from ntp_dsl.evaluation.episodes import Evaluator, Plan

    objects = Evaluator(Plan(library, task, None, seed=seed)).instance(0).objects
    if template:
        answers.print(foreign_tables.template(objects), end="", soft_wrap=True)
        return 0
    if file is None or map is None or out is None:
        raise NtpError(
            "expected a table, its map and what to write: FILE --map FILE --out FILE; or --template"
        )
    check_no_input(out, [file, map])
    found = foreign_tables.imported(file, foreign_tables.read_map(map), objects)
    write_demonstration(found, out)
    seconds = float(found.times[-1] - found.times[0])
    messages.print(f"{counted(len(found), 'frame')} of {seconds:.1f} s written to {out}")
    return 0
