"""Coverage: for each line of a library its calls, successes, probabilities and causes of failure."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass, field

from ntp_dsl.traces.comparison.comparison import Comparison
from ntp_dsl.traces.failure_attribution import attribute_all
from ntp_dsl.traces.schema import ROOT, Attribution, Call, Ending
from ntp_dsl.traces.trace import Trace


@dataclass
class Line:
    """The figures of a statement, from the calls that it made, or of a program's header, from its returns."""

    calls: int = 0
    succeeded: int = 0
    attributed_to: Counter[Attribution] = field(default_factory=Counter)  # of failed calls
    unmet: int = 0  # calls that reported success without what they are to achieve
    divergences: Counter[str] = field(default_factory=Counter)  # from another trace, by kind
    _probabilities: int = 0  # decisions with a probability
    _probability_sum: float = 0.0

    @property
    def probability(self) -> float | None:
        """Return the mean over the decisions; None for the scripted expert."""
        return self._probability_sum / self._probabilities if self._probabilities else None

    def count(self, call: Call, attribution: Attribution | None, probability: float | None) -> None:
        """Count a call that the line made, or a return of the line's program."""
        self.calls += 1
        self.succeeded += call.succeeded
        self.unmet += bool(call.execution.unmet)
        if attribution:
            self.attributed_to[attribution] += 1
        if probability is not None:
            self._probabilities += 1
            self._probability_sum += probability


class Coverage:
    """The figures of lines, by `file:line`, over all traces that were added."""

    def __init__(self) -> None:
        self.lines: defaultdict[str, Line] = defaultdict(Line)
        self.traces = 0
        self.succeeded = 0  # of them
        self.sources: dict[str, str] = {}  # file name -> text, as the first trace has it that names it

    def add(self, trace: Trace) -> None:
        """Count the calls of statements, and the returns of programs."""
        self.traces += 1
        end = trace.end
        if end is not None:
            self.succeeded += end.ending is Ending.DONE if end.success is None else end.success
        self.sources = {**trace.header.sources, **self.sources}
        for call, attribution in zip(trace.calls, attribute_all(trace.calls), strict=True):
            if call.parent != ROOT and (place := call.decision.source):
                self.lines[place].count(call, attribution, call.decision.probability)
            if call.return_decision and (place := call.return_decision.source):
                self.lines[place].count(call, attribution, call.return_decision.probability)

    def compare(self, comparison: Comparison) -> None:
        """Count the first divergence of two traces, or all of a replay, whose answers are independent."""
        first = comparison.first
        counted = comparison.divergences if comparison.b.is_replayed else [first] if first else []
        for divergence in counted:
            if divergence.source:
                self.lines[divergence.source].divergences[str(divergence.kind)] += 1
