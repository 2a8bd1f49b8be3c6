"""The one core as a policy: any sound library, from one demonstration, with no training on it."""

from __future__ import annotations

from msgspec.structs import replace as with_fields

from ntp_dsl.core.asking import Person, Question
from ntp_dsl.core.dispatch.dispatcher import Dispatched, Dispatcher, Situation
from ntp_dsl.core.perception.perceived import Perceived
from ntp_dsl.core.perception.tracking import Tracker
from ntp_dsl.core.shown import Source, without_list_values
from ntp_dsl.policies.evidence import rounded
from ntp_dsl.policies.expert import NextCall, Return
from ntp_dsl.policies.protocol import Barred, Choice, Frame
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.traces.decision import Asked, Decision, Option
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
        self.person: Person | None = None  # who may be asked about decisions
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
        answer, asked = self._advised(frame, seen, found)
        given = answer.arguments if isinstance(answer, NextCall) else None
        led_here = 1.0 if frame.matched is None else float(frame.matched)  # what its callers have read
        certainty = led_here * self.source.certainty(frame, given)
        probability = found.decision.probability
        decision = with_fields(
            found.decision,
            read=self.source.told(frame),
            asked=asked,
            probability=rounded(probability * certainty) if probability is not None else None,
        )
        if not isinstance(answer, NextCall):
            achieved = found.achieved if asked is None else float(answer.done)  # as somebody says
            decision = with_fields(decision, achieved=rounded(achieved * certainty))
            return Choice(None, done=answer.done, decision=decision, seen=seen, grounds=found.grounds)
        scope = self.source.scope_of(frame, answer.callee, answer.arguments)
        passed = self.source.passed_on(answer.arguments)
        return Choice(
            answer.callee,
            passed,
            scope,
            matched=certainty,
            decision=decision,
            seen=seen,
            grounds=found.grounds,
        )

    def _advised(
        self, frame: Frame, seen: Observation, found: Dispatched
    ) -> tuple[NextCall | Return, Asked | None]:
        """Return what is to be done, and what somebody was asked about it."""
        if self.person is None:
            return found.answer, None
        options = [(found.answer, _certainty(frame, found)), *found.others]
        told = tuple(
            Option(each.callee, without_list_values(each.arguments), rounded(chance))
            if isinstance(each, NextCall)
            else Option(None, (), rounded(chance))
            for each, chance in options
        )
        question = Question(frame.program, frame.arguments, seen, told, _is_end(frame, found))
        number = self.person.advise(question)
        if number is None:
            return found.answer, None
        return options[number][0], Asked(told, number)

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
