"""What a comparison finds: two traces side by side, and the places where they part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ntp_dsl.traces.comparison.alignment import Level
from ntp_dsl.traces.comparison.comparison_rules import Kind
from ntp_dsl.traces.comparison.confidence import Confidence
from ntp_dsl.traces.decision import Answer
from ntp_dsl.traces.schema import Attribution, Trace


@dataclass(frozen=True)
class Divergence:
    """A decision, or what came of one, in which the second trace is not as the first.

    The moment is that of a call, or of the callers' return where a trace makes none.
    """

    kind: Kind
    caller_a: int  # ROOT for the run itself
    caller_b: int
    a: int | None  # what the first trace called then; None where it returned
    b: int | None
    attributed_to: Attribution | None  # None where one of the files ends
    source: str  # file:line of the statement that the first trace followed; empty where unknown
    confidence: Confidence  # of the second trace's decision
    apart: float | None = None  # [m] at the most, between the states of the two decisions
    answer: Answer | None = None  # of a policy that was only asked


@dataclass(frozen=True, repr=False)
class Comparison:
    """Two traces side by side, and where they part, in the order of execution."""

    a: Trace
    b: Trace
    levels: Sequence[Level]
    divergences: Sequence[Divergence]

    @property
    def first(self) -> Divergence | None:
        """Return the first divergence; None where the traces are the same."""
        return self.divergences[0] if self.divergences else None

    @property
    def summary(self) -> str:
        """Return in a sentence where the second trace leaves the first."""
        if self.first is None:
            return "The two traces are the same."
        more = len(self.divergences) - 1
        cause = f", attributed to {self.first.attributed_to}" if self.first.attributed_to else ""
        place = f" at {self.first.source}" if self.first.source else ""
        return f"First divergence: {self.first.kind}{place}{cause}{f'; {more} more' if more else ''}."

    def __repr__(self) -> str:
        return f"<Comparison. {self.summary}>"
