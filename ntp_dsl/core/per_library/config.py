"""Every size of the core and every parameter of its training, each in one place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from msgspec import Meta

Width = Annotated[int, Meta(ge=2, le=4096)]
Layers = Annotated[int, Meta(ge=0, le=64)]


@dataclass(frozen=True)
class CoreConfig:
    """The sizes of a core; the bounds hold for those that a file states."""

    width: Width = 64  # of hidden layers
    type_width: Width = 8  # of a type's embedding
    row_width: Width = 24  # of a program's embedding
    hops: Layers = 2  # pointers that each frame of a demonstration throws, one from the other, at least
    rounds: Layers = 2  # of messages between things of the present state
    kernel: Layers = 5  # of the temporal convolutions, odd [frames]

    def __post_init__(self) -> None:
        if self.kernel % 2 == 0:
            raise ValueError(f"expected an odd kernel, found {self.kernel}")

    def pointers(self, arity: int) -> int:
        """How many hops there are, where a call takes so many objects: each can be pointed at."""
        return max(self.hops, arity)


@dataclass(frozen=True)
class TrainingConfig:
    seed: int = 0
    iterations: int = 1500
    learning_rate: float = 2e-3
    warm_up: int = 50  # iterations
    weight_decay: float = 1e-4
    clip: float = 1.0  # gradient norm
    demonstrations: int = 8  # shown whole in an iteration
    pointers: int = 2000  # that the frames of these throw together; were there more, fewer are shown,
    fewest_demonstrations: int = 4  # but not fewer than this
    queries_per_demonstration: int = 12
    scoped: int = 24  # queries of programs with a part of a demonstration, in an iteration
    unscoped: int = 56  # queries without one, of states that episodes went through
    unseen: int = 56  # and of others
    teacher_forced: float = (
        0.5  # of the decisions, which are learnt from the true start of the callee's scope
    )
    untyped: float = 0.3  # of the parts of demonstrations, whose events are to be seen without types
    grasp_offset: float = (
        0.006  # by which the hand is off objects' centres, in half of the demonstrations [m]
    )
    observation_noise: float = 0.002  # added in half of the queries [m]
