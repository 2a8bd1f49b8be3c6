"""`ntp trace report`: many episodes as a page, with a page for each that is worth looking at."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.display import answers, print_json, progress
from ntp_dsl.cli.options import Json
from ntp_dsl.cli.shown_beside import demonstration_beside
from ntp_dsl.cli.trace_folders import readable, reference, traces_in
from ntp_dsl.common.files import written_whole
from ntp_dsl.common.text import counted
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.page.page import page
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.report.figures import Report
from ntp_dsl.traces.report.report_page import is_report, report_page

INDEX = "index.html"
PAGES = "episodes"  # folder of their pages, numbered as the report lists them


def command(
    folders: Annotated[list[Path], typer.Argument(metavar="DIR…", help="Folders of traces.")],
    out: Annotated[Path, typer.Option(help="Folder for the report.")] = Path("report"),
    against: Annotated[
        Path | None,
        typer.Option(help="Folder with the expert's traces of the same names, to compare each with."),
    ] = None,
    worst: Annotated[int, typer.Option(min=0, help="Number of episodes that get a page of their own.")] = 20,
    json: Json = False,
) -> None:
    """Write a report of many episodes as a page for a browser.

    It shows success by task and cause, the first divergences by line, how far probabilities can be relied
    on, the source with figures at each line, and the episodes to look at: those that failed, then the least
    sure. Each of them has a page of its own, as `ntp trace view` writes it.

    Example: ntp trace report runs/learned --against runs/scripted --out report
    """
    files = dict(_named(folders))
    _check_free(out)
    report = Report()
    with progress("reading", len(files)) as bar:
        for name, file in files.items():
            _count(report, name, file, against)
            bar.advance()
    if not report.episodes:
        raise NtpError("expected traces with at least a first line, found none; run the episodes again")
    (out / PAGES).mkdir(parents=True, exist_ok=True)
    listed = report.worst(worst)
    pages = {row.name: f"{PAGES}/{place:03d}.html" for place, row in enumerate(listed, 1)}
    with progress("writing pages", len(listed)) as bar:
        for row in listed:
            _write(out / pages[row.name], _page(files[row.name], against))
            bar.advance()
    title = f"Report of {', '.join(folder.resolve().name for folder in folders)}"
    _write(out / INDEX, report_page(report, title, worst, pages))
    if json:
        print_json(
            {
                "file": str(out / INDEX),
                "episodes": len(report.episodes),
                "succeeded": report.succeeded,
                "pages": len(pages),
            }
        )
        return
    others = len(report.episodes) - report.judged
    unjudged = f"; {others} not judged" if others else ""
    answers.print(f"{report.succeeded} of {counted(report.judged, 'episode')} succeeded{unjudged}")
    answers.print(f"wrote {out / INDEX}: open it in a browser")


def _check_free(out: Path) -> None:
    """Raise `NtpError` where a report would replace what is none."""
    index = out / INDEX
    if index.is_file() and is_report(index):
        return
    for path in (index, out / PAGES):
        if path.exists():
            raise NtpError(f"{path} is there, and of no earlier report: choose another --out")


def _named(folders: list[Path]) -> list[tuple[str, Path]]:
    """Return the traces by name: of several folders, with the folder's."""
    several = len(folders) > 1
    found = []
    for folder in folders:
        for file in traces_in(folder):
            name = file.name.removesuffix(".trace.jsonl")
            found.append((f"{folder.name}/{name}" if several else name, file))
    names = [name for name, _ in found]
    if len(set(names)) < len(names):
        raise NtpError("two of the folders have the same name; give folders whose last names differ")
    return found


def _count(report: Report, name: str, file: Path, against: Path | None) -> None:
    trace = readable(file)
    if trace is None:
        return
    report.add(name, trace)
    if (other := reference(file, against)) is not None:
        report.compare(name, compare(other, trace))


def _page(file: Path, against: Path | None) -> str:
    """Return the page of an episode, beside its reference where there is one."""
    trace = read_trace(file)
    other = reference(file, against)
    folders = (file.parent if against is None or other is None else against, file.parent)
    return page(compare(other or trace, trace), folders, demonstration_beside(trace, file))


def _write(path: Path, text: str) -> None:
    with written_whole(path) as partial:
        partial.write_text(text, encoding="utf-8")
