"""The learned policy: one demonstration, then the core decides for one running program at a time."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import replace
from operator import itemgetter
from typing import TypeVar

import torch
from msgspec.structs import replace as with_fields
from torch import Tensor

from ntp_dsl.core.per_library import batches, keyframes
from ntp_dsl.core.per_library.batches import States
from ntp_dsl.core.per_library.model import Core, Hint, Thought, silent_hint
from ntp_dsl.core.per_library.reader import Reading
from ntp_dsl.demonstrations.demonstration import Demonstration, Scope
from ntp_dsl.demonstrations.queries import Answer, Query
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.policies.protocol import Barred, Choice, Frame
from ntp_dsl.semantics.observation import Argument, Observation, without_lists
from ntp_dsl.traces.decision import Alternative, Decision, Ranking
from ntp_dsl.traces.schema import PolicyKind
from ntp_dsl.worlds.protocol import World

TOP = 5  # alternatives that a decision reports

Value = TypeVar("Value")


class LearnedPolicy:
    """Runs a core on one demonstration. It sees observations only, and is never given a goal."""

    kind = PolicyKind.LEARNED

    def __init__(self, core: Core, demonstration: Demonstration) -> None:
        self.core = core
        self.demonstration = demonstration
        self._order: tuple[str, ...] = ()
        self._readings: dict[tuple[Scope, str], Reading] = {}

    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame:
        """Begin without the arguments of the task: what a list would say, the scope shows."""
        return Frame(program, (), (0, len(self.demonstration)))

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        arguments = without_lists(frame.arguments)
        seen = world.observe()
        query = Query(frame.program, arguments, frame.scope, seen, self.demonstration)
        answer, decision = self.answer(query, barred)
        given: tuple[Argument, ...] = answer.arguments
        if answer.callee is not None:
            given = self.core.memory.signature(answer.callee).packed(answer.arguments)
        return Choice(answer.callee, given, answer.scope, decision=decision, seen=seen)

    @torch.inference_mode()
    def answer(self, query: Query, barred: Barred = frozenset()) -> tuple[Answer, Decision]:
        """Return the most probable answer, with the probabilities that a trace keeps."""
        memory = self.core.memory
        states = batches.states(memory, [query], [0 if query.scope else -1])
        hint, scope, scopes = self._hint(query, states)
        thought = self.core.consider(states, hint)
        end = float(torch.sigmoid(thought.end)[0])
        probabilities = torch.softmax(thought.slots[0], -1)
        callees = memory.row(query.program).callees
        decision = Decision(end_probability=round(end, 4), callees=ranked(callees, probabilities))
        allowed = torch.tensor([callee not in barred for callee in callees])
        if (end > 0.5 and None not in barred) or not allowed.any():
            return Answer(None), with_fields(decision, probability=round(end, 4))
        slot = int((probabilities[: len(callees)] * allowed).argmax())
        lost = float(torch.sigmoid(thought.lost[0, slot]))
        if lost > 0.5:
            scope, scopes = None, (Alternative(None, round(lost, 4)), *scopes)
        objects, certainty, pointers = self._objects(query.observation, states, thought, slot, callees[slot])
        values, surely, others = self._values(thought, states, hint, slot, callees[slot])
        probability = float(probabilities[slot]) * (1 - end) * certainty * surely
        signature = memory.signature(callees[slot])
        decision = with_fields(
            decision,
            probability=round(probability, 4),
            arguments=signature.join(pointers, others),
            scopes=scopes,
        )
        return Answer(callees[slot], signature.join(objects, values), scope), decision

    def _values(
        self, thought: Thought, states: States, hint: Hint, slot: int, callee: str
    ) -> tuple[tuple[str | float, ...], float, list[Ranking[str | float]]]:
        """Members and numbers, how certain they are together, and what else each might have been."""
        signature = self.core.memory.signature(callee)
        if not signature.values:
            return (), 1.0, []
        scores, numbers = self.core.evaluate(thought, states, hint, torch.tensor([slot]))
        chosen: list[str | float] = []
        certainty, others = 1.0, list[Ranking[str | float]]()
        for place, value in enumerate(signature.values):
            if not value.members:
                chosen.append(value.number(float(numbers[0, place])))
                others.append((Alternative(chosen[-1], 1.0),))
                continue
            chances = torch.softmax(scores[0, place, : len(value.members)], -1)
            chosen.append(value.members[int(chances.argmax())])
            certainty *= float(chances.max())
            others.append(ranked(value.members, chances))
        return tuple(chosen), certainty, others

    def _objects(
        self, seen: Observation, states: States, thought: Thought, slot: int, callee: str
    ) -> tuple[tuple[str, ...], float, list[Ranking[str]]]:
        """Return the arguments, how certain they are together, and what else each might have been."""
        scores = self.core.point(thought, states, torch.tensor([slot]))[0]  # (arity, things)
        rows = batches.candidate_rows(self.core.memory, callee, seen.objects)
        chances = torch.softmax(scores.masked_fill(~rows, -1e4), -1)
        names = tuple(thing.name for thing in seen.objects)
        chosen, certainty, pointers = [], 1.0, []
        for place in range(len(self.core.memory.signature(callee).object_types)):
            index = int(chances[place].argmax())
            certainty *= float(chances[place, index])
            chosen.append(names[index])
            pointers.append(ranked(names, chances[place]))
        return tuple(chosen), certainty, pointers

    def _hint(self, query: Query, states: States) -> tuple[Hint, Scope | None, Ranking[Scope | None]]:
        """Where in the scope the next call is shown: its objects, the callee's own scope, and what else."""
        if query.scope is None:
            return silent_hint(self.core, states), None, ()
        reading = self._reading(query)
        hits, none = self.core.reader.locate(reading, states)
        scoped = torch.ones(1)
        best = int(hits[0].argmax())
        shown = keyframes.within(self.demonstration, query.scope)

        begin = query.scope[0]

        def part(frame: int) -> Scope:
            """From the end of one call to the end of the next."""
            first = int(shown[frame]) + 1 if frame else begin
            return first, int(shown[int(reading.following[0, frame])]) + 1

        likely = hits[0].topk(min(TOP, len(shown)))
        parts = [None, *(part(frame) for frame in likely.indices.tolist())]
        scopes = ranked(parts, torch.cat([none, likely.values]).exp())
        if float(none[0]) > float(hits[0, best]):
            return replace(silent_hint(self.core, states), silent=scoped, scoped=scoped), None, scopes
        shown_there = (reading.relations[:1, best], reading.points[:1, best])
        hint = Hint(reading.pointers[:1, best], torch.zeros(1), scoped, *shown_there)
        return hint, part(best), scopes

    def _reading(self, query: Query) -> Reading:
        """Kept: a part of a demonstration is read once for a program."""
        names = tuple(thing.name for thing in query.observation.objects)
        if names != self._order:
            self._check_objects(names)
            self._order, self._readings = names, {}
        assert query.scope is not None
        key = (query.scope, query.program)
        if key not in self._readings:
            part = [(self.demonstration, query.scope, query.program)]
            self._readings[key] = self.core.reader(batches.frames(self.core.memory, part, [names]))
        return self._readings[key]

    def _check_objects(self, names: tuple[str, ...]) -> None:
        missing = [name for name in names if name not in self.demonstration.names]
        if missing:
            raise NtpError(f"the demonstration lacks {', '.join(missing)}; the scene has {', '.join(names)}")


def ranked(values: Sequence[Value], probabilities: Tensor) -> Ranking[Value]:
    """Return the most probable first; what has no chance is left out. Padding follows the values' own."""
    pairs = zip(values, probabilities[: len(values)].tolist(), strict=True)
    best = heapq.nlargest(TOP, pairs, key=itemgetter(1))
    return tuple(
        Alternative(value, min(1.0, round(chance, 4))) for value, chance in best if chance >= 0.00005
    )
