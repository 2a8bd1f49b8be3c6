"""What traces did at each line of a library: how often, how well, how surely, and why it failed."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass, field

from ntp_dsl.traces.comparison.comparison import Comparison
from ntp_dsl.traces.failure_attribution import of_all
from ntp_dsl.traces.schema import ROOT, Attribution, Call, Trace


@dataclass
class Line:
    """A statement, by the calls that it made; or a program's own line, by its runs."""

    calls: int = 0
    well: int = 0
    attributed_to: Counter[Attribution] = field(default_factory=Counter)  # calls that did not go well
    parted: Counter[str] = field(default_factory=Counter)  # divergences from another trace, by kind
    weighed: int = 0  # decisions that came with a probability
    _sum: float = 0.0

    @property
    def probability(self) -> float | None:
        """Return the mean of the decisions; None where a script made them."""
        return self._sum / self.weighed if self.weighed else None

    def count(self, call: Call, attribution: Attribution | None, probability: float | None) -> None:
        """Add a call that the line made, or a return of the line's program."""
        self.calls += 1
        self.well += call.went_well
        if attribution:
            self.attributed_to[attribution] += 1
        if probability is not None:
            self.weighed += 1
            self._sum += probability


class Coverage:
    """Lines by their place, `file:line`, over as many traces as are added."""

    def __init__(self) -> None:
        self.lines: defaultdict[str, Line] = defaultdict(Line)
        self.traces = 0

    def add(self, trace: Trace) -> None:
        """Count statements by the calls that they made; a program's line by how it decided to return."""
        self.traces += 1
        for call, attribution in zip(trace.calls, of_all(trace), strict=True):
            if call.parent != ROOT and (place := call.decision.source):
                self.lines[place].count(call, attribution, call.decision.probability)
            if call.ending and (place := call.ending.source):
                self.lines[place].count(call, attribution, call.ending.probability)

    def compare(self, comparison: Comparison) -> None:
        """Count where the second trace leaves the first; what follows from that is not counted."""
        first = comparison.first
        told = comparison.divergences if comparison.b.is_replayed else [first] if first else []
        for divergence in told:
            if divergence.source:
                self.lines[divergence.source].parted[str(divergence.kind)] += 1
