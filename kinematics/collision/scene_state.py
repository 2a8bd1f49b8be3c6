"""The state of a collision scene, arm aside: passed to every check together with joint positions."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from kinematics.geometry.transforms import Pose


@dataclass(frozen=True)
class HeldBody:
    """A body in the hand."""

    name: str
    pose_in_tool: Pose  # in the tool frame


@dataclass(frozen=True)
class SceneState:
    """Poses of bodies, held body and finger opening; the methods derive other states."""

    poses: Mapping[str, Pose]  # of all bodies, world frame
    opening: float  # of each finger, from the middle [m]
    held: HeldBody | None = None
    absent: frozenset[str] = frozenset()  # bodies that are ignored, such as the held one where it was
    tolerated: Mapping[tuple[int, int], float] = field(
        default_factory=dict
    )  # see `CollisionScene.tolerating`

    def with_opening(self, opening: float) -> "SceneState":
        """Return the state with each finger this far from the middle [m]."""
        return replace(self, opening=opening)

    def with_held(self, held: HeldBody, load: Iterable[str] = ()) -> "SceneState":
        """Return the state with a body in the hand; the body and its load become absent."""
        return replace(self, held=held, absent=self.absent | {held.name, *load})

    def without_held(self) -> "SceneState":
        """Return the state with an empty hand; the body that was held stays absent."""
        return replace(self, held=None)

    def without(self, name: str) -> "SceneState":
        """Return the state without a body."""
        return replace(self, absent=self.absent | {name})

    def moved(self, name: str, pose: Pose) -> "SceneState":
        """Return the state with a body at another pose."""
        return replace(self, poses={**self.poses, name: pose})

    def has_bodies_of(self, other: "SceneState") -> bool:
        """Return whether bodies are known to be at the same poses: cheap, since derived states share them."""
        return self.poses is other.poses and self.absent == other.absent
