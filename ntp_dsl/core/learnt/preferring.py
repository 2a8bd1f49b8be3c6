"""An expert that knows preferences: by it a demonstration is explained whose order no body states."""

from __future__ import annotations

from collections.abc import Collection

from ntp_dsl.core.dispatch.dispatcher import Dispatcher, Situation
from ntp_dsl.core.perception.perceived import Believed
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Decision, Expert
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.state import State


class PreferringExpert(Expert):
    """Decides as an expert does, but for some programs as a dispatcher does that knows what they prefer."""

    def __init__(self, registry: Registry, dispatcher: Dispatcher, programs: Collection[str]) -> None:
        super().__init__(registry)
        self._dispatcher, self._programs = dispatcher, programs

    def decide(self, program: str, arguments: tuple[Argument, ...], state: State) -> Decision:
        if program not in self._programs or not isinstance(state, Believed):
            return super().decide(program, arguments, state)
        key = self, program, arguments
        if key not in state.memo:
            [found] = self._dispatcher.dispatch([Situation(program, arguments, state)])
            state.memo[key] = found.answer
        answer: Decision = state.memo[key]
        return answer
