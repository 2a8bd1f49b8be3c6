"""`ntp trace view`: one trace, or two side by side, as a page for a browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.display import answers, messages, print_json
from ntp_dsl.cli.options import Json
from ntp_dsl.cli.outputs import check_no_input
from ntp_dsl.cli.shown_beside import demonstration_beside, demonstration_file
from ntp_dsl.cli.trace_folders import pairs, traces_in
from ntp_dsl.common.files import written_whole
from ntp_dsl.common.text import counted
from ntp_dsl.demonstrations.demonstration_files import read_demonstration
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.page.page import page
from ntp_dsl.traces.reader import read_trace


def command(
    first: Annotated[
        Path, typer.Argument(metavar="A", help="A trace; of two, the reference; or a folder of traces.")
    ],
    second: Annotated[
        Path | None, typer.Argument(metavar="[B]", help="The trace to compare with it, or a folder.")
    ] = None,
    out: Annotated[Path, typer.Option(help="File to write.")] = Path("trace.html"),
    demo: Annotated[
        Path | None, typer.Option(help="The demonstration; by default the file beside the trace.")
    ] = None,
    json: Json = False,
) -> None:
    """Write a self-contained HTML page of one trace, or of two side by side.

    It shows the aligned call trees, scopes over the demonstration, the motion of all objects, the
    alternatives of each decision, and the camera's pictures. It fetches nothing from the network. Of
    folders it shows the first trace that failed, or the first pair of equal names that differs.

    Example: ntp trace view scripted.trace.jsonl learned.trace.jsonl --out both.html
    """
    first, second = _chosen(first, second)
    a = read_trace(first)
    b = a if second is None else read_trace(second)
    folders = (first.parent, (second or first).parent)
    check_no_input(out, [first, second, demo or demonstration_file(a, first)])
    shown = read_demonstration(demo) if demo else demonstration_beside(a, first)
    text = page(compare(a, b), folders, shown)
    with written_whole(out) as partial:
        partial.write_text(text, encoding="utf-8")
    if json:
        print_json({"file": str(out), "bytes": len(text.encode())})
    else:
        answers.print(f"wrote {out}: open it in a browser")


def _chosen(first: Path, second: Path | None) -> tuple[Path, Path | None]:
    """Return the files that are shown: of folders, the first ones that are worth looking at."""
    if second is None and first.is_dir():
        files = traces_in(first)
        failed = (file for file in files if (end := read_trace(file).end) is None or end.success is False)
        shown = next(failed, files[0])
        messages.print(f"of {counted(len(files), 'trace')}: {shown.name}")
        return shown, None
    if second is None or not (first.is_dir() or second.is_dir()):
        return first, second
    both = pairs(first, second)
    different = (pair for pair in both if compare(read_trace(pair[0]), read_trace(pair[1])).first)
    a, b = next(different, both[0])
    messages.print(f"of {counted(len(both), 'pair')}: {a.name}")
    return a, b
