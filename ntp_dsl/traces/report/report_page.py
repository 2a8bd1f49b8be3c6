"""The report of many episodes as a page for a browser: no script, nothing from the network."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from ntp_dsl.traces.coverage import Line
from ntp_dsl.traces.library_text import statement_lines
from ntp_dsl.traces.page.page_parts import content_hash, joined
from ntp_dsl.traces.report.figures import Report
from ntp_dsl.traces.report.reliability import Reliability

GENERATOR = "ntp trace report"  # by which a report is known
PARTS = Path(__file__).parent
VIEWER = PARTS.parent / "page" / "viewer"


@dataclass(frozen=True)
class SourceLine:
    """A line of a library with its figures; None where it is no statement, or was never reached."""

    number: int
    text: str
    figures: Line | None
    never: bool


def report_page(report: Report, title: str, worst: int, pages: Mapping[str, str]) -> str:
    """Return the report as HTML.

    Args:
        worst: number of episodes to list.
        pages: name of an episode -> address of its own page, where there is one.
    """
    style = joined(VIEWER, ["palette.css"]) + joined(PARTS, ["report.css"])
    environment = Environment(loader=FileSystemLoader(PARTS), autoescape=True, undefined=StrictUndefined)
    environment.trim_blocks = environment.lstrip_blocks = True
    return environment.get_template("report.html").render(
        title=title,
        generator=GENERATOR,
        style=style,
        policy=f"default-src 'none'; style-src '{content_hash(style)}'; base-uri 'none'; form-action 'none'",
        report=report,
        causes=_causes(report),
        episodes=report.worst(worst),
        pages=pages,
        curves=_curves(report),
        divergences=sorted(report.divergences.items(), key=lambda each: -each[1].kinds.total()),
        sources={name: [*_listing(report, name, text)] for name, text in _sources(report)},
    )


def is_report(page: Path) -> bool:
    """Return whether a file is a report."""
    return f'name="generator" content="{GENERATOR}"' in page.read_text(encoding="utf-8", errors="replace")


def _causes(report: Report) -> list[str]:
    return sorted({cause for task in report.tasks.values() for cause in task.causes})


def _curves(report: Report) -> list[tuple[str, Reliability]]:
    """Return the probabilities that there are: of episodes, and of facts by predicate, the worst first."""
    facts = sorted(report.facts.items(), key=lambda each: -each[1].error)
    named = [("success of an episode", report.confidence), *facts]
    return [(name, curve) for name, curve in named if curve.count]


def _sources(report: Report) -> list[tuple[str, str]]:
    """Return the libraries of the episodes' tasks, and then those that they use."""
    own = {f"{library}.ntp" for library in report.libraries}
    return sorted(report.coverage.sources.items(), key=lambda each: (each[0] not in own, each[0]))


def _listing(report: Report, name: str, text: str) -> Iterator[SourceLine]:
    statements = statement_lines(text)
    for number, line in enumerate(text.rstrip("\n").split("\n"), 1):
        figures = report.coverage.lines.get(f"{name}:{number}")
        yield SourceLine(number, line, figures, figures is None and number in statements)
