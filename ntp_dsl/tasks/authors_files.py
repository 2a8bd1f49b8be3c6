"""The task files of the paper's authors, as far as this project reads them: see `read_tasks`."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, Struct

from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import SceneObject

AUTHORS_SCENE = "stacking"  # what the authors call the scene of their block-stacking tasks
TYPES = {"cubes": "Block"}  # a model's folder -> its type in the standard library
Model = Annotated[str, Meta(pattern="^cubes/", description="of a model whose type is known")]


class AuthorsObject(Struct, frozen=True):
    """An object of the scene, with its extents [m]."""

    name: str
    filename: Model
    scale: Vector


class AuthorsScene(Struct, frozen=True):
    """The scene that all tasks of a file share."""

    objects: Annotated[tuple[AuthorsObject, ...], Meta(min_length=1)]

    def as_ours(self) -> tuple[SceneObject, ...]:
        """Return the objects as ours."""
        return tuple(
            SceneObject(each.name, TYPES[each.filename.split("/")[0]], each.scale) for each in self.objects
        )


class AuthorsPlacement(Struct, frozen=True):
    """An item, and what it goes on."""

    name: Literal["pick_place"]
    src: str
    target: str


class AuthorsTask(Struct, frozen=True):
    """A goal, in the order of its demonstration."""

    id: str
    goals: Annotated[tuple[AuthorsPlacement, ...], Meta(min_length=1)]

    def goal(self) -> tuple[dict[str, str | float], ...]:
        """Return the goal as rows of ours."""
        return tuple({"item": each.src, "support": each.target} for each in self.goals)


class AuthorsFile(Struct, frozen=True):
    """A whole file."""

    name: str
    scene: AuthorsScene
    tasks: Annotated[tuple[AuthorsTask, ...], Meta(min_length=1)]
