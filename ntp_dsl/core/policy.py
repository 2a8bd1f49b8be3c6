"""The one core as a policy: any sound library, from one demonstration, with no training on it."""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

from msgspec.structs import replace as with_fields

from ntp_dsl.core.asking import Adviser, Question
from ntp_dsl.core.dispatch.dispatcher import Dispatched, Dispatcher, Situation
from ntp_dsl.core.perception.perceived import Perceived
from ntp_dsl.core.perception.tracking import Tracker
from ntp_dsl.core.shown import Source, without_list_values
from ntp_dsl.policies.evidence import rounded
from ntp_dsl.policies.expert import NextCall, Return
from ntp_dsl.policies.protocol import Barred, Choice, Frame
from ntp_dsl.policies.scripted import source_of
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.traces.decision import Asked, Decision, Option, Step
from ntp_dsl.traces.schema import PolicyKind
from ntp_dsl.worlds.protocol import World

LOOKS = 8  # more, at most, where a decision is in doubt
SURE = 0.95  # probability from which it is not


class OneShotPolicy:
    """Tracks what is looked at, perceives which facts hold, and dispatches over what the library declares."""

    kind = PolicyKind.LEARNED

    def __init__(self, source: Source, dispatcher: Dispatcher) -> None:
        self.source = source
        self._dispatcher = dispatcher
        self.adviser: Adviser | None = None  # who may be asked about decisions
        self._told: dict[
            Step, Step
        ] = {}  # what programs are to do, as somebody said, until a primitive is called
        self._tracker = Tracker()
        self._last: Perceived | None = None

    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame:
        return Frame(program, self.source.passed_on(arguments), self.source.scope())

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        """Return the next call, or a return. Of the world, only what can be observed is looked at.

        In doubt it looks again, a few times.
        """
        seen = self._tracker.update(world.observe())
        found = self._dispatched(frame, seen, barred)
        for _ in range(LOOKS):
            if not seen.deviations or found is None or _certainty(frame, found) >= SURE:
                break
            seen = self._tracker.update(world.observe())
            found = self._dispatched(frame, seen, barred)
        return self._choice(frame, seen, found)

    def choose(self, frame: Frame, seen: Observation, barred: Barred = frozenset()) -> Choice:
        """Return the next call, or a return, in a state as it was tracked."""
        return self._choice(frame, seen, self._dispatched(frame, seen, barred))

    def _dispatched(self, frame: Frame, seen: Observation, barred: Barred) -> Dispatched | None:
        arguments = self.source.arguments(frame)
        if arguments is None:
            return None
        [found] = self._dispatcher.dispatch(
            [Situation(frame.program, arguments, self._perceived(seen), barred)]
        )
        return found

    def _choice(self, frame: Frame, seen: Observation, found: Dispatched | None) -> Choice:
        if found is None:
            reason = f"the demonstration does not show what {frame.program} is to do"
            return Choice(None, done=False, decision=Decision(reason=reason), seen=seen)
        start = perf_counter()
        advised = self._advised(frame, seen, found)
        waited = perf_counter() - start if advised.decision.asked is not None else 0.0
        answer = advised.answer
        given = answer.arguments if isinstance(answer, NextCall) else None
        led_here = 1.0 if frame.matched is None else float(frame.matched)  # what its callers have read
        certainty = led_here * self.source.certainty(frame, given)
        decision = with_fields(
            advised.decision,
            read=self.source.told(frame),
            probability=_times(advised.decision.probability, certainty),
        )
        if not isinstance(answer, NextCall):
            decision = with_fields(decision, achieved=rounded(advised.achieved * certainty))
            return Choice(
                None, done=answer.done, decision=decision, seen=seen, waited=waited, grounds=found.grounds
            )
        scope = self.source.scope_of(frame, answer.callee, answer.arguments)
        passed = self.source.passed_on(answer.arguments)
        return Choice(
            answer.callee,
            passed,
            scope,
            matched=certainty,
            decision=decision,
            seen=seen,
            waited=waited,
            grounds=found.grounds,
        )

    def _advised(self, frame: Frame, seen: Observation, found: Dispatched) -> Dispatched:
        """Return what is to be done, as whoever is asked says, or has said since the last primitive."""
        if self.adviser is None:
            return found
        is_end = _is_end(frame, found)
        steps = [(found.answer, _certainty(frame, found)), *found.others]
        options = tuple(_option(step, chance) for step, chance in steps)
        question = Question(frame.program, frame.arguments, seen, options, is_end)
        told = [each.step for each in options]
        asked = None
        if (before := self._told.get(question.who)) in told:
            number: int | None = told.index(before)
        else:
            number = self.adviser.advise(question)
            if number is not None:
                asked = Asked(options, number)
                self._told[question.who] = told[number]
        if told[number or 0][0] in self._perceived(seen).registry.apis:
            self._told.clear()
        if number is None:
            return found
        answer, chance = steps[number]
        decision = found.decision
        if number:  # it is another one than was decided
            source = source_of(answer) if isinstance(answer, NextCall) else ""
            decision = with_fields(decision, probability=chance, arguments=(), source=source)
        decision = with_fields(decision, asked=asked)
        if isinstance(answer, NextCall):
            return replace(found, answer=answer, decision=decision)
        return replace(found, answer=Return(True), decision=decision, achieved=1.0)  # whatever is seen

    def _perceived(self, seen: Observation) -> Perceived:
        if self._last is None or self._last.observation != seen:
            self._last = self.source.perceive(seen)
        return self._last


def _certainty(frame: Frame, found: Dispatched) -> float:
    """Return how probable a decision is, as far as can be seen: of the root's return, that all is done."""
    chance = found.decision.probability or 0.0
    return min(chance, found.achieved) if _is_end(frame, found) else chance


def _is_end(frame: Frame, found: Dispatched) -> bool:
    return isinstance(found.answer, Return) and frame.matched is None


def _option(step: NextCall | Return, chance: float) -> Option:
    if isinstance(step, NextCall):
        return Option(step.callee, without_list_values(step.arguments), rounded(chance))
    return Option(None, (), rounded(chance))


def _times(probability: float | None, certainty: float) -> float | None:
    return None if probability is None else rounded(probability * certainty)
