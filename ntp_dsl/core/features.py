"""Offsets in space at several scales, so that millimetres and decimetres are both within reach."""

from __future__ import annotations

import torch
from torch import Tensor

SCALES = (3.0, 10.0, 33.0)  # [1/m]
SHARPNESS = (20.0, 60.0)  # [1/m]
WIDTH = 4 * (len(SCALES) + len(SHARPNESS))


def offsets(vectors: Tensor) -> Tensor:
    """(..., 3) in metres to (..., WIDTH): each of x, y, z and the horizontal distance at every scale."""
    flat = torch.linalg.vector_norm(vectors[..., :2], dim=-1, keepdim=True)
    values = torch.cat([vectors, flat], -1)  # (..., 4)
    size = values.abs()
    scaled = [torch.tanh(scale * values) for scale in SCALES]
    return torch.cat([*scaled, *(torch.exp(-sharp * size) for sharp in SHARPNESS)], -1)
