"""Maximum likelihood of the expert's next step: slot, end of program, scope and arguments."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits, cross_entropy, logsigmoid

from ntp_dsl.core.batches import IGNORE, Answers, Frames, States
from ntp_dsl.core.model import Core, Hint
from ntp_dsl.core.reader import Reading


def loss(core: Core, frames: Frames | None, states: States, right: Answers) -> dict[str, Tensor]:
    """Each part of the loss, weighted mean over the queries."""
    parts: dict[str, Tensor] = {}
    hint = silent_hint(core, states)
    if frames is not None:
        reading = core.reader(frames)
        hits, none = core.reader.locate(reading, states)
        parts["start"], parts["end frame"] = _scope_losses(reading, hits, none, states, right)
        hint = _told_hint(reading, states, right)
    thought = core.consider(states, hint)
    parts["end"] = _mean(
        binary_cross_entropy_with_logits(thought.end, right.end, reduction="none"), right.weight
    )
    parts["slot"] = _mean(
        cross_entropy(thought.slots, right.slot, ignore_index=IGNORE, reduction="none"),
        right.weight,
    )
    scores = core.point(thought, states, right.slot.clamp(min=0))
    scores = scores.masked_fill(~right.candidates, -1e4)
    pointing = cross_entropy(
        scores.transpose(1, 2), right.pointers, ignore_index=IGNORE, reduction="none"
    )  # (queries, arity)
    parts["arguments"] = _mean(pointing.sum(1), right.weight)
    return parts


def silent_hint(core: Core, states: States) -> Hint:
    count, things = states.positions.shape[:2]
    nothing = torch.zeros(count, device=states.positions.device)
    pointers = torch.zeros(count, things, core.config.hops, device=states.positions.device)
    return Hint(pointers, nothing, nothing)


def _told_hint(reading: Reading, states: States, right: Answers) -> Hint:
    """What the demonstration shows at the true start: the rest is learnt as if it had been found."""
    known = right.start_frame != IGNORE
    at = right.start_frame.clamp(min=0)
    pointers = reading.pointers[states.spec, at] * known[:, None, None]
    return Hint(pointers, (~known).float(), torch.ones_like(states.closed))


def _scope_losses(
    reading: Reading, hits: Tensor, none: Tensor, states: States, right: Answers
) -> tuple[Tensor, Tensor]:
    known = right.start_frame != IGNORE
    at = right.start_frame.clamp(min=0)
    start = -torch.where(known, hits.gather(1, at[:, None]).squeeze(1), none)
    events = reading.events[states.spec]  # (queries, frames)
    frame = torch.arange(events.shape[1], device=events.device)
    last = right.last_frame.clamp(min=0)
    inside = (frame >= at[:, None]) & (frame < last[:, None])
    quiet = (logsigmoid(-events) * inside).sum(1)
    end = -(quiet + logsigmoid(events.gather(1, last[:, None]).squeeze(1)))
    return _mean(start, right.weight), _mean(end * known, right.weight)


def _mean(values: Tensor, weight: Tensor) -> Tensor:
    return (values * weight).sum() / weight.sum()
