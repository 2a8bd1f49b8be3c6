"""First hits are a distribution, and looking ahead is what the slow recursion says."""

from __future__ import annotations

import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from ntp_dsl.core.per_library.features import WIDTH, offsets
from ntp_dsl.core.per_library.scopes import first_hit, look_ahead, next_event

seeds = st.integers(0, 2**31 - 1)


@given(seeds, st.integers(1, 40))
@settings(max_examples=50, deadline=None)
def test_either_some_frame_fires_first_or_none_does(seed: int, frames: int) -> None:
    generator = torch.Generator().manual_seed(seed)
    logits = 4 * torch.randn(3, frames, generator=generator)
    mask = torch.arange(frames) < torch.tensor([[1], [frames], [(frames + 1) // 2]])
    hits, none = first_hit(logits, mask)
    total = (hits.exp() * mask).sum(-1) + none.exp()
    assert torch.allclose(total, torch.ones(3), atol=1e-5)
    assert (hits.exp()[~mask] == 0).all()


def test_frames_before_the_first_that_fires_do_not_count_after_it() -> None:
    logits = torch.tensor([[-20.0, 20.0, 20.0, -20.0]])
    hits, none = first_hit(logits, torch.ones(1, 4, dtype=torch.bool))
    assert hits.exp().argmax() == 1 and hits.exp()[0, 1] > 0.999 and none.exp() < 1e-6


@given(seeds, st.integers(2, 70))
@settings(max_examples=50, deadline=None)
def test_looking_ahead_is_the_recursion_solved(seed: int, frames: int) -> None:
    generator = torch.Generator().manual_seed(seed)
    gates = torch.rand(2, frames, generator=generator)
    values = torch.randn(2, frames, 3, generator=generator)
    ahead = torch.zeros(2, frames + 1, 3)
    for frame in reversed(range(frames)):
        gate = gates[:, frame, None]
        ahead[:, frame] = gate * values[:, frame] + (1 - gate) * ahead[:, frame + 1]
    seen = look_ahead(gates, values)
    assert torch.allclose(seen[:, :-1], ahead[:, 1:-1], atol=1e-4)
    assert torch.allclose(seen[:, -1], ahead[:, -2], atol=1e-4)


@given(seeds, st.integers(2, 30))
@settings(max_examples=50, deadline=None)
def test_the_next_event_is_the_most_probable_first_hit_after_a_frame(seed: int, frames: int) -> None:
    logits = 3 * torch.randn(1, frames, generator=torch.Generator().manual_seed(seed))
    logits[0, -1] = 20.0
    following = next_event(logits, torch.ones(1, frames, dtype=torch.bool))
    for frame in range(frames - 1):
        later = torch.ones(1, frames - frame - 1, dtype=torch.bool)
        hits, _ = first_hit(logits[:, frame + 1 :], later)
        chosen = hits[0, following[0, frame] - frame - 1]
        assert following[0, frame] > frame and chosen >= hits.max() - 1e-4


def test_offsets_tell_millimetres_and_decimetres_apart() -> None:
    places = torch.tensor([[0.0, 0, 0], [0.004, 0, 0], [0.1, 0, 0], [0.15, 0, 0]])
    seen = offsets(places)
    assert seen.shape == (4, WIDTH)
    gaps = torch.cdist(seen, seen) + 10 * torch.eye(4)
    assert gaps.min() > 0.1
