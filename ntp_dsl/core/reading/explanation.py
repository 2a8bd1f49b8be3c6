"""Which calls would have made the hand do what it does: a program that runs along with a demonstration.

At each act of the hand, the program is asked for its next call until it names a primitive; the act is
explained where that is what has just come true. As in an execution, a call goes on until it returns.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

from ntp_dsl.core.reading.moments import Act, Moments
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Api
from ntp_dsl.language.syntax.nodes import PYTHON
from ntp_dsl.policies.expert import Expert, NextCall, Return
from ntp_dsl.semantics.observation import Argument, Record
from ntp_dsl.semantics.state import State
from ntp_dsl.semantics.state_changes import changed_by, says_of_state
from ntp_dsl.traces.schema import DemonstratedCall

DECISIONS = 80  # at one look, at most
MOST_ACTS = 8  # of one primitive


@dataclass(frozen=True)
class Running:
    """A call that has not returned, and the one that made it."""

    program: str
    arguments: tuple[Argument, ...]
    caller: Running | None = None
    call: DemonstratedCall | None = field(default=None, compare=False)  # in which what is shown is noted
    rest: int = 0  # acts that still belong to the primitive that was called

    def is_about(self, item: str) -> bool:
        """Return whether this call, or any caller below the root, has the object as an argument."""
        if self.caller is None:
            return False
        return item in _names(self.arguments) or self.caller.is_about(item)


@dataclass
class Explanation:
    """How far a program explains a demonstration, with what its lists are said to be."""

    expert: Expert
    moments: Moments

    def step(self, top: Running, act: Act) -> Running | None:
        """Return the running call after an act that it explains; None where it does not explain it."""
        if top.rest:
            return replace(top, rest=top.rest - 1)
        noted: DemonstratedCall | None = None
        for frame in (act.start, *act.before):
            state = self.moments.state(frame)
            begin = max(act.arrived, frame) if frame in act.before else act.left
            found = self._descend(top, state, begin)
            if found is None:
                return None
            top, primitive = found
            noted = self._note_primitive(top, primitive, begin, noted)
            if frame not in act.before:  # the hand is still on its way
                continue
            if act.changed and not self._changes(primitive, act, state):
                continue  # what it achieves may come true later, by what the hand does then
            if any(self._came_true(primitive, state, self.moments.state(after)) for after in act.after):
                _ends(noted, act.end)
                return top
            if (rest := self._acts_of(primitive, act, state)) is not None:
                _ends(noted, self.moments.acts[act.number + rest].end)
                return replace(top, rest=rest)
        return None

    def _acts_of(self, primitive: NextCall, act: Act, before: State) -> int | None:
        """Return how many more acts belong to a primitive; None where none do.

        It may be one in Python that moves objects, or one that changes the state at its end. All that is
        moved meanwhile must be among its arguments.
        """
        moves = self.expert.registry.apis[primitive.callee].skill == PYTHON
        if not (moves and not before.observation.closed) and primitive.callee not in self._of_both:
            return None
        for later in self.moments.acts[act.number + 1 : act.number + MOST_ACTS]:
            state = self.moments.state(later.start)
            if state.observation.held is not None and state.observation.held not in primitive.arguments:
                return None
            if self._came_true(primitive, before, self.moments.state(later.after[0])):
                return later.number - act.number
        return None

    @cached_property
    def _of_both(self) -> set[str]:
        """The apis that achieve something of the state, and something else."""
        registry = self.expert.registry
        found = {name: [*says_of_state(registry, api.achieves)] for name, api in registry.apis.items()}
        return {name for name, of_state in found.items() if any(of_state) and not all(of_state)}

    def finish(self, top: Running) -> None:
        """Let the calls that are done in the last state return, after the last act."""
        end, acts = self.moments.scope[1], self.moments.acts
        self._descend(top, self.moments.state(end - 1), acts[-1].end if acts else end)

    def _descend(self, top: Running, state: State, frame: int) -> tuple[Running, NextCall] | None:
        """Return the running call that would call a primitive next, and which; None if none would.

        Args:
            frame: in which calls are noted to begin and to end.
        """
        for _ in range(DECISIONS):
            try:
                decision = self.expert.decide(top.program, top.arguments, state)
            except NtpError:
                return None
            if isinstance(decision, Return):
                if top.call is not None:
                    _ends(top.call, frame)
                    top.call.done = decision.done
                if top.caller is None:
                    return None
                top = top.caller
            elif decision.callee in self.expert.registry.apis:
                return top, decision
            else:
                top = self._enter(top, decision, frame)
        return None

    def _enter(self, top: Running, decision: NextCall, frame: int) -> Running:
        call = None
        if top.call is not None:
            begin = max([top.call.scope[0], frame, *(each.scope[1] for each in top.call.children)])
            call = DemonstratedCall(
                name=decision.callee, arguments=decision.arguments, scope=(begin, begin), done=False
            )
            call.children = []
            top.call.children.append(call)
        return Running(decision.callee, decision.arguments, top, call)

    def _note_primitive(
        self, top: Running, primitive: NextCall, begin: int, before: DemonstratedCall | None
    ) -> DemonstratedCall | None:
        """Note a primitive that begins, and that the one before it has ended, if it is another."""
        if top.call is None:
            return None
        if before is not None:
            if (before.name, before.arguments) == (primitive.callee, primitive.arguments):
                return before
            _ends(before, begin)
        call = DemonstratedCall(
            name=primitive.callee, arguments=primitive.arguments, scope=(begin, begin), done=True
        )
        top.call.children.append(call)
        return call

    def _changes(self, primitive: NextCall, act: Act, before: State) -> bool:
        """Return whether a primitive changes one of the facts that an act is the change of."""
        api = self.expert.registry.apis[primitive.callee]
        facts = before.observation.facts
        return not act.changed.isdisjoint(facts ^ changed_by(api, primitive.arguments, before))

    def _came_true(self, primitive: NextCall, before: State, after: State) -> bool:
        """Return whether something that a primitive achieves was missing, and all of it holds afterwards."""
        api = self.expert.registry[primitive.callee]
        assert isinstance(api, Api)
        scope = api.bind(primitive.arguments)
        facts = before.literals(api.achieves, scope)
        return not all(before.holds(fact) for fact in facts) and all(
            after.holds(fact) for fact in after.literals(api.achieves, scope)
        )


def root(program: str, arguments: tuple[Argument, ...], call: DemonstratedCall | None = None) -> Running:
    """Return a program that begins."""
    return Running(program, arguments, None, call)


def unmarked(top: Running) -> Running:
    """Return a running call in which nothing of what is shown is noted."""
    caller = unmarked(top.caller) if top.caller is not None else None
    return replace(top, caller=caller, call=None)


def _names(arguments: Iterable[Argument]) -> Iterator[str]:
    """Yield the objects and members among arguments, in their records and lists too."""
    for each in arguments:
        if isinstance(each, str):
            yield each
        elif isinstance(each, Record):
            yield from _names(value for _, value in each.fields)
        elif isinstance(each, tuple):
            yield from _names(each)


def _ends(call: DemonstratedCall | None, frame: int) -> None:
    """Note the frame in which a call has ended: it has at least one."""
    if call is not None:
        call.scope = call.scope[0], max(frame, call.scope[0] + 1)
