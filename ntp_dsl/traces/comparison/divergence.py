"""Divergences of two traces: their kind, confidence and attribution."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import groupby
from math import inf

from ntp_dsl.semantics.observation import Observation
from ntp_dsl.traces.comparison.alignment import Level, Pair, align
from ntp_dsl.traces.comparison.comparison import Comparison, Divergence
from ntp_dsl.traces.comparison.comparison_rules import DivergenceKind, Rules
from ntp_dsl.traces.comparison.confidence import confidence
from ntp_dsl.traces.comparison.state_differences import StateDifferences, state_differences
from ntp_dsl.traces.comparison.teacher_forcing import disagreements
from ntp_dsl.traces.decision import Decision
from ntp_dsl.traces.failure_attribution import attribute_call
from ntp_dsl.traces.schema import ROOT, Attribution, Call
from ntp_dsl.traces.trace import Trace
from ntp_dsl.worlds.protocol import UNDISTURBED

STATE_TOLERANCE = 0.01  # [m] between positions in two states that count as the same
MOST_NOISE = 4.5  # standard deviations by which one look of many is off, at most


def compare(a: Trace, b: Trace, scopes: bool = True) -> Comparison:
    """Compare a trace with a reference, the first: the expert's, or that of an older checkpoint."""
    rules = Rules.between(a, b, scopes)
    levels = align(a, b, rules)
    if b.is_replayed:
        return Comparison(a, b, levels, disagreements(a, b, rules))
    finder = _Finder(a, b, rules)
    divergences = [each for level in levels for each in finder.within(level)]
    return Comparison(a, b, levels, sorted(divergences, key=finder.position))


