"""A policy that detects livelocks by recurring states, and nondeterminism by asking the expert twice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ntp_dsl.dynamic.stuck import Stuck, find_deadlock
from ntp_dsl.language.syntax.nodes import NOWHERE, Span
from ntp_dsl.policies.expert import Decision, Expert, NextCall, Return
from ntp_dsl.policies.protocol import Barred, Choice, Frame
from ntp_dsl.policies.scripted import ScriptedPolicy, check_numbers, source_of
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
    name, arguments and reason. `deadlocks` has the programs in which no statement was due. `way` has the
    statements of the calls that are open, the outermost first.
    """

    def __init__(
        self,
        cycle: Sequence[NextCall],
        unfinished: Sequence[Failed] = (),
        refused: Sequence[Failed] = (),
        deadlocks: Sequence[Stuck] = (),
        way: Sequence[Span] = (),
    ) -> None:
        self.cycle, self.unfinished, self.refused = tuple(cycle), tuple(unfinished), tuple(refused)
        self.deadlocks, self.way = tuple(deadlocks), tuple(way)
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
    running: list[NextCall] = field(default_factory=list)  # the calls that are open, with their statements
    seen: dict[Key, list[int]] = field(default_factory=dict)
    decisions: list[NextCall] = field(default_factory=list)
    unfinished: list[tuple[int, Failed]] = field(default_factory=list)  # after how many decisions
    refused: list[tuple[int, Failed]] = field(default_factory=list)
    deadlocks: list[tuple[int, Stuck]] = field(default_factory=list)
    _latest: NextCall | None = None  # decision

    def watch(
        self, event: str, depth: int, name: str, arguments: tuple[Argument, ...], detail: object
    ) -> None:
        """Follow the stack of calls; an interpreter's `watch`."""
        if event == "return" and name in self.expert.registry.apis and detail not in NO_REFUSAL:
            self.refused.append((len(self.decisions), (name, arguments, str(detail))))
        del self.running[depth:]
        if event == "call":
            place = self._latest.span if self._latest is not None and self._latest.callee == name else NOWHERE
            self.running.append(NextCall(name, arguments, place))

    @property
    def way(self) -> tuple[Span, ...]:
        """The statements of the calls that are open, the outermost first."""
        return tuple(each.span for each in self.running if each.span.line)

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        seen = world.truth()
        decision = self._ask(frame, seen)
        if isinstance(decision, Return):
            if not decision.done:
                self.unfinished.append(
                    (len(self.decisions), (frame.program, frame.arguments, decision.reason))
                )
                state = State(self.expert.registry, seen)
                if deadlock := find_deadlock(self.expert, frame.program, frame.arguments, state, self.way):
                    self.deadlocks.append((len(self.decisions), deadlock))
            reason = traced.Decision(reason=decision.reason)
            return Choice(None, done=decision.done, decision=reason, seen=seen)
        check_numbers(self.expert.registry, decision)
        if decision.callee not in barred:  # else the expert is asked again in the same state
            calls = ((each.callee, each.arguments) for each in self.running)
            self._remember((*_moment(seen), *calls))
            self.decisions.append(decision)
        self._latest = decision
        source = traced.Decision(source=source_of(decision))
        return Choice(decision.callee, decision.arguments, decision=source, seen=seen)

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
            cycle = self.decisions[times[-2] : times[-1]]
            raise Livelock(cycle, unfinished, refused, deadlocks, self.way)


def _moment(seen: Observation) -> Key:
    places = (
        (name, *(round(value / RESOLUTION) for value in place)) for name, place in seen.positions.items()
    )
    hand = (round(value / RESOLUTION) for value in seen.gripper)
    return (*sorted(places), *hand, seen.closed, *sorted(seen.facts))


def source_lines(cycle: Sequence[NextCall]) -> list[tuple[NextCall, Span]]:
    """Return the statements of a cycle in the order in which they were followed, each once."""
    lines: dict[Span, NextCall] = {}
    for call in cycle:
        lines.setdefault(call.span, call)
    return [(call, span) for span, call in lines.items()]
