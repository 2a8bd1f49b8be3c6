"""A policy that watches itself: a state that recurs proves a livelock, an answer that changes impurity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ntp_dsl.dynamic.deadlock import Standstill, standstill
from ntp_dsl.language.syntax.nodes import Span
from ntp_dsl.policies.expert import Decision, Expert, NextCall, Return
from ntp_dsl.policies.protocol import Barred, Choice, Frame
from ntp_dsl.policies.scripted import ScriptedPolicy, check_numbers
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.semantics.state import State
from ntp_dsl.traces import decision as traced
from ntp_dsl.worlds.protocol import Failure, World

PROOF = 3  # how often a state is seen with the same calls running, until it is called a circle
NO_REFUSAL = ("achieved", str(Failure.NOT_READY))  # which is for the expert to see to
GRAIN = 0.0005  # to which positions are told apart [m]

Key = tuple[object, ...]
Ended = tuple[str, tuple[Argument, ...], str]


class Livelock(Exception):
    """The expert goes round; `cycle` are its decisions, with the statements that made them.

    `gave_up` are the programs that returned unfinished meanwhile, and `refused` the apis that the world did
    not carry out: name, arguments, and why. `still` are the programs in which no statement was due.
    """

    def __init__(
        self,
        cycle: Sequence[NextCall],
        gave_up: Sequence[Ended] = (),
        refused: Sequence[Ended] = (),
        still: Sequence[Standstill] = (),
    ) -> None:
        self.cycle, self.gave_up, self.refused = tuple(cycle), tuple(gave_up), tuple(refused)
        self.still = tuple(still)
        super().__init__(" -> ".join(call.callee for call in cycle))


class Impure(Exception):
    """An expert in Python answered the same question in two ways."""

    def __init__(self, program: str, how: str, answers: tuple[Decision, Decision]) -> None:
        self.program, self.how, self.answers = program, how, answers
        super().__init__(program)


@dataclass
class WatchedPolicy(ScriptedPolicy):
    """Decides as the expert does. The world must be exact, or nothing ever comes again."""

    expert: Expert
    demonstration: None = None
    running: list[tuple[str, tuple[Argument, ...]]] = field(default_factory=list)
    seen: dict[Key, list[int]] = field(default_factory=dict)
    made: list[NextCall] = field(default_factory=list)
    gave_up: list[tuple[int, Ended]] = field(default_factory=list)  # after so many decisions
    refused: list[tuple[int, Ended]] = field(default_factory=list)
    still: list[tuple[int, Standstill]] = field(default_factory=list)

    def watch(self, event: str, depth: int, name: str, arguments: tuple[Argument, ...], said: object) -> None:
        """Follows the stack of calls; an interpreter's `watch`."""
        if event == "return" and name in self.expert.registry.apis and said not in NO_REFUSAL:
            self.refused.append((len(self.made), (name, arguments, str(said))))
        del self.running[depth:]
        if event == "call":
            self.running.append((name, arguments))

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        seen = world.truth()
        decision = self._ask(frame, seen)
        if isinstance(decision, Return):
            if not decision.done:
                self.gave_up.append((len(self.made), (frame.program, frame.arguments, decision.reason)))
                state = State(self.expert.registry, seen)
                if stands := standstill(self.expert, frame.program, frame.arguments, state):
                    self.still.append((len(self.made), stands))
            return Choice(None, done=decision.done, decision=traced.Decision(reason=decision.reason))
        check_numbers(self.expert.registry, decision)
        if decision.callee not in barred:  # else it is asked again in the same breath
            self._remember((*_moment(seen), *self.running))
            self.made.append(decision)
        return Choice(decision.callee, decision.arguments)

    def _ask(self, frame: Frame, seen: Observation) -> Decision:
        registry = self.expert.registry
        decision = self.expert.decide(frame.program, frame.arguments, State(registry, seen))
        if registry.programs[frame.program].in_python:
            again = self.expert.decide(frame.program, frame.arguments, State(registry, seen))
            if again != decision:
                raise Impure(frame.program, "asked twice", (decision, again))
            backwards = seen.permuted(tuple(reversed(range(len(seen.objects)))))
            other = self.expert.decide(frame.program, frame.arguments, State(registry, backwards))
            if other != decision:
                raise Impure(frame.program, "with the objects listed in another order", (decision, other))
        return decision

    def _remember(self, key: Key) -> None:
        times = self.seen.setdefault(key, [])
        times.append(len(self.made))
        if len(times) >= PROOF:
            gave_up, refused = (
                [each for number, each in rows if times[-2] < number] for rows in (self.gave_up, self.refused)
            )
            still = [each for number, each in self.still if times[-2] < number]
            raise Livelock(self.made[times[-2] : times[-1]], gave_up, refused, still)


def _moment(seen: Observation) -> Key:
    places = ((name, *(round(value / GRAIN) for value in place)) for name, place in seen.positions.items())
    return (*sorted(places), *(round(value / GRAIN) for value in seen.gripper), seen.closed)


def source_lines(cycle: Sequence[NextCall]) -> list[tuple[NextCall, Span]]:
    """The statements of a cycle, each once, in the order in which they were followed."""
    lines: dict[Span, NextCall] = {}
    for call in cycle:
        lines.setdefault(call.span, call)
    return [(call, span) for span, call in lines.items()]
