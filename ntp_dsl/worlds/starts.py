"""Where objects start: nominal starts, all apart, and perturbed ones, as an arm may find them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import hypot

import numpy as np

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.containers import floor_in, takes, top_for
from ntp_dsl.semantics.free_space import Footprint, Interval, clearance, region_within
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import TOO_WIDE, SceneObject
from ntp_dsl.worlds.protocol import Scene
from ntp_dsl.worlds.scenes import CUBE, TABLE, Start, movable

CENTRE = (0.5, 0.0)  # of the workspace, before the robot's base [m]
REGION = ((0.3, 0.7), (-0.2, 0.2))  # the authors' square of 0.4 m
WIDE = ((0.3, 0.7), (-0.3, 0.3))  # where trays and pads may stand as well
ASIDE = ((0.5, 0.34), (0.5, -0.34), (0.32, 0.36), (0.32, -0.36))  # of constants that are trays
JITTER, SPACING = 0.03, 0.08  # the authors' jitter and boundary boxes [m]
COLUMNS = (-0.15, -0.05, 0.05, 0.15)  # of the authors' grid, from its centre [m]
REDRAWS = 20_000  # of all spots, until they are far enough apart
GAP = 0.03  # between objects of other sizes [m]
TIGHT = 0.007  # between objects on a grid, at least [m]
CROWDED = 0.4  # covered share of a region's free part above which objects start on a grid
MOST_CELLS = 4  # of a grid, for each object
TRIES, RESTARTS = 400, 60  # for each object, and for all of them
STRAIGHT = 0.6  # of stacked objects that are centred on their support
TOPPLES = 1.6  # times its support's width: such an object is not put on top
CARRIES = 0.024  # how far off its support's centre a cube still rests, along each axis [m]

Spot = tuple[float, float]


def nominal_start(
    objects: tuple[SceneObject, ...], rng: np.random.Generator, starts: Mapping[str, Start] | None = None
) -> Scene:
    """Return a scene with all objects apart, at random yaws, stacked only where the task says so."""
    standing = [obj for obj in objects if obj.size[0] <= TOO_WIDE]
    starts = starts or {}
    items = sorted(standing, key=lambda obj: _height(obj.name, starts))
    plain = all(start == Start() for start in starts.values()) and all(
        obj.movable and obj.size == (CUBE, CUBE, CUBE) for obj in items
    )
    spots = _on_grid(items, rng) if plain else _spread(items, starts, rng)
    positions: dict[str, Vector] = furniture_positions(objects)
    by_name = {obj.name: obj for obj in objects}
    yaws: dict[str, float] = {}
    for obj in items:
        x, y = spots[obj.name]
        surface = starts.get(obj.name, Start()).surface
        floor = 0.0
        if surface in spots:
            floor = positions[surface][2] + _floor(by_name[surface], obj)
        positions[obj.name] = (x, y, floor + obj.size[2] / 2)
        yaws[obj.name] = float(rng.uniform(-np.pi / 4, np.pi / 4)) if obj.movable else 0.0
    return Scene(objects, positions, yaws)


def _height(name: str, starts: Mapping[str, Start]) -> int:
    """Return the number of objects below one: supports are placed first."""
    count = 0
    while (name := starts.get(name, Start()).surface) in starts and count < len(starts):
        count += 1
    return count + (name != TABLE)


def _on_grid(items: Sequence[SceneObject], rng: np.random.Generator) -> dict[str, Spot]:
    """Place cubes as the authors do: each in its own cell, jittered, none nearer than the spacing."""
    cells = [(x, y) for x in COLUMNS for y in COLUMNS]
    for _ in range(REDRAWS):
        chosen = rng.permutation(len(cells))[: len(items)]
        spots = [_jittered(cells[index], rng) for index in chosen]
        if len(spots) == len(items) and _spaced(spots):
            return {obj.name: spot for obj, spot in zip(items, spots, strict=True)}
    raise NtpError(f"{len(items)} objects do not fit on the table; its grid has {len(cells)} cells")


def _spread(
    items: Sequence[SceneObject], starts: Mapping[str, Start], rng: np.random.Generator
) -> dict[str, Spot]:
    """Place objects of any size: the largest first, each at a free point of its region."""
    by_name = {obj.name: obj for obj in items}
    given = _aside(items, starts)
    order = sorted(items, key=lambda t: (t.movable, -max(t.size[:2])))
    fixed = sum(not obj.movable for obj in order)
    for _ in range(RESTARTS):
        spots: dict[str, Spot] = dict(given)
        for index, obj in enumerate(order):
            if index == fixed:  # all fixed objects have their places
                in_place = [(spots[name], by_name[name].size) for name in spots]
                spots |= _crowded(order[fixed:], starts, in_place, rng)
            start = starts.get(obj.name, Start())
            if start.surface in by_name or obj.name in spots:
                continue
            spot = _free_spot(obj, start, spots, by_name, starts, rng)
            if spot is None:
                break
            spots[obj.name] = spot
        else:
            stacked = _stacked_starts(items, starts, spots, by_name, rng)
            if stacked is not None:
                return spots | stacked
    sizes = ", ".join(f"{obj.name} ({obj.size[0]:g} x {obj.size[1]:g} m)" for obj in order[:4])
    raise NtpError(
        f"{len(items)} objects do not fit where they are to start, among them {sizes}; "
        "take fewer or smaller ones, or wider regions: x(0.3 .. 0.7 m), y(-0.3 .. 0.3 m)"
    )


def _aside(items: Sequence[SceneObject], starts: Mapping[str, Start]) -> dict[str, Spot]:
    """Place trays that the scene does not mention, clear of objects with exact positions."""
    taken: list[Footprint] = []
    for obj in items:
        start = starts.get(obj.name, Start())
        if start.surface == TABLE and start.x and start.y and start.x[0] == start.x[1]:
            taken.append(((start.x[0], start.y[0]), obj.size))
    found: dict[str, Spot] = {}
    for tray in (t for t in items if t.fixed and t.name not in starts and t.roomy):
        free = [spot for spot in ASIDE if clearance(spot, tray.size, taken) > GAP]
        found[tray.name] = free[0] if free else ASIDE[-1]
        taken.append((found[tray.name], tray.size))
    return found


def _crowded(
    items: Sequence[SceneObject],
    starts: Mapping[str, Start],
    taken: Sequence[Footprint],
    rng: np.random.Generator,
) -> dict[str, Spot]:
    """Place objects, too many to find room by chance, in the free cells of a jittered grid."""
    shared: dict[Start, list[SceneObject]] = {}
    for obj in items:
        start = starts.get(obj.name, Start())
        if start.surface == TABLE:
            shared.setdefault(Start(x=start.x, y=start.y), []).append(obj)
    in_place = list(taken)
    cells: dict[str, Spot] = {}
    for start, objects in shared.items():
        region = start.x or REGION[0], start.y or REGION[1]
        (x0, x1), (y0, y1) = region
        if x0 == x1 or y0 == y1:
            continue  # their start is exact
        width = max(max(obj.size[:2]) for obj in objects)
        covered = sum(_covered(region, spot, size) for spot, size in in_place)
        if len(objects) * (width + GAP) ** 2 < CROWDED * ((x1 - x0) * (y1 - y0) - covered):
            continue
        found = _free_cells(len(objects), width, region, in_place)
        if found is None:
            continue
        free, pitch = found
        jitter = max(0.0, min(0.01, (pitch - width) / 2 - TIGHT))
        for obj, cell in zip(objects, rng.permutation(len(free)), strict=False):
            dx, dy = rng.uniform(-jitter, jitter, 2)
            cells[obj.name] = (free[cell][0] + float(dx), free[cell][1] + float(dy))
            in_place.append((cells[obj.name], obj.size))
    return cells


def _free_cells(
    count: int, width: float, region: tuple[Interval, Interval], in_place: Sequence[Footprint]
) -> tuple[list[Spot], float] | None:
    """Return the free cells of the widest grid with at least that many, and their pitch; None without one."""
    (x0, x1), (y0, y1) = region
    for wanted in range(count, MOST_CELLS * count + 1):
        columns, rows = _grid(wanted, x1 - x0, y1 - y0)
        pitch = min((x1 - x0) / columns, (y1 - y0) / rows)
        if pitch < width + TIGHT:
            return None
        middles = [
            (x0 + (column + 0.5) * (x1 - x0) / columns, y0 + (row + 0.5) * (y1 - y0) / rows)
            for column in range(columns)
            for row in range(rows)
        ]
        clear = clearance(middles, (pitch, pitch), in_place) >= 0
        free = [middle for middle, is_clear in zip(middles, clear, strict=True) if is_clear]
        if len(free) >= count:
            return free, pitch
    return None


def _covered(region: tuple[Interval, Interval], spot: Sequence[float], size: Sequence[float]) -> float:
    """Return the area of a region that an object's footprint covers [m2]."""
    sides = [
        min(region[axis][1], spot[axis] + size[axis] / 2) - max(region[axis][0], spot[axis] - size[axis] / 2)
        for axis in (0, 1)
    ]
    return max(0.0, sides[0]) * max(0.0, sides[1])


