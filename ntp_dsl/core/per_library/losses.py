"""Maximum likelihood of the expert's next step: slot, end of program, scope and arguments."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import (
    binary_cross_entropy_with_logits,
    cross_entropy,
    logsigmoid,
    one_hot,
    smooth_l1_loss,
)

from ntp_dsl.core.per_library.batches import IGNORE, NOTHING, Answers, Frames, States
from ntp_dsl.core.per_library.model import Core, Hint, Thought, silent_hint
from ntp_dsl.core.per_library.reader import Reading


def loss(core: Core, frames: Frames | None, states: States, right: Answers) -> dict[str, Tensor]:
    """Each part of the loss, weighted mean over the queries."""
    parts: dict[str, Tensor] = {}
    hint = silent_hint(core, states)
    if frames is not None:
        reading = core.reader(frames)
        hits, none = core.reader.locate(reading, states)
        parts["start"], parts["end frame"] = _scope_losses(reading, hits, none, states, right)
        hint = _hint(reading, hits, none, states, right)
        parts["shown"] = _shown_loss(reading, states, right)
    thought = core.consider(states, hint)
    if frames is not None:
        parts["lost"] = _lost_loss(thought.lost, right)
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
    if core.memory.value_arity:
        parts["values"] = _values_loss(core, thought, states, hint, right)
    return parts


def _values_loss(core: Core, thought: Thought, states: States, hint: Hint, right: Answers) -> Tensor:
    """Members by their likelihood, numbers by their distance in tenths of their range."""
    scores, numbers = core.evaluate(thought, states, hint, right.slot.clamp(min=0))
    chosen = torch.zeros_like(numbers)  # (queries, value_arity)
    if core.memory.choices > 1:  # where there are enumerations at all
        scores = scores.masked_fill(~right.choosable, -1e4)
        chosen = cross_entropy(scores.transpose(1, 2), right.members, ignore_index=IGNORE, reduction="none")
    known = ~right.numbers.isnan()
    wanted = torch.where(known, right.numbers, numbers.detach())
    away = smooth_l1_loss(10 * numbers, 10 * wanted, reduction="none")
    return _mean((chosen + away).sum(1), right.weight)


def _hint(reading: Reading, hits: Tensor, none: Tensor, states: States, right: Answers) -> Hint:
    """Return what is shown at the true start; or, now and then, what the reader itself makes of it.

    A decision that was only ever told the truth would trust a reader that errs.
    """
    start = right.start_frame
    frames = hits.shape[1]
    read = torch.cat([hits, none.unsqueeze(1)], 1).argmax(1)  # (queries,), `frames` for nothing
    true = torch.where(start == NOTHING, frames, start)
    chosen = torch.where(right.told & (start != IGNORE), true, read)
    weights = one_hot(chosen, frames + 1)[:, :frames].float()
    pointers = torch.einsum("qt,qtnh->qnh", weights, reading.pointers[states.spec])
    relations = torch.einsum("qt,qtr->qr", weights, reading.relations[states.spec])
    points = torch.einsum("qt,qthd->qhd", weights, reading.points[states.spec])
    return Hint(pointers, (chosen == frames).float(), torch.ones_like(none), relations, points)


def _scope_losses(
    reading: Reading, hits: Tensor, none: Tensor, states: States, right: Answers
) -> tuple[Tensor, Tensor]:
    known = right.start_frame >= 0
    at = right.start_frame.clamp(min=0)
    found = torch.where(known, hits.gather(1, at[:, None]).squeeze(1), none)
    start = -found * (right.start_frame != IGNORE)
    events = reading.events[states.spec]  # (queries, frames)
    frame = torch.arange(events.shape[1], device=events.device)
    last = right.last_frame.clamp(min=0)
    inside = (frame > at[:, None]) & (frame < last[:, None])
    quiet = (logsigmoid(-events) * inside).sum(1)
    end = -(quiet + logsigmoid(events.gather(1, last[:, None]).squeeze(1)))
    return _mean(start, right.weight), _mean(end * known, right.weight)


def _shown_loss(reading: Reading, states: States, right: Answers) -> Tensor:
    """Return the loss of the best hop from the true start to what the callee is called with."""
    known = (right.start_frame >= 0)[:, None] & (right.pointers != IGNORE)  # (queries, arity)
    pointers = reading.pointers[states.spec, right.start_frame.clamp(min=0)]  # (queries, things, hops)
    index = right.pointers.clamp(min=0).unsqueeze(-1).expand(-1, -1, pointers.shape[-1])
    pointed = pointers.gather(1, index).amax(-1)  # (queries, arity)
    values = -(pointed.clamp(min=1e-6).log() * known).sum(1)
    return _mean(values, right.weight)


def _lost_loss(logits: Tensor, right: Answers) -> Tensor:
    asked = (right.lost != IGNORE).float()
    chosen = logits.gather(1, right.slot.clamp(min=0)[:, None]).squeeze(1)
    values = binary_cross_entropy_with_logits(chosen, right.lost.float(), reduction="none")
    return _mean(values * asked, right.weight)


def _mean(values: Tensor, weight: Tensor) -> Tensor:
    return (values * weight).sum() / weight.sum()
