"""A task specification Ψ: a time series that shows the procedure and the final objective."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import DeclaredFact, Observation, Record, SceneObject
from ntp_dsl.worlds.protocol import World

Scope = tuple[int, int]  # frames [begin, end)
Facts = frozenset[DeclaredFact]


class Specification(Protocol):
    """Whatever a demonstration is made of: trajectories, video frames, a list of sentences."""

    @property
    def modality(self) -> str: ...

    def __len__(self) -> int:
        """Return how many steps it has; scopes are intervals of them."""


class Origin(Struct, frozen=True, omit_defaults=True, kw_only=True):
    """Where a demonstration comes from. Learned programs do not see it."""

    library: str = ""
    task: str = ""
    seed: int | None = None
    goal: tuple[Record, ...] = ()  # empty where it is unknown


UNKNOWN = Origin()


@dataclass(frozen=True, eq=False)
class Demonstration:
    """Trajectories of objects, and the gripper: T frames of N objects.

    Two demonstrations are the same only if they are one.
    """

    objects: tuple[SceneObject, ...]
    times: NDArray[np.float32]  # (T,) [s]
    closed: NDArray[np.bool_]  # (T,)
    grippers: NDArray[np.float64]  # (T, 3): the point between the fingertips, world frame [m]
    positions: NDArray[np.float64]  # (T, N, 3): centres, world frame [m]
    orientations: NDArray[np.float32] | None = None  # (T, N, 4): object to world, xyzw; None where unknown
    deviations: NDArray[np.float32] | None = None  # (T, N): of the positions, standard [m]; None for 0
    facts: tuple[Facts, ...] | None = None  # T; None where there are none
    origin: Origin = UNKNOWN

    modality = "trajectory"

    def __len__(self) -> int:
        return len(self.times)

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the objects."""
        return tuple(obj.name for obj in self.objects)

    @cached_property
    def relative(self) -> NDArray[np.float32]:
        """Return the centres minus the gripper's point, (T, N, 3) [m]: what a learned program sees."""
        return (self.positions - self.grippers[:, None]).astype(np.float32)


def check_objects(demonstration: Demonstration, objects: Sequence[SceneObject]) -> None:
    """Raise `NtpError` unless a demonstration has exactly the objects of a scene."""
    demonstrated = {(obj.name, obj.type) for obj in demonstration.objects}
    expected = {(obj.name, obj.type) for obj in objects}
    for verb, difference in (("lacks", expected - demonstrated), ("also shows", demonstrated - expected)):
        if difference:
            listed = ", ".join(sorted(f"{name} ({type_name})" for name, type_name in difference))
            raise NtpError(
                f"the demonstration {verb} {listed}; the scene has "
                f"{', '.join(sorted(name for name, _ in expected))}"
            )


def noisy(demonstration: Demonstration, sigma: float, rng: np.random.Generator) -> Demonstration:
    """Return the demonstration as a camera of that standard deviation sees it [m]."""
    shape = demonstration.positions.shape
    return replace(
        demonstration,
        positions=demonstration.positions + rng.normal(0, sigma, shape),
        deviations=np.full(shape[:2], sigma, dtype=np.float32),
    )


class Recorder:
    """Collects frames of a world into a demonstration; attach it as the world's `on_frame`."""

    def __init__(self, world: World, also: Callable[[Observation], None] | None = None) -> None:
        self._world, self._also = world, also
        self._frames: list[tuple[float, Observation]] = []
        world.on_frame = self.take

    def take(self, observation: Observation) -> None:
        """Add a frame."""
        self._frames.append((self._world.time, observation))
        if self._also is not None:
            self._also(observation)

    def __len__(self) -> int:
        return len(self._frames)

    def demonstration(self, origin: Origin = UNKNOWN) -> Demonstration:
        """Return all frames so far. A lost object cannot be shown, so each frame has all of them."""
        seen = [observation for _, observation in self._frames]
        objects = seen[0].objects
        names = [obj.name for obj in objects]
        return Demonstration(
            objects,
            np.array([time for time, _ in self._frames], dtype=np.float32),
            np.array([each.closed for each in seen]),
            np.array([each.gripper for each in seen]),
            np.array([[each.positions[name] for name in names] for each in seen]),
            _orientations(seen, names),
            _deviations(seen, names),
            tuple(each.facts for each in seen) if any(each.facts for each in seen) else None,
            origin,
        )


def _orientations(seen: list[Observation], names: list[str]) -> NDArray[np.float32] | None:
    if not any(each.orientations for each in seen):
        return None
    return np.array([[each.orientation(name) for name in names] for each in seen], dtype=np.float32)


def _deviations(seen: list[Observation], names: list[str]) -> NDArray[np.float32] | None:
    if not any(each.deviations for each in seen):
        return None
    return np.array([[each.deviations.get(name, 0.0) for name in names] for each in seen], dtype=np.float32)
