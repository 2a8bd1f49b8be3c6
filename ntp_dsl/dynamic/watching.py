"""A policy that detects livelocks by recurring states, and nondeterminism by asking the expert twice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ntp_dsl.dynamic.steps import Step
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


@dataclass(frozen=True)
class Unfinished:
    """A program that returned unfinished: why, in which state, and its last call, if it made one."""

    frame: Frame
    reason: str
    seen: Observation
    last: Step | None

    @property
    def what(self) -> Failed:
        """Return what makes two the same."""
        return self.frame.program, self.frame.arguments, self.reason


class Livelock(Exception):
    """The expert repeats a cycle of states.

    Args:
        cycle: its decisions, with the statements that made them.
        unfinished: the programs that returned unfinished in the cycle.
        refused: the apis that failed: name, arguments and reason.
        deadlocks: the programs in which no statement was due.
        way: the statements of the calls that are open, the outermost first.
        steps: all decisions of the run.
    """

    def __init__(
        self,
        cycle: Sequence[NextCall],
        unfinished: Sequence[Unfinished] = (),
        refused: Sequence[Failed] = (),
        deadlocks: Sequence[Stuck] = (),
        way: Sequence[Span] = (),
        steps: Sequence[Step] = (),
    ) -> None:
        self.cycle, self.unfinished, self.refused = tuple(cycle), tuple(unfinished), tuple(refused)
        self.deadlocks, self.way, self.steps = tuple(deadlocks), tuple(way), tuple(steps)
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
    steps: list[Step] = field(default_factory=list)
    unfinished: list[tuple[int, Unfinished]] = field(default_factory=list)  # after how many steps
    refused: list[tuple[int, Failed]] = field(default_factory=list)
    deadlocks: list[tuple[int, Stuck]] = field(default_factory=list)
    _latest: NextCall | None = None  # decision
    _runs: list[int] = field(default_factory=list)  # of the calls that are open: the how-manieth call each is
    _calls: int = 0  # so far

    @property
    def decisions(self) -> list[NextCall]:
        """The calls that were decided on, in order."""
        return [each.call for each in self.steps]

    def watch(
        self, event: str, depth: int, name: str, arguments: tuple[Argument, ...], detail: object
    ) -> None:
        """Follow the stack of calls; an interpreter's `watch`."""
        if event == "return" and name in self.expert.registry.apis and detail not in NO_REFUSAL:
            self.refused.append((len(self.steps), (name, arguments, str(detail))))
        del self.running[depth:], self._runs[depth:]
        if event == "call":
            place = self._latest.span if self._latest is not None and self._latest.callee == name else NOWHERE
            self.running.append(NextCall(name, arguments, place))
            self._calls += 1
            self._runs.append(self._calls)

    @property
    def way(self) -> tuple[Span, ...]:
        """The statements of the calls that are open, the outermost first."""
        return tuple(each.span for each in self.running if each.span.line)

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        seen = world.truth()
        decision = self._ask(frame, seen)
        if isinstance(decision, Return):
            if not decision.done:
                own = (each for each in reversed(self.steps) if each.run == self._runs[-1])
                unfinished = Unfinished(frame, decision.reason, seen, next(own, None))
                self.unfinished.append((len(self.steps), unfinished))
                state = self.expert.state_of(seen)
                if deadlock := find_deadlock(self.expert, frame.program, frame.arguments, state, self.way):
                    self.deadlocks.append((len(self.steps), deadlock))
            reason = traced.Decision(reason=decision.reason)
            return Choice(None, done=decision.done, decision=reason, seen=seen)
        check_numbers(self.expert.registry, decision)
        if decision.callee not in barred:  # else the expert is asked again in the same state
            calls = ((each.callee, each.arguments) for each in self.running)
            self._remember((*_moment(seen), *calls))
            self.steps.append(Step(self._runs[-1], frame, decision, seen))
        self._latest = decision
        source = traced.Decision(source=source_of(decision))
        return Choice(decision.callee, decision.arguments, decision=source, seen=seen)

    def _ask(self, frame: Frame, seen: Observation) -> Decision:
        registry = self.expert.registry
        decision = self.expert.decide(frame.program, frame.arguments, self.expert.state_of(seen))
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
        times.append(len(self.steps))
        if len(times) >= RECURRENCES:
            unfinished = [each for number, each in self.unfinished if times[-2] < number]
            refused = [each for number, each in self.refused if times[-2] < number]
            deadlocks = [each for number, each in self.deadlocks if times[-2] < number]
            cycle = self.decisions[times[-2] : times[-1]]
            raise Livelock(cycle, unfinished, refused, deadlocks, self.way, self.steps)


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
