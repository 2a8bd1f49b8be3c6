"""What the core is told of where objects are and of what was moved."""

from __future__ import annotations

import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from torch import Tensor

from ntp_dsl.core.per_library.features import BEYOND_WIDTH, LENGTHS, beyond, lengths_in, moved, offsets

seeds = st.integers(0, 2**31 - 1)
CARRIED, LET_GO, FRAMES, THINGS = 2, 8, 12, 5


def carrying(seed: int) -> Tensor:
    """(1, frames, objects, 3): the hand carries one object, lets it go among the others, and leaves."""
    generator = torch.Generator().manual_seed(seed)
    others = 0.02 * torch.rand(THINGS, 3, generator=generator)  # all within two centimetres
    steps = 0.05 * torch.nn.functional.normalize(torch.randn(FRAMES, 3, generator=generator), dim=-1)
    hand = steps.cumsum(0)
    world = others.expand(FRAMES, THINGS, 3).clone()
    world[:LET_GO, CARRIED] = hand[:LET_GO]
    world[LET_GO:, CARRIED] = hand[LET_GO - 1]
    return (world - hand[:, None]).unsqueeze(0)


@given(seeds)
@settings(max_examples=30, deadline=None)
def test_what_was_carried_stands_out_also_after_it_was_let_go(seed: int) -> None:
    told = moved(carrying(seed), torch.ones(1, THINGS, dtype=torch.bool))[0]
    assert (told[1:].argmax(1) == CARRIED).all() and (told[1:, CARRIED] > 0.3).all()
    still = torch.arange(THINGS) != CARRIED
    assert (told[:, still] < 0.01).all()


@given(seeds)
@settings(max_examples=30, deadline=None)
def test_the_order_of_objects_and_those_that_are_not_there_do_not_matter(seed: int) -> None:
    positions, there = carrying(seed), torch.ones(1, THINGS, dtype=torch.bool)
    told = moved(positions, there)
    order = torch.randperm(THINGS, generator=torch.Generator().manual_seed(seed))
    assert torch.allclose(moved(positions[:, :, order], there), told[:, :, order])
    padded = torch.cat([positions, torch.zeros(1, FRAMES, 3, 3)], 2)
    seen = torch.cat([there, torch.zeros(1, 3, dtype=torch.bool)], 1)
    assert torch.allclose(moved(padded, seen)[:, :, :THINGS], told)


def test_a_single_frame_tells_of_no_motion() -> None:
    told = moved(carrying(0)[:, :1], torch.ones(1, THINGS, dtype=torch.bool))
    assert told.shape == (1, 1, THINGS) and (told < 0.01).all()


@given(seeds)
@settings(max_examples=30, deadline=None)
def test_a_length_is_compared_with_how_far_objects_are_apart(seed: int) -> None:
    generator = torch.Generator().manual_seed(seed)
    away = 0.3 * torch.randn(4, 3, generator=generator)
    nothing = offsets(torch.zeros(4, 3)).reshape(4, -1, 4)[..., 0]
    lengths = lengths_in(away)
    for length, compared in enumerate(range(LENGTHS)):
        told = beyond(away, lengths[:, length]).reshape(4, -1, 10)[..., compared]
        assert torch.allclose(told, nothing, atol=1e-6)
    assert lengths.shape == (4, LENGTHS) and beyond(away, lengths[:, 0]).shape == (4, BEYOND_WIDTH)


@given(seeds)
@settings(max_examples=30, deadline=None)
def test_what_is_carried_with_all_that_is_in_it_is_told_from_what_stays(seed: int) -> None:
    positions = carrying(seed)
    still = torch.zeros(1, THINGS, dtype=torch.bool)
    still[0, 0] = True  # the others go with what is carried
    hand = positions[:, :, 0] - positions[:, :1, 0]
    positions[:, :LET_GO, 1:] = positions[:, :1, 1:]
    since = hand[:, LET_GO:] - hand[:, LET_GO - 1 : LET_GO]  # it was let go
    positions[:, LET_GO:, 1:] = positions[:, :1, 1:] + since.unsqueeze(2)
    told = moved(positions, still)[0]
    assert (told[1:, 1:] > 0.3).all() and (told[:, 0] < 0.01).all()
