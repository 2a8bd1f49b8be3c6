"""`ntp trace coverage`: a library's source, with figures from many traces at each line."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.text import Text

from ntp_dsl.cli.display import answers, messages, print_json, progress
from ntp_dsl.cli.options import Json
from ntp_dsl.cli.trace_folders import readable, reference, traces_in
from ntp_dsl.common.resources import library_folder
from ntp_dsl.common.text import counted
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import load
from ntp_dsl.language.registry import Registry
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.coverage import Coverage, Line
from ntp_dsl.traces.sources import library_sources


def command(
    library: Annotated[Path, typer.Argument(help="The library of the traces.")],
    files: Annotated[list[Path], typer.Argument(metavar="TRACE…", help="Traces, or folders of traces.")],
    against: Annotated[
        Path | None,
        typer.Option(help="Folder with the expert's traces of the same names, to count first divergences."),
    ] = None,
    json: Json = False,
) -> None:
    """Show a library's source with figures from many traces at each line.

    These are the number of calls, the share that succeeded, the mean probability of the decisions, how many
    reported success without what they are to achieve, and what failures are attributed to. For a program's
    header line they are of its returns.

    Example: ntp trace coverage block_stacking runs/learned --against runs/scripted
    """
    registry = load(library)
    covered = _covered(list(_found(files)), against)
    now = library_sources(registry)
    sources = now | {name: text for name, text in covered.sources.items() if name in now}
    for name in sorted(name for name in sources if sources[name] != now[name]):
        messages.print(f"{name} has changed since: its lines are shown as the traces have them")
    unknown = sorted({place.rpartition(":")[0] for place in covered.lines} - sources.keys())
    if unknown:
        raise NtpError(f"the traces refer to {', '.join(unknown)}, which '{registry.name}' does not use")
    if json:
        rows = {place: _row(line) for place, line in sorted(covered.lines.items())}
        print_json({"library": registry.name, "traces": covered.traces, "lines": rows})
        return
    answers.print(_summary(covered))
    statements = _statements(registry)
    shipped = {path.name for path in library_folder().glob("*.ntp")}
    for name, text in sorted(
        sources.items(), key=lambda each: each[0] in shipped
    ):  # the user's own come first
        answers.print(Text(name, style="bold"))
        answers.print(Text("  calls     ok     p  ", style="dim").append("attributed to, divergences"))
        for row in _listing(name, text, covered, statements):
            answers.print(row, no_wrap=True, overflow="ellipsis", crop=answers.is_terminal)


def _summary(covered: Coverage) -> str:
    """Return in a line what there is to see below."""
    calls = sum(line.calls for line in covered.lines.values())
    failed = calls - sum(line.succeeded for line in covered.lines.values())
    parts = [
        f"{counted(covered.traces, 'trace')}: {covered.succeeded} succeeded; "
        f"{failed} of {calls} calls and returns failed"
    ]
    diverged = Counter({place: line.divergences.total() for place, line in covered.lines.items()})
    if worst := [(place, count) for place, count in diverged.most_common(1) if count]:
        parts.append(f"most divergences at {worst[0][0]} ({worst[0][1]} of {diverged.total()})")
    failures = Counter({place: line.calls - line.succeeded for place, line in covered.lines.items()})
    if worst := [(place, count) for place, count in failures.most_common(1) if count]:
        parts.append(f"most failed calls at {worst[0][0]} ({worst[0][1]})")
    return "; ".join(parts)


def _found(files: list[Path]) -> Iterator[Path]:
    for file in files:
        yield from traces_in(file) if file.is_dir() else [file]


def _covered(files: list[Path], against: Path | None) -> Coverage:
    covered = Coverage()
    with progress("reading", len(files)) as bar:
        for file in files:
            _count(covered, file, against)
            bar.advance()
    if not covered.traces:
        raise NtpError("expected traces with at least a first line, found none; run the episodes again")
    return covered


def _count(covered: Coverage, file: Path, against: Path | None) -> None:
    """Count a trace; one that cannot be read, or was killed before its first line, is named and skipped."""
    trace = readable(file)
    if trace is None:
        return
    covered.add(trace)
    if (other := reference(file, against)) is not None:
        covered.compare(compare(other, trace))


def _statements(registry: Registry) -> set[str]:
    """Return the locations of all lines that can be counted."""
    programs = registry.programs.values()
    spans = [row.span for row in programs]
    spans += [each.span for row in programs for each in row.statements()]
    return {f"{span.path.name}:{span.line}" for span in spans if span.path}


def _listing(name: str, text: str, covered: Coverage, statements: set[str]) -> Iterator[Text]:
    for number, source in enumerate(text.rstrip("\n").split("\n"), 1):
        place = f"{name}:{number}"
        line = covered.lines.get(place)
        if line is not None:
            row = _counted(line)
        else:
            row = Text("  never" if place in statements else "", style="yellow")
        row.pad_right(max(0, 46 - len(row)))
        yield row.append(f"{number:4} ", style="dim").append(source, style="default")


def _counted(line: Line) -> Text:
    succeeded = f"{line.succeeded / line.calls:.0%}" if line.calls else "–"
    probability = f"{line.probability:.2f}" if line.probability is not None else "–"
    row = Text(f"{line.calls:7} {succeeded:>6} {probability:>5}  ", style="default")
    row.append(f"not achieved {line.unmet} " if line.unmet else "", style="red")
    for kinds, style in ((line.attributed_to, "red"), (line.divergences, "magenta")):
        counts = ", ".join(f"{kind} {count}" for kind, count in sorted(kinds.items()))
        row.append(f"{counts} " if counts else "", style=style)
    return row


def _row(line: Line) -> dict[str, Any]:
    return {
        "calls": line.calls,
        "succeeded": line.succeeded,
        "unmet": line.unmet,
        "probability": line.probability,
        "attributed_to": dict(sorted(line.attributed_to.items())),
        "divergences": dict(sorted(line.divergences.items())),
    }