def _grid(count: int, length: float, width: float) -> tuple[int, int]:
    """Return columns and rows of at least that many cells, as square as the region allows."""
    columns = max(1, round((count * length / width) ** 0.5))
    return columns, -(-count // columns)


def _free_spot(
    obj: SceneObject,
    start: Start,
    spots: Mapping[str, Spot],
    by_name: Mapping[str, SceneObject],
    starts: Mapping[str, Start],
    rng: np.random.Generator,
) -> Spot | None:
    default = REGION if obj.movable else WIDE
    (x0, x1), (y0, y1) = start.x or default[0], start.y or default[1]
    others = [(spots[name], by_name[name].size) for name in spots]
    spacings = {name: max(start.spacing or 0.0, starts.get(name, Start()).spacing or 0.0) for name in spots}
    for _ in range(TRIES):
        x, y = float(rng.uniform(x0, x1)), float(rng.uniform(y0, y1))
        spaced = all(hypot(x - spots[name][0], y - spots[name][1]) >= spacings[name] for name in spots)
        if spaced and clearance((x, y), obj.size, others) > GAP:
            return x, y
    return None


def _stacked_starts(
    items: Sequence[SceneObject],
    starts: Mapping[str, Start],
    spots: Mapping[str, Spot],
    by_name: Mapping[str, SceneObject],
    rng: np.random.Generator,
) -> dict[str, Spot] | None:
    """Place objects that start on others: centred, or at a free point of a tray; None without room."""
    found: dict[str, Spot] = {}
    for obj in items:
        start = starts.get(obj.name, Start())
        if start.surface not in by_name or start.surface == TABLE:
            continue
        below = by_name[start.surface]
        x, y = {**spots, **found}[start.surface]
        if below.roomy:
            region = Start(start.surface, *region_within(below, (x, y), obj.size), start.spacing)
            there = {name: spot for name, spot in found.items() if starts[name].surface == start.surface}
            spot = _free_spot(obj, region, there, by_name, starts, rng)
            if spot is None:
                return None
            x, y = spot
        found[obj.name] = (x, y)
    return found


def perturbed_start(
    objects: tuple[SceneObject, ...],
    rng: np.random.Generator,
    in_hand: bool = True,
    starts: Mapping[str, Start] | None = None,
    straight: float = STRAIGHT,
) -> Scene:
    """Return a scene with partial and wrong towers, buried objects and, at random, an object in the hand.

    Args:
        straight: how often objects are centred on their support, as an undisturbed arm leaves them.
    """
    scene = nominal_start(objects, rng, starts)
    into: dict[str, tuple[str, Vector]] = {}  # bowl of each item inside one, and its offset there
    names = [obj.name for obj in movable(objects)]
    positions = dict(scene.positions)
    bases = [names[index] for index in rng.permutation(len(names))]
    tops: list[str] = [t.name for t in objects if t.fixed]  # fixed objects may carry something from the start
    for name in bases:
        if tops and rng.random() < 0.5:
            item, below = scene.by_name[name], scene.by_name[tops[int(rng.integers(len(tops)))]]
            place = _stacked(item, below, positions, rng, straight)
            if item.size[0] > TOPPLES * below.size[0]:
                tops.append(name)
            elif takes(below, item):
                positions[name] = place  # in the bowl, which others may still be put on
                into[name] = below.name, _moved(place, positions[below.name], -1)
            elif below.roomy or item.size[0] > below.size[0]:  # it needs room beside what is below
                tops.append(name)
                if _is_free(item, place, scene, positions):
                    positions[name] = place
            else:
                positions[name] = place
                tops[tops.index(below.name)] = name
        else:
            tops.append(name)
    carried = [name for name in tops if name in names]
    held = str(rng.choice(carried)) if rng.random() < 0.3 and in_hand and carried else None
    gripper = _somewhere([positions[name] for name in carried if name != held], rng)
    if held is not None:
        positions[held] = in_hand_at(scene.by_name[held], gripper)
    for name, (container, offset) in into.items():
        if name != held:
            positions[name] = _moved(positions[container], offset)
    return Scene(objects, positions, scene.yaws, gripper, held)


def _moved(place: Vector, by: Vector, times: float = 1) -> Vector:
    return place[0] + times * by[0], place[1] + times * by[1], place[2] + times * by[2]


def _stacked(
    item: SceneObject,
    below: SceneObject,
    positions: Mapping[str, Vector],
    rng: np.random.Generator,
    straight: float,
) -> Vector:
    """Return a place on top: centred, or as far off as is just stable, where decisions are hardest."""
    x, y, z = positions[below.name]
    height = z + _floor(below, item) + item.size[2] / 2
    if below.cavity is not None and takes(below, item):
        dx, dy = (float(rng.uniform(-half, half)) / 2 for half in below.cavity[:2])
        return (x + dx, y + dy, height)
    reach = CARRIES if below.size[:2] == (CUBE, CUBE) else min(below.size[:2]) / 2 - 0.001
    centred = rng.random() < (min(straight, STRAIGHT) if below.roomy else straight)
    dx, dy = rng.normal(0, 0.001, 2) if centred else rng.uniform(-reach, reach, 2)
    return (x + float(dx), y + float(dy), height)


def _floor(below: SceneObject, item: SceneObject) -> float:
    """Return the height of an item's bottom on or in an object, from that one's centre [m]."""
    if takes(below, item):
        return floor_in(below)
    return top_for(below, item)


def in_hand_at(obj: SceneObject, gripper: Vector) -> Vector:
    """Return where a held object is: between the fingers, or a bowl by its wall."""
    x, y, z = gripper
    return (x + obj.size[0] / 2, y, z) if obj.cavity is not None else gripper


def _is_free(item: SceneObject, place: Vector, scene: Scene, positions: Mapping[str, Vector]) -> bool:
    """Return whether no object of the same height range is there."""
    bottom = place[2] - item.size[2] / 2
    others = [
        (positions[other.name], other.size)
        for other in movable(scene.objects)
        if other.name != item.name
        and abs(positions[other.name][2] - other.size[2] / 2 - bottom) < min(item.size[2], other.size[2])
    ]
    return bool(clearance(place[:2], item.size, others) > GAP)


def _somewhere(tops: list[Vector], rng: np.random.Generator) -> Vector:
    """Return a place for the hand: anywhere, over an object, or nearly over it."""
    if not tops or rng.random() < 0.3:
        x, y = rng.uniform((0.3, -0.2), (0.7, 0.2))
        return (float(x), float(y), float(rng.uniform(0.2, 0.4)))
    x, y, z = tops[int(rng.integers(len(tops)))]
    dx, dy = rng.uniform(-CUBE, CUBE, 2) if rng.random() < 0.6 else (0.0, 0.0)
    return (x + float(dx), y + float(dy), z + CUBE / 2 + float(rng.uniform(0.04, 0.12)))


def furniture_positions(objects: Iterable[SceneObject]) -> dict[str, Vector]:
    """Return the positions of tables, whose tops are at height zero."""
    return {obj.name: (*CENTRE, -obj.size[2] / 2) for obj in objects if obj.size[0] > TOO_WIDE}


def _jittered(cell: Spot, rng: np.random.Generator) -> Spot:
    dx, dy = rng.uniform(-JITTER, JITTER, 2)
    return CENTRE[0] + cell[0] + float(dx), CENTRE[1] + cell[1] + float(dy)


def _spaced(spots: list[Spot]) -> bool:
    points = np.array(spots)
    gaps = np.linalg.norm(points[:, None] - points[None], axis=-1)
    return bool((gaps[np.triu_indices(len(spots), 1)] >= SPACING).all())
