"""Statements that go without what they require, in every state of a livelock."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ntp_dsl.common.text import listed
from ntp_dsl.dynamic.steps import Step
from ntp_dsl.dynamic.stuck import FEW, given
from ntp_dsl.policies.evidence import BodyStatement, body_statements
from ntp_dsl.policies.expert import Expert, NextCall
from ntp_dsl.policies.protocol import Frame
from ntp_dsl.semantics.facts import Fact
from ntp_dsl.semantics.parts import Wanted
from ntp_dsl.semantics.state import State


@dataclass(frozen=True)
class Starving:
    """A call that is needed and never made, and what it lacks always, and no earlier statement provides."""

    call: NextCall
    lacks: tuple[Fact, ...]

    def __str__(self) -> str:
        call = f"{self.call.callee}({given(self.call.arguments)})"
        return f"{call} is needed, and lacks {listed(self.lacks, FEW)}, which nothing before it provides"


def starving(expert: Expert, cycle: Sequence[Step]) -> Starving | None:
    """Return the first statement that starves in all steps of a program, of the outermost such program."""
    frames = dict.fromkeys((each.run, each.frame) for each in sorted(cycle, key=lambda step: step.run))
    for run, frame in frames:
        states = [State(expert.registry, each.seen) for each in cycle if each.run == run]
        if found := next(_starving(expert, frame, states), None):
            return found
    return None


def _starving(expert: Expert, frame: Frame, states: Sequence[State]) -> Iterator[Starving]:
    row = expert.registry.programs[frame.program]
    bodies = [body_statements(expert, row, frame.arguments, state) for state in states]
    for number, statement in enumerate(bodies[0]):
        pairs = zip(bodies, states, strict=True)
        lacks = [frozenset[Fact]().union(*_unprovided(body, number, state)) for body, state in pairs]
        always = frozenset.intersection(*lacks)
        if always and statement.call is not None:
            yield Starving(statement.call, tuple(sorted(always, key=str)))


def _unprovided(body: Sequence[BodyStatement], number: int, state: State) -> Iterator[frozenset[Fact]]:
    """Yield what a statement that is due lacks, without that towards which an earlier one does anything."""
    if number >= len(body):
        return
    statement, earlier = body[number], body[:number]
    if statement.instance is not None and statement.is_due and not statement.instance.achieved:
        provided = [fact for each in earlier if each.instance is not None for fact in each.instance.provides]
        lacks = statement.instance.lacks
        helped = Wanted(lacks, state).helped_by(provided)
        yield frozenset(fact for fact in lacks - helped if not any(each.provides(fact) for each in provided))
