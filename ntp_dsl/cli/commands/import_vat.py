"""`ntp import-vat`: conversion of task files of the paper's authors."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.outputs import check_no_input
from ntp_dsl.tasks.task_files import as_file, read_tasks, write_tasks


def command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="JSON file of the authors.")],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File to write; by default standard output.")
    ] = None,
) -> None:
    """Convert a task file of the paper's authors to our own format.

    Example: ntp import-vat stack_unseen_500.json --out unseen.json
    """
    from ntp_dsl.cli.display import messages, print_json

    check_no_input(out, [file])
    entries = read_tasks(file)
    if out is None:
        print_json(as_file(entries))
    else:
        write_tasks(entries, out)
        plural = "s" * (len(entries) != 1)
        messages.print(f"{len(entries)} task{plural} written to {out}")
