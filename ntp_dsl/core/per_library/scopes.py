"""First-hit distributions over frames: which frame is the first that fires, and what lies there.

In place of the paper's four labels a frame and two argmaxes, the start of a scope is the first frame whose
hazard fires, its end the first event from there on, and «none» is what is left over. All of it is linear in
frames up to a logarithm, and needs no matrix of frames by frames.
"""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import logsigmoid


def first_hit(logits: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
    """Log-probability that each frame is the first to fire, and that none does.

    logits, mask: (..., frames). Returns (..., frames) and (...).
    """
    quiet = torch.where(mask, logsigmoid(-logits), torch.zeros_like(logits))
    before = torch.cumsum(quiet, -1) - quiet
    hit = torch.where(mask, logsigmoid(logits) + before, torch.full_like(logits, -1e4))
    return hit, quiet.sum(-1)


def look_ahead(gates: Tensor, values: Tensor) -> Tensor:
    """Return what the event after each frame shows: z[t] = y[t + 1], y[t] = g[t] v[t] + (1 - g[t]) y[t + 1].

    The frame with which a call ends is where the next one starts, so an event at the frame itself is left
    out; the last frame, which has none after it, sees itself.

    gates: (batch, frames) in [0, 1]; values: (batch, frames, width). Solved by doubling.
    """
    keep = (1 - gates).unsqueeze(-1)  # (batch, frames, 1)
    result = gates.unsqueeze(-1) * values
    step = 1
    while step < gates.shape[1]:
        later = torch.cat([result[:, step:], torch.zeros_like(result[:, :step])], 1)
        result = result + keep * later
        keep = keep * torch.cat([keep[:, step:], torch.zeros_like(keep[:, :step])], 1)
        step *= 2
    return torch.cat([result[:, 1:], result[:, -1:]], 1)


def next_event(logits: Tensor, mask: Tensor) -> Tensor:
    """Return the most probable next event after each frame, (batch, frames); see `look_ahead`.

    One pass from the end: the first hit from t is at t itself, or else where it is from t + 1.
    """
    chance = torch.sigmoid(logits) * mask
    frames = logits.shape[1]
    where = torch.full_like(logits, frames - 1, dtype=torch.long)  # (batch, frames)
    following = where.clone()
    best = torch.zeros_like(logits[:, 0])
    for frame in range(frames - 1, -1, -1):
        if frame + 1 < frames:
            following[:, frame] = where[:, frame + 1]
        later = (1 - chance[:, frame]) * best
        here = chance[:, frame] >= later
        best = torch.where(here, chance[:, frame], later)
        next_where = where[:, frame + 1] if frame + 1 < frames else where[:, frame]
        where[:, frame] = torch.where(here & mask[:, frame], frame, next_where)
    return following
