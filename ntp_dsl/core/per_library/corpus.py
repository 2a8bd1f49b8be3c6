"""The training set as tensors: made once, drawn from without end."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import TypeVar

import numpy as np
import torch
from torch import Tensor

from ntp_dsl.core.per_library import batches, keyframes
from ntp_dsl.core.per_library.batches import Answers, Frames, States
from ntp_dsl.core.per_library.config import TrainingConfig
from ntp_dsl.core.per_library.memory import Memory
from ntp_dsl.demonstrations.demonstration import Scope
from ntp_dsl.demonstrations.queries import Sample

Batch = tuple[Frames | None, States, Answers]
Struct = TypeVar("Struct", States, Answers, Frames)


class Corpus:
    """Samples in groups: with a whole demonstration, with a part of one, without, and of new states."""

    def __init__(
        self,
        memory: Memory,
        samples: Sequence[Sample],
        takes_list: Callable[[str], bool],
    ) -> None:
        self.memory = memory
        self._samples = samples
        queries = [sample.query for sample in samples]
        self._states = batches.states(memory, queries, [-1] * len(samples))
        self._answers = batches.answers(
            memory,
            queries,
            [sample.answer for sample in samples],
            _weights(samples),
            self._states.positions.shape[1],
        )
        whole: dict[tuple[int, Scope, str], list[int]] = defaultdict(list)
        self._scoped: list[int] = []
        self._unscoped: list[int] = []
        self._new: list[int] = []
        for index, sample in enumerate(samples):
            query = sample.query
            if sample.is_new:
                self._new.append(index)
            elif query.scope is not None and takes_list(query.program):
                whole[id(query.demonstration), query.scope, query.program].append(index)
            else:
                self._unscoped.append(index)
                if query.scope is not None:
                    self._scoped.append(index)
        self._lists = list(whole.values())  # what shares a part of a demonstration, which is read once
        self._length = float(np.mean([self._frames(first) for first, *_ in self._lists] or [1]))

    def __len__(self) -> int:
        return len(self._samples)

    def batches(self, config: TrainingConfig, hops: int, rng: np.random.Generator) -> list[Batch]:
        """One iteration's worth: demonstrations with many queries each, parts with one, and none."""
        drawn = [self._with_lists(config, hops, rng)] if self._lists else []
        if self._scoped:
            some = [int(i) for i in rng.choice(self._scoped, config.scoped)]
            drawn.append(self._batch(config, some, some, np.arange(len(some)), rng))
        rest = [int(i) for i in rng.choice(self._unscoped, config.unscoped)]
        if self._new:
            rest += [int(i) for i in rng.choice(self._new, config.unseen)]
        drawn.append((None, *self._take(config, rest, np.full(len(rest), -1), rng)))
        return drawn

    def _with_lists(self, config: TrainingConfig, hops: int, rng: np.random.Generator) -> Batch:
        """Of programs that are told by a demonstration alone what their lists would say."""
        affordable = max(config.fewest_demonstrations, int(config.pointers / (hops * self._length)))
        shown = rng.choice(len(self._lists), min(config.demonstrations, affordable))
        many = [
            int(rng.choice(self._lists[int(number)]))
            for number in shown
            for _ in range(config.queries_per_demonstration)
        ]
        spec = np.repeat(np.arange(len(shown)), config.queries_per_demonstration)
        first = many[:: config.queries_per_demonstration]
        return self._batch(config, first, many, spec, rng)

    def _frames(self, index: int) -> int:
        """How many frames are read of a demonstration."""
        query = self._samples[index].query
        assert query.scope is not None
        return len(keyframes.within(query.demonstration, query.scope))

    def _batch(
        self,
        config: TrainingConfig,
        parts: list[int],
        queries: list[int],
        spec: np.ndarray,
        rng: np.random.Generator,
    ) -> Batch:
        shown = []
        for index in parts:
            query = self._samples[index].query
            assert query.scope is not None
            shown.append((query.demonstration, query.scope, query.program))
        frames = batches.frames(self.memory, shown, things=self._states.positions.shape[1])
        noise = torch.from_numpy(
            rng.normal(0, config.observation_noise, frames.positions.shape).astype(np.float32)
        )
        noise *= torch.from_numpy(rng.random(len(parts)) < 0.5)[:, None, None, None]
        off = torch.from_numpy(rng.normal(0, config.grasp_offset, (len(parts), 1, 1, 3)).astype(np.float32))
        off *= torch.from_numpy(rng.random(len(parts)) < 0.5)[:, None, None, None]
        typed = torch.from_numpy((rng.random(len(parts)) >= config.untyped).astype(np.float32))
        frames = _replaced(frames, positions=frames.positions + noise + off, typed=typed)
        return frames, *self._take(config, queries, spec, rng)

    def _take(
        self, config: TrainingConfig, indices: list[int], spec: np.ndarray, rng: np.random.Generator
    ) -> tuple[States, Answers]:
        index = torch.tensor(indices)
        states = _select(self._states, index)
        noise = torch.from_numpy(
            rng.normal(0, config.observation_noise, states.positions.shape).astype(np.float32)
        )
        noise *= torch.from_numpy(rng.random(len(indices)) < 0.5)[:, None, None]
        states = _replaced(states, positions=states.positions + noise, spec=torch.from_numpy(spec))
        told = torch.from_numpy(rng.random(len(indices)) < config.teacher_forced)
        return states, _replaced(_select(self._answers, index), told=told)


def _weights(samples: Sequence[Sample]) -> list[float]:
    """One over the root of how often a program makes this call."""
    keys = [(sample.is_new, sample.query.program, sample.answer.callee) for sample in samples]
    counts = Counter(keys)
    mean = float(np.mean([counts[key] ** -0.5 for key in keys]))
    return [counts[key] ** -0.5 / mean for key in keys]


def _select(struct: Struct, index: Tensor) -> Struct:
    values = {f.name: getattr(struct, f.name)[index] for f in fields(struct)}
    return type(struct)(**values)


def _replaced(struct: Struct, **changes: Tensor) -> Struct:
    values = {f.name: getattr(struct, f.name) for f in fields(struct)} | changes
    return type(struct)(**values)
