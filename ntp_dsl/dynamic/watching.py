"""A policy that detects livelocks by recurring states, and nondeterminism by asking the expert twice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ntp_dsl.dynamic.deadlock import Deadlock, find_deadlock
from ntp_dsl.language.syntax.nodes import Span
from ntp_dsl.policies.expert import Decision, Expert, NextCall, Return
from ntp_dsl.policies.protocol import Barred, Choice, Frame
from ntp_dsl.policies.scripted import ScriptedPolicy, check_numbers
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.semantics.state import State
from ntp_dsl.traces import decision as traced
from ntp_dsl.worlds.protocol import Failure, World

RECURRENCES = 3  # occurrences of a state with the same open calls that count as a livelock
NO_REFUSAL = ("achieved", str(Failure.NOT_READY))  # for which the expert is responsible
RESOLUTION = 0.0005  # of positions in the comparison of states [m]

Key = tuple[object, ...]
Failed = tuple[str, tuple[Argument, ...], str]


class Livelock(Exception):
    """The expert repeats a cycle of states; `cycle` has its decisions, with the statements that made them.

    `unfinished` has the programs that returned unfinished in the cycle, and `refused` the apis that failed:
    name, arguments and reason. `deadlocks` has the programs in which no statement was due.
    """

    def __init__(
        self,
        cycle: Sequence[NextCall],
        unfinished: Sequence[Failed] = (),
        refused: Sequence[Failed] = (),
        deadlocks: Sequence[Deadlock] = (),
    ) -> None:
        self.cycle, self.unfinished, self.refused = tuple(cycle), tuple(unfinished), tuple(refused)
        self.deadlocks = tuple(deadlocks)
        super().__init__(" -> ".join(call.callee for call in cycle))


class NondeterministicExpert(Exception):
    """An expert in Python made two different decisions in the same state."""

    def __init__(self, program: str, how: str, answers: tuple[Decision, Decision]) -> None:
        self.program, self.how, self.answers = program, how, answers
        super().__init__(program)


@dataclass
class WatchedPolicy(ScriptedPolicy):
    """Decides as the expert does. The world must be exact, or states never recur."""

    expert: Expert
    demonstration: None = None
    running: list[tuple[str, tuple[Argument, ...]]] = field(default_factory=list)
    seen: dict[Key, list[int]] = field(default_factory=dict)
    decisions: list[NextCall] = field(default_factory=list)
    unfinished: list[tuple[int, Failed]] = field(default_factory=list)  # after how many decisions
    refused: list[tuple[int, Failed]] = field(default_factory=list)
    deadlocks: list[tuple[int, Deadlock]] = field(default_factory=list)

    def watch(
        self, event: str, depth: int, name: str, arguments: tuple[Argument, ...], detail: object
    ) -> None:
        """Follow the stack of calls; an interpreter's `watch`."""
        if event == "return" and name in self.expert.registry.apis and detail not in NO_REFUSAL:
            self.refused.append((len(self.decisions), (name, arguments, str(detail))))
        del self.running[depth:]
        if event == "call":
            self.running.append((name, arguments))

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        seen = world.truth()
        decision = self._ask(frame, seen)
        if isinstance(decision, Return):
            if not decision.done:
                self.unfinished.append(
                    (len(self.decisions), (frame.program, frame.arguments, decision.reason))
                )
                state = State(self.expert.registry, seen)
                if deadlock := find_deadlock(self.expert, frame.program, frame.arguments, state):
                    self.deadlocks.append((len(self.decisions), deadlock))
            return Choice(None, done=decision.done, decision=traced.Decision(reason=decision.reason))
        check_numbers(self.expert.registry, decision)
        if decision.callee not in barred:  # else the expert is asked again in the same state
            self._remember((*_moment(seen), *self.running))
            self.decisions.append(decision)
        return Choice(decision.callee, decision.arguments)

    def _ask(self, frame: Frame, seen: Observation) -> Decision:
        registry = self.expert.registry
        decision = self.expert.decide(frame.program, frame.arguments, State(registry, seen))
        if registry.programs[frame.program].in_python:
            again = self.expert.decide(frame.program, frame.arguments, State(registry, seen))
            if again != decision:
                raise NondeterministicExpert(frame.program, "asked twice", (decision, again))
            backwards = seen.permuted(tuple(reversed(range(len(seen.objects)))))
            other = self.expert.decide(frame.program, frame.arguments, State(registry, backwards))
            if other != decision:
                raise NondeterministicExpert(
                    frame.program, "with the objects in another order", (decision, other)
                )
        return decision

    def _remember(self, key: Key) -> None:
        times = self.seen.setdefault(key, [])
        times.append(len(self.decisions))
        if len(times) >= RECURRENCES:
            unfinished, refused = (
                [each for number, each in rows if times[-2] < number]
                for rows in (self.unfinished, self.refused)
            )
            deadlocks = [each for number, each in self.deadlocks if times[-2] < number]
            raise Livelock(self.decisions[times[-2] : times[-1]], unfinished, refused, deadlocks)


def _moment(seen: Observation) -> Key:
    places = (
        (name, *(round(value / RESOLUTION) for value in place)) for name, place in seen.positions.items()
    )
    return (*sorted(places), *(round(value / RESOLUTION) for value in seen.gripper), seen.closed)


def source_lines(cycle: Sequence[NextCall]) -> list[tuple[NextCall, Span]]:
    """Return the statements of a cycle in the order in which they were followed, each once."""
    lines: dict[Span, NextCall] = {}
    for call in cycle:
        lines.setdefault(call.span, call)
    return [(call, span) for span, call in lines.items()]
