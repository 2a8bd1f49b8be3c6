"""What a call takes besides objects: members of enumerations, and numbers, copied where they can be."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from ntp_dsl.core.per_library import features
from ntp_dsl.core.per_library.batches import States
from ntp_dsl.core.per_library.memory import Memory, Signature

NEVER = -1e4  # is not chosen


class Values(nn.Module):
    """Scores members, and weighs where a number may come from: what was given, what is shown, or neither.

    A copied number is exact, also when it is passed on from program to program; compare See et al., "Get To
    The Point: Summarization with Pointer-Generator Networks", ACL 2017.

    Args:
        asked: width of what the answer hangs on.
        width: of the hidden layer.
        points: how many a demonstration points at.
    """

    def __init__(self, memory: Memory, asked: int, width: int, points: int) -> None:
        super().__init__()
        self.arity, self.choices = memory.value_arity, memory.choices
        self.sources = self.arity + features.LENGTHS * (2 * points - 1)  # of a number; see `_sources`
        answers = self.arity * (self.choices + self.sources + 1)
        self.answer = nn.Sequential(nn.Linear(asked, width), nn.ReLU(), nn.Linear(width, answers))
        self.register_buffer("own_ranges", _own_ranges(memory), persistent=False)
        self.register_buffer("callees_ranges", _callees_ranges(memory), persistent=False)
        self.own_ranges: Tensor
        self.callees_ranges: Tensor

    def forward(
        self, asked: Tensor, states: States, points: Tensor, speaks: Tensor, slots: Tensor
    ) -> tuple[Tensor, Tensor]:
        """For the callee in a slot: scores of members, and numbers from 0 to 1 of their ranges.

        asked: (queries, asked); points: (queries, points, 3) where they were [m]; speaks: (queries,) whether
        the demonstration says anything. Returns (queries, arity, choices - 1) and (queries, arity).
        """
        answer = self.answer(asked).reshape(len(slots), self.arity, -1)
        members, free, weights = answer.split([self.choices - 1, 1, self.sources + 1], -1)
        found, there = self._sources(states, points, speaks)
        low, span, _ = self.callees_ranges[states.rows, slots].unbind(-1)  # (queries, arity)
        scaled = ((found.unsqueeze(1) - low.unsqueeze(-1)) / span.unsqueeze(-1)).clamp(0, 1)
        possible = nn.functional.pad(there, (1, 0), value=True)  # the free number always is
        weights = torch.softmax(weights.masked_fill(~possible.unsqueeze(1), NEVER), -1)
        return members, (weights * torch.cat([free, scaled], -1)).sum(-1)

    def given(self, states: States) -> tuple[Tensor, Tensor]:
        """Return the numbers that the program was given, in SI units, and which of its values are numbers.

        Both are (queries, arity).
        """
        scaled = states.values.reshape(-1, self.arity, self.choices)[..., -1]
        low, span, known = self.own_ranges[states.rows].unbind(-1)
        return low + span * scaled, known.bool()

    def _sources(self, states: States, points: Tensor, speaks: Tensor) -> tuple[Tensor, Tensor]:
        """Where a number may come from, in SI units, and which of these there are: (queries, sources).

        What the program was given, and how far the objects that the demonstration points at lie from the
        gripper and from each other.
        """
        numbers, known = self.given(states)
        between = points[:, 1:] - points[:, :-1]
        shown = features.lengths_in(torch.cat([points, between], 1)).flatten(1)
        return torch.cat([numbers, shown], 1), torch.cat([known, speaks.unsqueeze(1).expand_as(shown)], 1)


def _own_ranges(memory: Memory) -> Tensor:
    """(rows, arity, 3): of each value that a program is given, as `_ranges` says."""
    return torch.stack([_ranges(memory, row.signature) for row in memory.rows])


def _callees_ranges(memory: Memory) -> Tensor:
    """(rows, slots, arity, 3): the same of what each slot is called with."""
    ranges = torch.zeros(len(memory.rows), memory.slots, memory.value_arity, 3)
    ranges[..., 1] = 1.0
    for place, row in enumerate(memory.rows):
        for slot, callee in enumerate(row.callees):
            ranges[place, slot] = _ranges(memory, memory.signature(callee))
    return ranges


def _ranges(memory: Memory, signature: Signature) -> Tensor:
    """(arity, 3): the lower end of each value's range, its width, and whether it is a number at all."""
    rows = [
        (0.0, 1.0, 0.0) if value.members else (value.low, max(value.high - value.low, 1e-9), 1.0)
        for value in signature.values
    ]
    return torch.tensor([*rows, *[(0.0, 1.0, 0.0)] * (memory.value_arity - len(rows))])
