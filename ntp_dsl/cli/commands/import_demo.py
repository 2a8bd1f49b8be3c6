"""`ntp import-demo`: a demonstration from a table of poses that was recorded elsewhere."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ntp_dsl.cli.display import answers, messages
from ntp_dsl.cli.options import Library, Seed, Task
from ntp_dsl.cli.outputs import check_ending, check_no_input
from ntp_dsl.common.text import counted
from ntp_dsl.language.diagnostics.diagnostics import NtpError

if TYPE_CHECKING:
    from ntp_dsl.demonstrations.demonstration import Demonstration


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
    from ntp_dsl.demonstrations.demonstration_files import write_demonstration
    from ntp_dsl.demonstrations.foreign_tables import imported
    from ntp_dsl.demonstrations.pose_maps import read_map
    from ntp_dsl.demonstrations.pose_maps import template as template_of
    from ntp_dsl.evaluation.episodes import Evaluator, Plan

    objects = Evaluator(Plan(library, task, None, seed=seed)).instance(0).objects
    if template:
        if file or map or out:
            raise NtpError("--template prints a map, and reads and writes no file: give it alone")
        answers.print(template_of(objects), end="", soft_wrap=True)
        return 0
    for given, what in ((file, "FILE, the table"), (map, "--map FILE"), (out, "--out FILE")):
        if given is None:
            raise NtpError(f"expected {what}, found none; --template prints a map to begin with")
    assert file is not None and map is not None and out is not None
    check_no_input(out, [file, map])
    check_ending(out, ".parquet")
    if out.exists():
        raise NtpError(f"--out: {out} exists already; give another file, or remove it")
    found = imported(file, read_map(map), objects)
    write_demonstration(found, out)
    messages.print(f"{_summary(found)}; written to {out}")
    if not (found.closed[1:] & ~found.closed[:-1]).any():
        messages.print(
            "the hand never closes, so that nothing can be read: see `closed`, `below` and `above` in the map"
        )
    return 0


def _summary(found: Demonstration) -> str:
    """Return what tells at a glance whether units and frames are right."""
    seconds = float(found.times[-1] - found.times[0])
    closings = int((found.closed[1:] & ~found.closed[:-1]).sum())
    movable = [index for index, obj in enumerate(found.objects) if obj.movable]
    heights = found.positions[:, movable, 2]
    low, high = (heights.min(), heights.max()) if movable else (0.0, 0.0)
    return (
        f"{counted(len(found), 'frame')} of {seconds:.1f} s, the hand closes {counted(closings, 'time')}, "
        f"centres of movable objects are {low:.3f} to {high:.3f} m above the table"
    )
