"""Where two traces part, how, how surely, and what that is attributed to."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import groupby
from math import dist, inf

from ntp_dsl.semantics.observation import Observation
from ntp_dsl.traces.comparison.alignment import Level, Pair, align
from ntp_dsl.traces.comparison.comparison import Comparison, Divergence
from ntp_dsl.traces.comparison.comparison_rules import Kind, Rules
from ntp_dsl.traces.comparison.confidence import confidence
from ntp_dsl.traces.comparison.teacher_forcing import disagreements
from ntp_dsl.traces.decision import Decision
from ntp_dsl.traces.failure_attribution import of_call
from ntp_dsl.traces.schema import ROOT, Attribution, Call, Trace

ALIKE = 0.01  # [m] that objects may lie apart in two states that count as one


def compare(a: Trace, b: Trace, scopes: bool = True) -> Comparison:
    """The first trace is the one that is right: the script's, or the older checkpoint's."""
    rules = Rules.between(a, b, scopes)
    levels = align(a, b, rules)
    if b.is_replayed:
        return Comparison(a, b, levels, disagreements(a, b, rules))
    finder = _Finder(a, b, rules)
    found = [each for level in levels for each in finder.within(level)]
    return Comparison(a, b, levels, sorted(found, key=finder.moment))


class _Finder:
    """Finds the divergences of an alignment, level by level."""

    def __init__(self, a: Trace, b: Trace, rules: Rules) -> None:
        self.a, self.b, self.rules = a, b, rules
        self.last_below = _last_below(a)
        self.disturbed = _earliest(b, lambda call: bool(call.execution.disturbances))

    def within(self, level: Level) -> Iterator[Divergence]:
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

    def moment(self, divergence: Divergence) -> tuple[float, float]:
        """Its place among the events of the first trace: calls by number, a return after all below it."""
        if divergence.kind is Kind.OUTCOME and divergence.a is not None:
            return self.last_below[divergence.a] + 0.5, -divergence.a
        if divergence.a is not None:
            return divergence.a, 0
        if divergence.caller_a == ROOT:
            return inf, 0
        return self.last_below[divergence.caller_a] + 0.5, -divergence.caller_a

    def _gap(self, level: Level, gap: list[Pair], after: Sequence[Pair]) -> Divergence:
        """Calls that only one has: what each trace did there, be it to return."""
        ahead = [*gap, *after[:1]]
        x = next((self.a.calls[a] for a, _ in ahead if a is not None), None)
        y = next((self.b.calls[b] for _, b in ahead if b is not None), None)
        return self._divergence(self._kind_of_gap(level, x, y), level, x, y)

    def _kind_of_gap(self, level: Level, x: Call | None, y: Call | None) -> Kind:
        if x is None or y is None:
            trace, caller = (self.a, level.caller_a) if x is None else (self.b, level.caller_b)
            ended = trace.end is not None if caller == ROOT else trace.calls[caller].outcome is not None
            if not ended:
                return Kind.CUT_OFF
            return Kind.TOO_LATE if x is None else Kind.TOO_EARLY
        return Kind.PROGRAM if x.name != y.name or x.kind != y.kind else Kind.ARGUMENT

    def _matched(self, level: Level, x: Call, y: Call) -> Iterator[Divergence]:
        """Of two calls that stand for each other: what they are called on, and given."""
        if self.rules.label(x) != self.rules.label(y) or not self.rules.same_numbers(x, y):
            yield self._divergence(Kind.ARGUMENT, level, x, y)
        elif not self.rules.same_scope(x, y):
            yield self._divergence(Kind.SCOPE, level, x, y)

    def _ended(self, x: Call, y: Call) -> Iterator[Divergence]:
        """Of two calls whose own calls are matched: what they came to."""
        if self.rules.outcome(x) != self.rules.outcome(y):
            kind = Kind.OUTCOME if x.outcome and y.outcome else Kind.CUT_OFF
            level = Level(x.parent, y.parent, 0, ())
            yield self._divergence(kind, level, x, y)

    def _divergence(self, kind: Kind, level: Level, x: Call | None, y: Call | None) -> Divergence:
        apart = distance(self._state(self.a, x, level.caller_a), self._state(self.b, y, level.caller_b))
        followed = x.decision if x else self._returned(self.a, level.caller_a)
        decision = y.decision if y else self._returned(self.b, level.caller_b)
        return Divergence(
            kind,
            level.caller_a,
            level.caller_b,
            x.id if x else None,
            y.id if y else None,
            self._attribution(kind, x, y, apart),
            followed.source if followed else "",
            confidence(kind, decision, x, y),
            apart,
        )

    def _attribution(
        self, kind: Kind, x: Call | None, y: Call | None, apart: float | None
    ) -> Attribution | None:
        if kind is Kind.CUT_OFF:
            return None
        if kind is Kind.OUTCOME:
            assert x is not None and y is not None
            return of_call(y) or of_call(x) or Attribution.DECISION
        if apart is None or apart <= ALIKE:
            return Attribution.DECISION
        # Off course: the states differ although all that was done is the same.
        if y is not None and self.disturbed < y.id:
            return Attribution.DISTURBANCE
        began = distance(_first_state(self.a), _first_state(self.b))
        return Attribution.START if began is None or began > ALIKE else Attribution.PHYSICS

    def _returned(self, trace: Trace, caller: int) -> Decision | None:
        return None if caller == ROOT else trace.calls[caller].ending

    def _state(self, trace: Trace, call: Call | None, caller: int) -> Observation | None:
        """What the decision was made by: to make this call, or else to return."""
        number = call.state if call else None if caller == ROOT else trace.calls[caller].end_state
        return None if number is None else trace.states[number]


def distance(a: Observation | None, b: Observation | None) -> float | None:
    """[m] that anything of two states lies apart, at the most; infinite where an object is only in one."""
    if a is None or b is None:
        return None
    if a.positions.keys() != b.positions.keys() or a.closed != b.closed:
        return inf
    pairs = [(a.gripper, b.gripper), *((a.positions[n], b.positions[n]) for n in a.positions)]
    return max(dist(p, q) for p, q in pairs)


def _first_state(trace: Trace) -> Observation | None:
    return trace.states[0] if trace.states else None


def _earliest(trace: Trace, true: Callable[[Call], bool]) -> float:
    return next((call.id for call in trace.calls if true(call)), inf)


def _last_below(trace: Trace) -> list[int]:
    """For each call the last that was made before it returned, or itself."""
    last = list(range(len(trace.calls)))
    for call in reversed(trace.calls):
        if call.parent != ROOT:
            last[call.parent] = max(last[call.parent], last[call.id])
    return last
