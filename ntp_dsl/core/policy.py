"""The one core as a policy: any sound library, from one demonstration, with no training on it."""

from __future__ import annotations

from msgspec.structs import replace as with_fields

from ntp_dsl.core.dispatch.dispatcher import Dispatcher, Situation
from ntp_dsl.core.dispatch.evidence import rounded
from ntp_dsl.core.perception.perceived import Perceived
from ntp_dsl.core.perception.tracking import Tracker
from ntp_dsl.core.shown import Source
from ntp_dsl.policies.expert import NextCall
from ntp_dsl.policies.protocol import Barred, Choice, Frame
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.traces.decision import Decision
from ntp_dsl.traces.schema import PolicyKind
from ntp_dsl.worlds.protocol import World


class OneShotPolicy:
    """Tracks what is looked at, perceives which facts hold, and dispatches over what the library declares."""

    kind = PolicyKind.LEARNED

    def __init__(self, source: Source, dispatcher: Dispatcher) -> None:
        self.source = source
        self._dispatcher = dispatcher
        self._tracker = Tracker()
        self._last: Perceived | None = None

    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame:
        return Frame(program, self.source.passed_on(arguments), self.source.scope())

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        """Return the next call, or a return. Of the world, only what can be observed is looked at."""
        return self.choose(frame, self._tracker.update(world.observe()), barred)

    def choose(self, frame: Frame, seen: Observation, barred: Barred = frozenset()) -> Choice:
        """Return the next call, or a return, in a state as it was tracked."""
        state = self._perceived(seen)
        arguments = self.source.arguments(frame)
        if arguments is None:
            reason = f"the demonstration does not show what {frame.program} is to do"
            return Choice(None, done=False, decision=Decision(reason=reason), seen=seen)
        [found] = self._dispatcher.dispatch([Situation(frame.program, arguments, state, barred)])
        answer = found.answer
        given = answer.arguments if isinstance(answer, NextCall) else None
        led_here = 1.0 if frame.matched is None else float(frame.matched)  # what its callers have read
        certainty = led_here * self.source.certainty(frame, given)
        probability = found.decision.probability
        decision = with_fields(
            found.decision,
            read=self.source.told(frame),
            probability=rounded(probability * certainty) if probability is not None else None,
        )
        if not isinstance(answer, NextCall):
            decision = with_fields(decision, achieved=rounded(found.achieved * certainty))
            return Choice(None, done=answer.done, decision=decision, seen=seen)
        scope = self.source.scope_of(frame, answer.callee, answer.arguments)
        passed = self.source.passed_on(answer.arguments)
        return Choice(answer.callee, passed, scope, matched=certainty, decision=decision, seen=seen)

    def _perceived(self, seen: Observation) -> Perceived:
        if self._last is None or self._last.observation != seen:
            self._last = self.source.perceive(seen)
        return self._last
