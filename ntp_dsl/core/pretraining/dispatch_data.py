"""Decisions to learn from: a program's row as it is believed, and what is right by the truth."""

from __future__ import annotations

from dataclasses import dataclass

from ntp_dsl.core.dispatch.rows import Row, unrolled
from ntp_dsl.core.perception.grounding import Grounding
from ntp_dsl.core.perception.perceived import Believed, Perceived
from ntp_dsl.core.perception.tracking import Tracker
from ntp_dsl.policies.expert import Expert, NextCall
from ntp_dsl.policies.protocol import Barred, Choice, Frame
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.state import State
from ntp_dsl.worlds.protocol import World

END = -1


@dataclass(frozen=True)
class Sample:
    """A row, and the number of the call that is right, or `END`."""

    row: Row
    answer: int


def sample_of(
    expert: Expert, program: str, arguments: tuple[Argument, ...], believed: Believed, truth: State
) -> Sample | None:
    """Return a decision; None where it cannot be told by the row."""
    row = unrolled(expert.registry.programs[program], arguments, believed)
    right = expert.decide(program, arguments, truth)
    if not isinstance(right, NextCall):
        return Sample(row, END) if row.calls else None
    same = [n for n, call in enumerate(row.calls) if call == right and call.span == right.span]
    same = same or [n for n, call in enumerate(row.calls) if call == right]
    return Sample(row, same[0]) if same else None


class Watching:
    """The scripted policy, whose decisions are noted as a core would have to make them."""

    def __init__(self, expert: Expert, network: Grounding) -> None:
        self.samples: list[Sample] = []
        self._scripted = ScriptedPolicy(expert)
        self._network = network
        self._tracker = Tracker()

    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame:
        return self._scripted.root(program, arguments)

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        expert = self._scripted.expert
        if not expert.registry.programs[frame.program].in_python:
            seen = self._tracker.update(world.observe())
            believed = Perceived(expert.registry, seen, self._network)
            truth = State(expert.registry, world.truth())
            sample = sample_of(expert, frame.program, frame.arguments, believed, truth)
            if sample is not None:
                self.samples.append(sample)
        return self._scripted.decide(frame, world, barred)
