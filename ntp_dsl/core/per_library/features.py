"""Offsets in space at several scales, so that millimetres and decimetres are both within reach."""

from __future__ import annotations

from math import log

import torch
from torch import Tensor

SCALES = (3.0, 10.0, 33.0)  # [1/m]
SHARPNESS = (20.0, 60.0)  # [1/m]
WIDTH, BEYOND_WIDTH = (n * (len(SCALES) + len(SHARPNESS)) for n in (4, 10))
LENGTHS = 10  # in a vector, that a number may be copied from


def offsets(vectors: Tensor) -> Tensor:
    """(..., 3) in metres to (..., WIDTH): each of x, y, z and the horizontal distance at every scale."""
    return _scaled(torch.cat([vectors, _horizontal(vectors)], -1))


def lengths_in(vectors: Tensor) -> Tensor:
    """(..., 3) to (..., LENGTHS): along x, y and z, the same backwards and unsigned, and horizontally [m]."""
    return torch.cat([vectors, -vectors, vectors.abs(), _horizontal(vectors)], -1)


def beyond(vectors: Tensor, lengths: Tensor) -> Tensor:
    """(..., 3) and (...) in metres to (..., BEYOND_WIDTH): how far past a length, either way or both."""
    length = lengths.unsqueeze(-1)
    past = [vectors - length, vectors + length, vectors.abs() - length, _horizontal(vectors) - length]
    return _scaled(torch.cat(past, -1))


def _horizontal(vectors: Tensor) -> Tensor:
    """(..., 3) to (..., 1): the distance seen from above."""
    distance: Tensor = torch.linalg.vector_norm(vectors[..., :2], dim=-1, keepdim=True)
    return distance


def _scaled(values: Tensor) -> Tensor:
    """(..., n) to (..., n * scales)."""
    size = values.abs()
    scaled = [torch.tanh(scale * values) for scale in SCALES]
    return torch.cat([*scaled, *(torch.exp(-sharp * size) for sharp in SHARPNESS)], -1)


FADES = 0.8  # a frame: how fast it is forgotten that a thing was moved
NOTICED = 20.0  # [1/m]
LEAST = 1e-4  # of a motion, so that it has a logarithm [m]


@torch.no_grad()
def moved(positions: Tensor, still: Tensor) -> Tensor:
    """How far each thing has lately been moved by itself: what was carried, also when it was let go.

    Where several things lie close together, where they are does not tell which was put there last.

    positions: (specs, frames, things, 3) relative to the gripper; still: (specs, things) which of them
    stay where they are, as by far the most do where nothing better is known.
    Returns (specs, frames, things) in [0, 1).
    """
    steps = positions[:, 1:] - positions[:, :-1]
    seen = steps.masked_fill(~still[:, None, :, None], torch.nan)
    own = steps - seen.nanmedian(2, keepdim=True).values
    far = torch.linalg.vector_norm(own, dim=-1).clamp(min=LEAST)
    far = torch.cat([torch.full_like(positions[:, :1, :, 0], LEAST), far], 1)  # (specs, frames, things)
    age = log(FADES) * torch.arange(far.shape[1], device=far.device)[:, None]
    lately = ((far.log() - age).cummax(1).values + age).exp()
    return torch.tanh(NOTICED * lately)
