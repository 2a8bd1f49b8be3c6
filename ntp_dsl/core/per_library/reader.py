"""f_TSE and f_TSI: reads a demonstration, frame by frame, as pointers at objects and events between them."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn.functional import one_hot

from ntp_dsl.core.per_library import features
from ntp_dsl.core.per_library.batches import Frames, States
from ntp_dsl.core.per_library.config import CoreConfig
from ntp_dsl.core.per_library.memory import Memory
from ntp_dsl.core.per_library.scopes import first_hit, look_ahead, next_event

NEVER, ALWAYS = -20.0, 20.0  # logits
NEARNESS = 30.0  # [1/m] where training starts: a hop goes to what is near the one before
NOVELTY = 5.0  # [logit] and to none that was visited before


@dataclass(frozen=True)
class Reading:
    """What each frame of each part of a demonstration leads to: the next event, and what it shows.

    Computed once for a part; a decision compares it with the present.
    """

    pointers: Tensor  # (specs, frames, things, hops) at the objects of the next event
    relations: Tensor  # (specs, frames, relations) how these stood to each other at that event
    points: Tensor  # (specs, frames, hops, 3) where they were, relative to the gripper [m]
    shown: Tensor  # (specs, frames, width) the same, as it is compared with the present
    events: Tensor  # (specs, frames) logits: something ends with this frame
    following: Tensor  # (specs, frames) number of the most probable next event
    mask: Tensor  # (specs, frames)


class Reader(nn.Module):
    """Each frame throws `hops` soft pointers, each at an object near the one before; events gate them."""

    def __init__(self, config: CoreConfig, memory: Memory) -> None:
        super().__init__()
        self.types = nn.Embedding(len(memory.types), config.type_width)
        self.rows = nn.Embedding(len(memory.rows), config.row_width)
        width, seen = config.width, features.WIDTH
        thing = 2 * seen + 3 + config.type_width  # to gripper, to last hop; visited, moved, closed
        hops = config.pointers(memory.arity)
        self.hops = nn.ModuleList(
            nn.Sequential(nn.Linear(thing, width // 2), nn.ReLU(), nn.Linear(width // 2, 1))
            for _ in range(hops)
        )
        self.nearness = nn.Parameter(torch.full((hops,), NEARNESS))
        self.novelty = nn.Parameter(torch.full((hops,), NOVELTY))
        self.relations = 2 * seen * hops - seen + 1  # to gripper, between hops, closed
        frame = self.relations + hops * (1 + config.type_width) + 3  # continuity, types, the gripper's motion
        self.frame = nn.Linear(frame + config.row_width, width)
        pad = config.kernel // 2
        self.convolutions = nn.ModuleList(
            nn.Conv1d(width, width, config.kernel, padding=pad) for _ in range(2)
        )
        self.event = nn.Linear(width, 1)
        self.shown = nn.Linear(self.relations + config.row_width, width)
        self.present = nn.Linear(self.relations + seen * (hops - 1), width)
        self.unmet = nn.Sequential(
            nn.ReLU(), nn.Linear(width, width // 2), nn.ReLU(), nn.Linear(width // 2, 1)
        )

    def forward(self, frames: Frames) -> Reading:
        """Soft while training; a reading that is acted upon makes up its mind.

        Soft pointers and events leak a little of each later event into the ones before: harmless in short
        demonstrations, and wrong in long ones.
        """
        pointers, points = self._point(frames)
        relations = self._relations(points, frames.closed.unsqueeze(-1))
        events = self._events(frames, pointers, relations)
        following = torch.empty(0) if self.training else next_event(events, frames.mask)
        if self.training:
            gates = torch.sigmoid(events) * frames.mask
            flat = pointers.flatten(2)  # (specs, frames, things * hops)
            parts = [flat, points.flatten(2), relations]
            ahead = look_ahead(gates, torch.cat(parts, -1))
            flat, flat_points, relations = torch.split(ahead, [part.shape[-1] for part in parts], -1)
            pointers, points = flat.reshape(pointers.shape), flat_points.reshape(points.shape)
        else:
            pointers = one_hot(pointers.argmax(2), pointers.shape[2]).transpose(2, 3).float()
            points = torch.einsum("stnh,stnd->sthd", pointers, frames.positions)
            relations = self._relations(points, frames.closed.unsqueeze(-1))
            spec = torch.arange(len(events))[:, None]
            pointers, points = pointers[spec, following], points[spec, following]
            relations = relations[spec, following]
        rows = self.rows(frames.rows)[:, None].expand(*frames.closed.shape, -1)
        shown = self.shown(torch.cat([relations, rows], -1))
        return Reading(pointers, relations, points, shown, events, following, frames.mask)

    def locate(self, reading: Reading, states: States) -> tuple[Tensor, Tensor]:
        """First-hit over frames of the first event that the present does not meet yet.

        For the queries that have a part of a demonstration. Returns log-probabilities (queries, frames)
        and, that there is none, (queries).
        """
        spec = states.spec
        pointers = reading.pointers[spec]  # (queries, frames, things, hops)
        now = torch.einsum("qtnh,qnd->qthd", pointers, states.positions)
        closed = states.closed[:, None, None].expand(*now.shape[:2], 1)
        moved = features.offsets(_between(now) - _between(reading.points[spec])).flatten(-2)
        seen = torch.cat([self._relations(now, closed), moved], -1)
        compared = self.present(seen) + reading.shown[spec]
        logits = self.unmet(compared).squeeze(-1)
        return first_hit(logits, reading.mask[spec])

    def _point(self, frames: Frames) -> tuple[Tensor, Tensor]:
        """Pointers (specs, frames, things, hops), and where they point (specs, frames, hops, 3)."""
        positions = frames.positions
        near = features.offsets(positions)
        types = (frames.types @ self.types.weight)[:, None].expand(*positions.shape[:3], -1)
        closed = frames.closed[..., None, None].expand(*positions.shape[:3], 1)
        moved = features.moved(positions, frames.still).unsqueeze(-1)
        hidden = ~frames.things[:, None]
        visited = torch.zeros_like(closed)
        here = torch.zeros_like(positions[:, :, 0])
        pointers, points = [], []
        for hop, nearness, novelty in zip(self.hops, self.nearness, self.novelty, strict=True):
            away = positions - here.unsqueeze(2)
            seen = torch.cat([near, features.offsets(away), visited, moved, closed, types], -1)
            distance = torch.linalg.vector_norm(away, dim=-1)
            scores = hop(seen).squeeze(-1) - nearness * distance - novelty * visited.squeeze(-1)
            pointer = torch.softmax(scores.masked_fill(hidden, -1e4), -1)  # (specs, frames, things)
            here = torch.einsum("stn,stnd->std", pointer, positions)
            visited = torch.maximum(visited, pointer.unsqueeze(-1))
            pointers.append(pointer)
            points.append(here)
        return torch.stack(pointers, -1), torch.stack(points, 2)

    def _relations(self, points: Tensor, closed: Tensor) -> Tensor:
        """How the pointed-at objects stand to the gripper and to each other. points: (…, hops, 3)."""
        to_gripper = features.offsets(points).flatten(-2)
        between = features.offsets(_between(points)).flatten(-2)
        return torch.cat([to_gripper, between, closed], -1)

    def _events(self, frames: Frames, pointers: Tensor, relations: Tensor) -> Tensor:
        """Logits (specs, frames): a call of this program's body ends with this frame."""
        following = torch.cat([pointers[:, 1:], pointers[:, -1:]], 1)
        continuity = (pointers * following).sum(2)  # (specs, frames, hops)
        shift = torch.zeros_like(frames.positions[:, :, 0])
        count = frames.things.sum(1).clamp(min=1)[:, None, None]
        step = frames.positions[:, 1:] - frames.positions[:, :-1]
        shift[:, :-1] = (step * frames.things[:, None, :, None]).sum(2) / count
        types = frames.types @ self.types.weight * frames.typed[:, None, None]
        kinds = torch.einsum("stnh,snw->sthw", pointers, types).flatten(2)
        rows = self.rows(frames.rows)[:, None].expand(*frames.closed.shape, -1)
        hidden = self.frame(torch.cat([relations, continuity, kinds, torch.tanh(20 * shift), rows], -1))
        seen = frames.mask.unsqueeze(-1)
        for convolution in self.convolutions:  # nothing beyond the scope's border leaks in
            inward = (torch.relu(hidden) * seen).transpose(1, 2)
            hidden = hidden + convolution(inward).transpose(1, 2)
        logits = self.event(torch.relu(hidden)).squeeze(-1).clamp(NEVER, ALWAYS)
        last = frames.mask & ~torch.cat([frames.mask[:, 1:], frames.mask[:, :1] & False], 1)
        return torch.where(last, torch.full_like(logits, ALWAYS), logits)  # a scope ends with an event


def _between(points: Tensor) -> Tensor:
    """(..., hops, 3) to (..., hops - 1, 3): from each object to the next [m]."""
    return points[..., 1:, :] - points[..., :-1, :]