class _Finder:
    """Finds the divergences of an alignment, level by level."""

    def __init__(self, a: Trace, b: Trace, rules: Rules) -> None:
        self.a, self.b, self.rules = a, b, rules
        self.last_below = _last_below(a)
        self.disturbed = _earliest(b, lambda call: bool(call.execution.disturbances))

    def within(self, level: Level) -> Iterator[Divergence]:
        """Yield the divergences between the calls of two matched callers."""
        matched = 0
        for is_gap, group in groupby(level.pairs, lambda pair: None in pair):
            run = list(group)
            if is_gap:
                yield self._gap(level, run, level.pairs[matched + len(run) :])
            else:
                for a, b in run:
                    assert a is not None and b is not None
                    yield from self._matched(level, self.a.calls[a], self.b.calls[b])
            matched += len(run)
        if level.caller_a != ROOT and all(None not in pair for pair in level.pairs):
            yield from self._ended(self.a.calls[level.caller_a], self.b.calls[level.caller_b])

    def position(self, divergence: Divergence) -> tuple[float, float]:
        """Return a sort key by the first trace's events: calls by number, returns after all calls below."""
        if divergence.kind is DivergenceKind.OUTCOME and divergence.a is not None:
            return self.last_below[divergence.a] + 0.5, -divergence.a
        if divergence.a is not None:
            return divergence.a, 0
        if divergence.caller_a == ROOT:
            return inf, 0
        return self.last_below[divergence.caller_a] + 0.5, -divergence.caller_a

    def _gap(self, level: Level, gap: list[Pair], after: Sequence[Pair]) -> Divergence:
        """Return the divergence at unmatched calls: what each trace did there, a call or a return."""
        ahead = [*gap, *after[:1]]
        x = next((self.a.calls[a] for a, _ in ahead if a is not None), None)
        y = next((self.b.calls[b] for _, b in ahead if b is not None), None)
        return self._divergence(self._kind_of_gap(level, x, y), level, x, y)

    def _kind_of_gap(self, level: Level, x: Call | None, y: Call | None) -> DivergenceKind:
        if x is None or y is None:
            trace, caller = (self.a, level.caller_a) if x is None else (self.b, level.caller_b)
            ended = trace.end is not None if caller == ROOT else trace.calls[caller].outcome is not None
            if not ended:
                return DivergenceKind.CUT_OFF
            return DivergenceKind.TOO_LATE if x is None else DivergenceKind.TOO_EARLY
        return DivergenceKind.PROGRAM if x.name != y.name or x.kind != y.kind else DivergenceKind.ARGUMENT

    def _matched(self, level: Level, x: Call, y: Call) -> Iterator[Divergence]:
        """Yield a divergence where two matched calls differ in arguments or scope."""
        if self.rules.label(x) != self.rules.label(y) or not self.rules.same_numbers(x, y):
            yield self._divergence(DivergenceKind.ARGUMENT, level, x, y)
        elif not self.rules.same_scope(x, y):
            yield self._divergence(DivergenceKind.SCOPE, level, x, y)

    def _ended(self, x: Call, y: Call) -> Iterator[Divergence]:
        """Yield a divergence where two calls with matched children differ in their outcome."""
        if self.rules.outcome(x) != self.rules.outcome(y):
            kind = DivergenceKind.OUTCOME if x.outcome and y.outcome else DivergenceKind.CUT_OFF
            level = Level(x.parent, y.parent, 0, ())
            yield self._divergence(kind, level, x, y)

    def _divergence(self, kind: DivergenceKind, level: Level, x: Call | None, y: Call | None) -> Divergence:
        apart = state_differences(
            self._state(self.a, x, level.caller_a), self._state(self.b, y, level.caller_b)
        )
        followed = x.decision if x else self._returned(self.a, level.caller_a)
        decision = y.decision if y else self._returned(self.b, level.caller_b)
        return Divergence(
            kind,
            level.caller_a,
            level.caller_b,
            x.id if x else None,
            y.id if y else None,
            self._attribution(kind, x, y, apart, decision),
            followed.source if followed else "",
            confidence(kind, decision, x, y),
            apart,
        )

    def _attribution(
        self,
        kind: DivergenceKind,
        x: Call | None,
        y: Call | None,
        apart: StateDifferences | None,
        decision: Decision | None,
    ) -> Attribution | None:
        if kind is DivergenceKind.CUT_OFF:
            return None
        if kind is DivergenceKind.OUTCOME:
            assert x is not None and y is not None
            return attribute_call(y) or attribute_call(x) or Attribution.DECISION
        made = [trace.header.disturbances or UNDISTURBED for trace in (self.a, self.b)]
        tolerance = STATE_TOLERANCE + max(MOST_NOISE * each.noise + each.camera_offset for each in made)
        misleads = any(each.misleads for each in made)
        if apart is None or apart.largest <= tolerance:
            misled = misleads and decision is not None and bool(decision.mistaken)
            return Attribution.NOISE if misled else Attribution.DECISION
        # The states differ although all calls so far are the same.
        if y is not None and self.disturbed < y.id:
            return Attribution.DISTURBANCE
        initial = state_differences(_first_state(self.a), _first_state(self.b))
        if initial is None or initial.largest > tolerance:
            return Attribution.START
        return Attribution.NOISE if misleads else Attribution.PHYSICS  # what was seen is where the hand went

    def _returned(self, trace: Trace, caller: int) -> Decision | None:
        return None if caller == ROOT else trace.calls[caller].return_decision

    def _state(self, trace: Trace, call: Call | None, caller: int) -> Observation | None:
        """Return the state of the decision to make the call, or of the caller's return where it is None."""
        number = call.state if call else None if caller == ROOT else trace.calls[caller].end_state
        return None if number is None else trace.states[number]


def _first_state(trace: Trace) -> Observation | None:
    return trace.states[0] if trace.states else None


def _earliest(trace: Trace, predicate: Callable[[Call], bool]) -> float:
    return next((call.id for call in trace.calls if predicate(call)), inf)


def _last_below(trace: Trace) -> list[int]:
    """Return for each call the last one below it, or itself."""
    last = list(range(len(trace.calls)))
    for call in reversed(trace.calls):
        if call.parent != ROOT:
            last[call.parent] = max(last[call.parent], last[call.id])
    return last
