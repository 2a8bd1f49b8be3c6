"""A trace in memory: its header, its tree of calls, the states of their decisions, and the motion."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING

from ntp_dsl.extras import needing
from ntp_dsl.semantics.observation import Observation
from ntp_dsl.traces.decision import Asked, Decision, Reading
from ntp_dsl.traces.outline import dataframe, outline
from ntp_dsl.traces.schema import ROOT, Call, End, Header, Motion, PolicyKind

if TYPE_CHECKING:
    import pandas


@dataclass(repr=False)
class Trace:
    """A trace read back; a notebook shows its call tree."""

    header: Header
    calls: list[Call] = field(default_factory=list)
    states: Sequence[Observation] = ()
    motions: list[Motion] = field(default_factory=list)
    pictures: list[tuple[int, str]] = field(
        default_factory=list
    )  # frame, path relative to the trace's folder
    end: End | None = None  # None where the writer was cut off

    @cached_property
    def _children(self) -> list[list[int]]:
        """Return the numbers of the calls that each call made; those of the root come last."""
        children: list[list[int]] = [[] for _ in range(len(self.calls) + 1)]
        for call in self.calls:
            children[call.parent].append(call.id)
        return children

    def children(self, parent: int) -> list[Call]:
        """Return the calls that a call made, or the root calls for `ROOT`."""
        return [self.calls[number] for number in self._children[parent]]

    def next_of(self, call: Call) -> Call | None:
        """Return the call that its caller made next; None where that was the last."""
        siblings = self._children[call.parent]
        place = bisect_right(siblings, call.id)
        return self.calls[siblings[place]] if place < len(siblings) else None

    def ancestors(self, number: int) -> Iterator[Call]:
        """Yield the call, its caller, and so on to the root."""
        while number != ROOT:
            call = self.calls[number]
            yield call
            number = call.parent

    def events(self) -> Iterator[tuple[Call, bool]]:
        """Yield calls and returns in order of execution, each with whether it is a return."""
        running: list[Call] = []
        for call in self.calls:
            while running and running[-1].id != call.parent:
                yield running.pop(), True
            yield call, False
            running.append(call)
        yield from ((call, True) for call in reversed(running) if call.outcome)

    def decisions(self) -> Iterator[Decision]:
        """Yield the decisions of programs, to call and to return."""
        for call in self.calls:
            if call.parent != ROOT:
                yield call.decision
            if call.return_decision is not None:
                yield call.return_decision

    def readings(self) -> Iterator[tuple[Call, Reading]]:
        """Yield what programs read of their lists, each with the program's call."""
        for call in self.calls:
            if call.decision.read is not None and call.parent != ROOT:
                yield self.calls[call.parent], call.decision.read
            if call.return_decision is not None and call.return_decision.read is not None:
                yield call, call.return_decision.read

    def questions(self) -> Iterator[tuple[Call, Observation, Asked]]:
        """Yield what somebody was asked about decisions, in order: the program's call, and the state then."""
        for call, returns in self.events():
            decision = call.return_decision if returns else call.decision
            state = call.end_state if returns else call.state
            caller = call.id if returns else call.parent
            if decision is not None and decision.asked is not None and state is not None and caller != ROOT:
                yield self.calls[caller], self.states[state], decision.asked

    @property
    def is_replayed(self) -> bool:
        """Whether it records a policy's answers at every state of another trace."""
        return self.header.policy is PolicyKind.REPLAYED

    @property
    def is_learned(self) -> bool:
        """Whether a learned core decided or answered."""
        return self.header.policy is PolicyKind.LEARNED or self.header.model is not None

    @needing("Trace.to_dataframe")
    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for each call: see `outline.dataframe`. Needs pandas, of the extra `notebook`."""
        return dataframe(self.calls)

    def __repr__(self) -> str:
        ended = "cut off" if self.end is None else str(self.end.ending)
        return f"<Trace of {self.header.task or 'a run'}: {len(self.calls)} calls, {ended}>"

    def _repr_html_(self) -> str:
        return f"<pre>{escape(outline(self.header, self.calls, self.end))}</pre>"
