"""The core network: what to call next, on which objects, with which part of the demonstration.

Xu et al., "Neural Task Programming", ICRA 2018, Algorithm 1, made object-centric: weights are shared over
things, arguments are pointers, and callees are slots of the running program's row.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from ntp_dsl.core.per_library import features
from ntp_dsl.core.per_library.batches import States
from ntp_dsl.core.per_library.config import CoreConfig
from ntp_dsl.core.per_library.memory import Memory
from ntp_dsl.core.per_library.reader import Reader
from ntp_dsl.core.per_library.values import Values


@dataclass(frozen=True)
class Hint:
    """What the demonstration says about the next call: its objects, or that it is silent."""

    pointers: Tensor  # (queries, things, hops); zero where the demonstration is silent
    silent: Tensor  # (queries,) 1 where there is a scope and nothing in it is left to do
    scoped: Tensor  # (queries,) 1 where there is a scope
    relations: Tensor  # (queries, relations) how what it points at stands there; zero where it is silent
    points: Tensor  # (queries, hops, 3) where that is, relative to the gripper [m]; zero where it is silent

    @property
    def speaks(self) -> Tensor:
        """(queries,) whether it says anything."""
        return self.scoped.bool() & ~self.silent.bool()


def silent_hint(core: Core, states: States) -> Hint:
    """For programs that run without a part of the demonstration."""
    count, things = states.positions.shape[:2]
    nothing = torch.zeros(count, device=states.positions.device)
    pointers = torch.zeros(count, things, len(core.reader.hops), device=states.positions.device)
    relations = torch.zeros(count, core.reader.relations, device=states.positions.device)
    points = pointers.new_zeros(count, len(core.reader.hops), 3)
    return Hint(pointers, nothing, nothing, relations, points)


@dataclass(frozen=True)
class Thought:
    """The present as the running program sees it."""

    things: Tensor  # (queries, things, width)
    end: Tensor  # (queries,) logit of end-of-program
    slots: Tensor  # (queries, slots) scores; what the row does not declare is masked
    lost: Tensor  # (queries, slots) logits: the callee does what the demonstration never showed
    summary: Tensor  # (queries, width) of all that was seen
    offered: Tensor  # (queries, things, arity + hops) what may be passed on: own arguments, and what is shown


class Core(nn.Module):
    """Reads demonstrations, sees states, and answers with slots and pointers."""

    def __init__(self, config: CoreConfig, memory: Memory) -> None:
        super().__init__()
        self.config, self.memory = config, memory
        width = config.width
        self.types = nn.Embedding(len(memory.types), config.type_width)
        self.rows = nn.Embedding(len(memory.rows), config.row_width)
        self.reader = Reader(config, memory)
        given = memory.value_arity * memory.choices
        context = config.row_width + 2 + given  # the program's row, silent, scoped, its values
        compared = features.WIDTH + memory.value_arity * features.BEYOND_WIDTH  # see `_from_arguments`
        away = features.WIDTH + memory.arity * compared
        thing = away + 1 + config.type_width + memory.arity + len(self.reader.hops)
        self.see = nn.Sequential(nn.Linear(thing + context, width), nn.ReLU(), nn.Linear(width, width))
        self.messages = nn.ModuleList(Message(width) for _ in range(config.rounds))
        pooled = width * (1 + memory.arity) + context
        self.think = nn.Sequential(nn.Linear(pooled, width), nn.ReLU())
        self.end = nn.Linear(width, 1)
        self.key = nn.Linear(width, memory.slots)
        self.lost = nn.Linear(width, memory.slots)
        self.point_context = nn.Linear(memory.slots + config.row_width, width)
        self.pointer = nn.Sequential(nn.Linear(2 * width, width), nn.ReLU(), nn.Linear(width, memory.arity))
        self.offers = memory.arity + len(self.reader.hops)
        self.pass_on = nn.Linear(width, memory.arity * self.offers)
        if given:
            asked = width + memory.slots + config.row_width + self.reader.relations
            self.values = Values(memory, asked, width, len(self.reader.hops))
        self.register_buffer("keys", torch.eye(memory.slots), persistent=False)
        self.register_buffer("declared", _declared(memory), persistent=False)
        self.keys: Tensor
        self.declared: Tensor

    def consider(self, states: States, hint: Hint) -> Thought:
        context = torch.cat(
            [
                self.rows(states.rows),
                hint.silent.unsqueeze(-1),
                hint.scoped.unsqueeze(-1),
                states.values,
            ],
            -1,
        )
        count = states.positions.shape[1]
        parts = [
            features.offsets(states.positions),
            self._from_arguments(states),
            states.closed[:, None, None].expand(-1, count, 1),
            states.types @ self.types.weight,
            states.arguments,
            hint.pointers,
            context[:, None].expand(-1, count, -1),
        ]
        things = self.see(torch.cat(parts, -1))  # (queries, things, width)
        away = features.offsets(states.positions[:, None] - states.positions[:, :, None])
        for message in self.messages:
            things = message(things, away, states.things)
        hidden = things.masked_fill(~states.things.unsqueeze(-1), -1e4)
        called_with = torch.einsum("qna,qnw->qaw", states.arguments, things).flatten(1)
        thought = self.think(torch.cat([hidden.amax(1), called_with, context], -1))
        scores = self.key(thought) @ self.keys.T  # (queries, slots)
        scores = scores.masked_fill(~self.declared[states.rows], -1e4)
        end = self.end(thought).squeeze(-1)
        offered = torch.cat([states.arguments, hint.pointers], -1)
        return Thought(things, end, scores, self.lost(thought), thought, offered)

    def point(self, thought: Thought, states: States, slots: Tensor) -> Tensor:
        """Scores (queries, arity, things) of what each argument of the callee in a slot points at."""
        context = torch.cat([self.keys[slots], self.rows(states.rows)], -1)
        context = self.point_context(context)
        there = torch.cat([thought.things, context[:, None].expand_as(thought.things)], -1)
        weights = self.pass_on(context).reshape(len(slots), self.memory.arity, self.offers)
        scores = self.pointer(there).transpose(1, 2)
        scores = scores + torch.einsum("qao,qno->qan", weights, thought.offered)
        visible: Tensor = scores.masked_fill(~states.things[:, None], -1e4)
        return visible

    def _from_arguments(self, states: States) -> Tensor:
        """Return how each object lies to each that the program was given, (queries, objects, features).

        As an offset, and as how far past each number that it was given.
        """
        places = torch.einsum("qna,qnd->qad", states.arguments, states.positions)
        away = states.positions.unsqueeze(2) - places.unsqueeze(1)  # (queries, things, arity, 3)
        given = states.arguments.sum(1)[:, None, :, None]  # (queries, 1, arity, 1)
        seen = [features.offsets(away) * given]
        if self.memory.value_arity:
            for number, exists in zip(*(each.T for each in self.values.given(states)), strict=True):
                farther = features.beyond(away, number[:, None, None])
                seen.append(farther * given * exists[:, None, None, None])
        return torch.cat(seen, -1).flatten(2)

    def evaluate(self, thought: Thought, states: States, hint: Hint, slots: Tensor) -> tuple[Tensor, Tensor]:
        """For the values of the callee in a slot: scores of members, and numbers from 0 to 1.

        (queries, value_arity, choices - 1) and (queries, value_arity).
        """
        asked = [thought.summary, self.keys[slots], self.rows(states.rows), hint.relations]
        answer: tuple[Tensor, Tensor] = self.values(
            torch.cat(asked, -1), states, hint.points, hint.speaks, slots
        )
        return answer


SILENCE = -1e4  # is not heard


class Message(nn.Module):
    """Each thing hears the loudest of all others, by how they lie to each other."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.listener = nn.Linear(width, width)
        self.speaker = nn.Linear(width, width, bias=False)
        self.offset = nn.Linear(features.WIDTH, width, bias=False)
        self.update = nn.Sequential(nn.Linear(2 * width, width), nn.ReLU(), nn.Linear(width, width))

    def forward(self, things: Tensor, away: Tensor, there: Tensor) -> Tensor:
        """things: (batch, things, width); away: (batch, things, things, features)."""
        spoken = self.speaker(things).masked_fill(~there.unsqueeze(-1), SILENCE)
        heard = self.listener(things).unsqueeze(2) + spoken.unsqueeze(1) + self.offset(away)
        loudest = torch.relu(heard.max(2).values)  # (batch, listener, width), of (…, speaker, width)
        updated: Tensor = self.update(torch.cat([things, loudest], -1))
        return things + updated


def _declared(memory: Memory) -> Tensor:
    """(rows, slots): which slots a row has."""
    return torch.tensor([[slot < len(row.callees) for slot in range(memory.slots)] for row in memory.rows])
