"""`ntp trace view`: one trace, or two side by side, as a page for a browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.display import answers, print_json
from ntp_dsl.cli.options import Json
from ntp_dsl.common.files import written_whole
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.demonstrations.demonstration_files import read_demonstration
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.page.page import page
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import Trace


def command(
    first: Annotated[Path, typer.Argument(metavar="A", help="A trace; of two, the one that is right.")],
    second: Annotated[
        Path | None, typer.Argument(metavar="[B]", help="The trace that is compared with it.")
    ] = None,
    out: Annotated[Path, typer.Option(help="The file to write.")] = Path("trace.html"),
    demo: Annotated[
        Path | None, typer.Option(help="The demonstration; by default the one that lies beside the trace.")
    ] = None,
    json: Json = False,
) -> None:
    """Write one self-contained HTML file: both call trees aligned, scopes over the demonstration, the motion
    of all objects, what else each decision might have been, and what the camera saw.

    It opens in any browser, fetches nothing and carries nothing of a trace out.

    Example: ntp trace view scripted.trace.jsonl learned.trace.jsonl --out both.html
    """
    a = read_trace(first)
    b = a if second is None else read_trace(second)
    folders = (first.parent, (second or first).parent)
    text = page(compare(a, b), folders, _demonstration(a, first, demo))
    with written_whole(out) as partial:
        partial.write_text(text, encoding="utf-8")
    if json:
        print_json({"file": str(out), "bytes": len(text.encode())})
    else:
        answers.print(f"wrote {out}: open it in a browser")


def _demonstration(trace: Trace, file: Path, given: Path | None) -> Demonstration | None:
    if given is not None:
        return read_demonstration(given)
    shown = trace.header.demonstration
    beside = file.parent / Path(shown.file).name if shown is not None and shown.file else None
    return read_demonstration(beside) if beside is not None and beside.is_file() else None
