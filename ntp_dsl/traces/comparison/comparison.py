"""Results of a comparison: two aligned traces and their divergences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ntp_dsl.common.text import printable
from ntp_dsl.traces.comparison.alignment import Level
from ntp_dsl.traces.comparison.comparison_rules import DivergenceKind
from ntp_dsl.traces.comparison.confidence import Confidence
from ntp_dsl.traces.comparison.state_differences import StateDifferences
from ntp_dsl.traces.decision import Answer
from ntp_dsl.traces.schema import Attribution
from ntp_dsl.traces.trace import Trace


@dataclass(frozen=True)
class Divergence:
    """A decision, or its outcome, in which the second trace differs from the first.

    It occurs at a call, or at the return of the caller where a trace makes none.
    """

    kind: DivergenceKind
    caller_a: int  # ROOT for the run itself
    caller_b: int
    a: int | None  # the call of the first trace; None where it returned
    b: int | None
    attributed_to: Attribution | None  # None where one of the traces was cut off
    source: str  # file:line of the statement that the first trace followed; empty where unknown
    confidence: Confidence  # of the second trace's decision
    states: StateDifferences | None = None  # between the states of the two decisions; None where unknown
    answer: Answer | None = None  # of a replay


@dataclass(frozen=True, repr=False)
class Comparison:
    """Two aligned traces, and their divergences in order of execution."""

    a: Trace
    b: Trace
    levels: Sequence[Level]
    divergences: Sequence[Divergence]

    @property
    def first(self) -> Divergence | None:
        """Return the first divergence; None where the traces are the same."""
        return self.divergences[0] if self.divergences else None

    @property
    def verdicts(self) -> str:
        """Return how the two runs were judged; empty where that is the same, or not known."""
        ends = [self.a.end, self.b.end]
        judged = [(end.success, end.verdict) for end in ends if end is not None and end.success is not None]
        if len(judged) < 2 or judged[0][0] == judged[1][0]:
            return ""
        told = ("succeeded" if success else f"failed: {verdict}" for success, verdict in judged)
        return printable("; ".join(f"{side} {text}" for side, text in zip("AB", told, strict=True)))

    @property
    def is_same(self) -> bool:
        """Whether the calls are the same, and were judged alike."""
        return self.first is None and not self.verdicts

    @property
    def summary(self) -> str:
        """Return in a sentence where the second trace leaves the first."""
        if self.first is None:
            calls = "The two traces are the same."
            return f"The same calls, judged otherwise: {self.verdicts}." if self.verdicts else calls
        more = len(self.divergences) - 1
        cause = f", attributed to {self.first.attributed_to}" if self.first.attributed_to else ""
        place = f" at {self.first.source}" if self.first.source else ""
        return f"First divergence: {self.first.kind}{place}{cause}{f'; {more} more' if more else ''}."

    def __repr__(self) -> str:
        return f"<Comparison. {self.summary}>"
