"""The figures of many episodes: success, causes of failure, divergences, and the worth of probabilities."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from dataclasses import dataclass, field

from ntp_dsl.common.proportions import wilson
from ntp_dsl.traces.comparison.comparison import Comparison
from ntp_dsl.traces.coverage import Coverage
from ntp_dsl.traces.explanation import interesting
from ntp_dsl.traces.phrases import format_call
from ntp_dsl.traces.report.reliability import Reliability
from ntp_dsl.traces.trace import Trace

UNKNOWN = "unknown"
NUMBERED = re.compile(r"\w*_\d+\b|\d+(\.\d+)?")  # objects and numbers, which differ by episode


@dataclass(frozen=True)
class EpisodeRow:
    """An episode, in a line."""

    name: str  # of the trace's file, without its ending
    task: str
    success: bool | None  # None where it was not judged
    attributed_to: str
    said: str  # the ending or the verdict, in words
    confidence: float | None
    least: float | None  # of its decisions' probabilities
    worth_asking: str  # the call that `ntp trace explain` explains; empty for a success


@dataclass
class TaskFigures:
    """The episodes of a task."""

    episodes: int = 0  # that were judged
    succeeded: int = 0
    unjudged: int = 0
    causes: Counter[str] = field(default_factory=Counter)  # of failed episodes

    @property
    def interval(self) -> tuple[float, float]:
        """Return the 95 % interval of the share that succeeded."""
        return wilson(self.succeeded, self.episodes) if self.episodes else (0.0, 1.0)


@dataclass
class Divergences:
    """First divergences at a line, by kind, with the episodes that diverge there."""

    kinds: Counter[str] = field(default_factory=Counter)
    episodes: list[str] = field(default_factory=list)


class Report:
    """The figures of all traces that were added."""

    def __init__(self) -> None:
        self.tasks: defaultdict[str, TaskFigures] = defaultdict(TaskFigures)
        self.episodes: list[EpisodeRow] = []
        self.failures: Counter[str] = Counter()  # what is said of failed episodes, without names of objects
        self.confidence = Reliability()  # of episodes
        self.facts: defaultdict[str, Reliability] = defaultdict(Reliability)  # by predicate
        self.divergences: defaultdict[str, Divergences] = defaultdict(Divergences)  # by file:line
        self.compared = 0
        self.libraries: set[str] = set()  # of the tasks
        self.coverage = Coverage()

    def add(self, name: str, trace: Trace) -> None:
        """Count an episode."""
        self.libraries.add(trace.header.library)
        row = _row(name, trace)
        self.episodes.append(row)
        task = self.tasks[row.task]
        task.episodes += row.success is not None
        task.unjudged += row.success is None
        task.succeeded += row.success is True
        if row.success is False:
            task.causes[row.attributed_to] += 1
            self.failures[NUMBERED.sub("…", row.said)] += 1
        if row.confidence is not None and row.success is not None:
            self.confidence.add(row.confidence, row.success)
        for decision in trace.decisions():
            for fact in decision.facts:
                if fact.truth is not None and trace.is_learned:
                    self.facts[fact.fact.partition("(")[0]].add(fact.probability, fact.truth)
        self.coverage.add(trace)

    def compare(self, name: str, comparison: Comparison) -> None:
        """Count the first divergence of an episode from its reference."""
        self.compared += 1
        self.coverage.compare(comparison)
        if (first := comparison.first) is not None:
            found = self.divergences[first.source or "the run itself"]
            found.kinds[str(first.kind)] += 1
            found.episodes.append(name)

    @property
    def succeeded(self) -> int:
        """Return the number of episodes that did."""
        return sum(each.success is True for each in self.episodes)

    @property
    def judged(self) -> int:
        """Return the number of episodes that were judged."""
        return sum(each.success is not None for each in self.episodes)

    def worst(self, count: int) -> list[EpisodeRow]:
        """Return the episodes to look at: failed ones first, and of each those that were least sure."""
        return sorted(self.episodes, key=_badness)[:count]


def _badness(row: EpisodeRow) -> tuple[bool, float, str]:
    sure, failed = 1.0 if row.confidence is None else row.confidence, row.success is False
    return not failed, -sure if failed else sure, row.name


def _row(name: str, trace: Trace) -> EpisodeRow:
    end = trace.end
    success = False if end is None else end.success
    failed = interesting(trace) if success is False else None
    return EpisodeRow(
        name=name,
        task=trace.header.task or UNKNOWN,
        success=success,
        attributed_to=str(end.attributed_to) if end is not None and end.attributed_to else UNKNOWN,
        said="cut off" if end is None else end.verdict or end.reason or str(end.ending),
        confidence=None if end is None else end.confidence,
        least=None if end is None else end.least,
        worth_asking="" if failed is None else format_call(failed),
    )
