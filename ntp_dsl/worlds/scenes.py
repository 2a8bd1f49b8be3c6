"""Where things start: scattered over a jittered grid, and names for what a task declares."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

import numpy as np

from ntp_dsl.language.diagnostics import NtpError
from ntp_dsl.language.syntax import TaskDeclaration
from ntp_dsl.registry import Registry
from ntp_dsl.world import Scene, Thing, Vector

CENTRE = (0.5, 0.0)  # of the workspace, before the robot's base [m]
REGION = ((0.3, 0.7), (-0.2, 0.2))  # the authors' square of 0.4 m
JITTER, SPACING = 0.03, 0.08  # the authors' jitter and boundary boxes [m]
COLUMNS = (-0.15, -0.05, 0.05, 0.15)  # of the authors' grid, from its centre [m]
REDRAWS = 20_000  # of the spots, until all are far enough from each other
CUBE = 0.05
TABLE = "table"
FURNITURE = 0.3  # wider things than this never move [m]
TABLE_SIZE = (1.5, 1.5, 0.04)
CARRIES = 0.024  # how far off its support's centre a cube still rests, along each axis [m]


def group_names(task: TaskDeclaration) -> dict[str, list[str]]:
    """Of each group: `blocks: 8 Block` is block_0 … block_7; numbers go on over groups of a type."""
    used: Counter[str] = Counter()
    names: dict[str, list[str]] = {}
    for group in task.scene:
        first = used[group.type.name]
        used[group.type.name] += group.count
        stem = group.type.name.lower()
        names[group.name] = [f"{stem}_{n}" for n in range(first, first + group.count)]
    return names


def declared_things(registry: Registry, task: TaskDeclaration) -> tuple[Thing, ...]:
    """All that a task's scene declares; the table is there in any case.

    Raises `NtpError` for a place that no world can put things on yet.
    """
    for group in task.scene:
        if group.place != TABLE:
            raise NtpError(
                f"{group.span}: '{group.name}' start on '{group.place}'; "
                f"worlds start things on '{TABLE}' only"
            )
    names = group_names(task)
    things = [
        Thing(name, group.type.name, (CUBE, CUBE, CUBE))
        for group in task.scene
        for name in names[group.name]
    ]
    return with_furniture(registry, things)


def with_furniture(registry: Registry, things: Iterable[Thing]) -> tuple[Thing, ...]:
    """The things, and the constants that a primitive may be aimed at."""
    furniture = [
        Thing(name, type_name, TABLE_SIZE)
        for name, type_name in registry.constants.items()
        if registry.is_a(type_name, "Place")
    ]
    return (*things, *furniture)


def movable(things: Iterable[Thing]) -> list[Thing]:
    return [thing for thing in things if thing.size[0] < FURNITURE]


def scattered(things: tuple[Thing, ...], rng: np.random.Generator) -> Scene:
    """Every movable thing in a cell of its own, jittered, none nearer to another than the spacing."""
    items = movable(things)
    cells = [(x, y) for x in COLUMNS for y in COLUMNS]
    for _ in range(REDRAWS):
        chosen = rng.permutation(len(cells))[: len(items)]
        spots = [_jittered(cells[index], rng) for index in chosen]
        if len(spots) == len(items) and _spaced(spots):
            break
    else:
        raise NtpError(
            f"{len(items)} things do not fit on the table; its grid has {len(cells)} cells"
        )
    positions: dict[str, Vector] = furniture_positions(things)
    yaws: dict[str, float] = {}
    for thing, (x, y) in zip(items, spots, strict=True):
        positions[thing.name] = (x, y, thing.size[2] / 2)
        yaws[thing.name] = float(rng.uniform(-np.pi / 4, np.pi / 4))
    return Scene(things, positions, yaws)


def scrambled(
    things: tuple[Thing, ...], rng: np.random.Generator, in_hand: bool = True
) -> Scene:
    """Partial and wrong towers, buried things, now and then a thing in hand and the hand anywhere."""
    scene = scattered(things, rng)
    names = [thing.name for thing in movable(things)]
    positions = dict(scene.positions)
    bases = [names[index] for index in rng.permutation(len(names))]
    tops: list[str] = []
    for name in bases:
        if tops and rng.random() < 0.5:
            below = tops[int(rng.integers(len(tops)))]
            positions[name] = _stacked(positions[below], rng)
            tops[tops.index(below)] = name
        else:
            tops.append(name)
    held = str(rng.choice(tops)) if rng.random() < 0.3 and in_hand else None
    gripper = _somewhere([positions[name] for name in tops if name != held], rng)
    if held is not None:
        positions[held] = gripper
    return Scene(things, positions, scene.yaws, gripper, held)


def _stacked(below: Vector, rng: np.random.Generator) -> Vector:
    """On top; centred, or as far off as just carries: where decisions are closest."""
    dx, dy = rng.normal(0, 0.001, 2) if rng.random() < 0.6 else rng.uniform(-CARRIES, CARRIES, 2)
    return (below[0] + float(dx), below[1] + float(dy), below[2] + CUBE)


def _somewhere(tops: list[Vector], rng: np.random.Generator) -> Vector:
    """Where the hand may be: anywhere, over something, or nearly over it."""
    if not tops or rng.random() < 0.3:
        x, y = rng.uniform((0.3, -0.2), (0.7, 0.2))
        return (float(x), float(y), float(rng.uniform(0.2, 0.4)))
    x, y, z = tops[int(rng.integers(len(tops)))]
    dx, dy = rng.uniform(-CUBE, CUBE, 2) if rng.random() < 0.6 else (0.0, 0.0)
    return (x + float(dx), y + float(dy), z + CUBE / 2 + float(rng.uniform(0.04, 0.12)))


def furniture_positions(things: Iterable[Thing]) -> dict[str, Vector]:
    """A table's top is at height zero."""
    return {
        thing.name: (*CENTRE, -thing.size[2] / 2) for thing in things if thing.size[0] >= FURNITURE
    }


def _jittered(cell: tuple[float, float], rng: np.random.Generator) -> tuple[float, float]:
    dx, dy = rng.uniform(-JITTER, JITTER, 2)
    return CENTRE[0] + cell[0] + float(dx), CENTRE[1] + cell[1] + float(dy)


def _spaced(spots: list[tuple[float, float]]) -> bool:
    points = np.array(spots)
    gaps = np.linalg.norm(points[:, None] - points[None], axis=-1)
    return bool((gaps[np.triu_indices(len(spots), 1)] >= SPACING).all())
