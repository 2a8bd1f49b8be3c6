"""Nominal starts: all objects apart, stacked only where the task says so."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from math import cos, hypot, pi, remainder, sin

import numpy as np

from ntp_dsl.semantics.containers import takes
from ntp_dsl.semantics.free_space import Footprint, Region, clearance, region_within
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import TOO_WIDE, SceneObject
from ntp_dsl.worlds.grids import COLUMNS, TIGHT, Spot, covered_area, free_cells, in_cells, spots_on_grid
from ntp_dsl.worlds.protocol import Scene
from ntp_dsl.worlds.scenes import CUBE, TABLE, NoRoom, Start
from ntp_dsl.worlds.standing import Standing, nests_badly, turned_where_free

CENTRE = (0.5, 0.0)  # of the workspace, before the robot's base [m]
REGION = ((0.3, 0.7), (-0.2, 0.2))  # the authors' square of 0.4 m
WIDE = ((0.3, 0.7), (-0.3, 0.3))  # where trays and pads may stand as well
ASIDE = ((0.5, 0.34), (0.5, -0.34), (0.32, 0.36), (0.32, -0.36))  # of constants that are trays
GAP = 0.03  # between objects of other sizes [m]
CROWDED = 0.4  # covered share of a region's free part above which objects start on a grid
TRIES, RESTARTS = 400, 60  # for each object, and for all of them
LISTED = 4  # names in a message, at most

Sizes = Mapping[str, tuple[float, float]]  # along x and y, by object [m]
NOWHERE = Start()  # in particular


def nominal_start(
    objects: tuple[SceneObject, ...], rng: np.random.Generator, starts: Mapping[str, Start] | None = None
) -> Scene:
    """Return a scene with all objects apart, at random yaws, stacked only where the task says so.

    Raises `NoRoom` where the objects of a group have no room for all of them.
    """
    starts = starts or {}
    turned = turned_ones(starts)
    told = {obj.name: _yaw(obj, starts[obj.name], rng) for obj in objects if obj.name in turned}
    lying = Scene(objects, {}, told).lying
    items = sorted(
        (lying[obj.name] for obj in objects if obj.size[0] <= TOO_WIDE),
        key=lambda obj: height_of(obj.name, starts),
    )
    _check_shared_places(items, starts)
    plain = all(start == NOWHERE for start in starts.values()) and all(
        obj.movable and obj.size == (CUBE, CUBE, CUBE) for obj in items
    )
    spots = _on_grid(items, starts, rng) if plain and items else _spread(items, starts, told, rng)
    standing = _stacked(items, starts, spots)
    yaws = {obj.name: float(rng.uniform(-np.pi / 4, np.pi / 4)) if obj.movable else 0.0 for obj in items}
    scene = Scene(objects, furniture_positions(objects) | standing.positions, yaws | told)
    return turned_where_free(scene, turned)


def turned_ones(starts: Mapping[str, Start]) -> set[str]:
    """Return the names of the objects of which it is declared how they are turned."""
    return {name for name, start in starts.items() if start.yaw is not None}


def _yaw(obj: SceneObject, start: Start, rng: np.random.Generator) -> float:
    if obj.roomy or obj.cavity is not None:
        kind = obj.shape if obj.cavity is not None else "tray, as both its sides are wider than 12 cm"
        help = (
            ""
            if obj.cavity is not None
            else "; what is narrower may be turned, with parts of its own by offset(...)"
        )
        raise NoRoom(f"{obj.name} is a {kind}, and those are never turned{help}", start.group)
    assert start.yaw is not None
    return float(rng.uniform(*start.yaw))


def height_of(name: str, starts: Mapping[str, Start]) -> int:
    """Return the number of objects below one: supports are placed first."""
    count = 0
    while (name := starts.get(name, NOWHERE).surface) in starts and count < len(starts):
        count += 1
    return count + (name != TABLE)


def shares(below: SceneObject, item: SceneObject) -> bool:
    """Return whether an object has room for several such items: in it, or beside each other on it."""
    return below.roomy or takes(below, item)


def _stacked(
    items: Sequence[SceneObject], starts: Mapping[str, Start], spots: Mapping[str, Spot]
) -> Standing:
    """Return all objects at their spots, each on the table or on its support."""
    standing = Standing({obj.name: obj for obj in items}, {})
    for obj in items:
        surface = starts.get(obj.name, NOWHERE).surface
        standing.positions[obj.name] = (
            standing.on(surface, obj.name, *spots[obj.name])
            if surface in spots
            else (*spots[obj.name], obj.size[2] / 2)
        )
    return standing


def _check_shared_places(items: Sequence[SceneObject], starts: Mapping[str, Start]) -> None:
    """Raise `NoRoom` where two objects start on one that has room for one, or a bowl in a wider container."""
    by_name = {obj.name: obj for obj in items}
    on: dict[str, str] = {}
    for obj in items:
        start = starts.get(obj.name, NOWHERE)
        below = by_name.get(start.surface)
        if below is not None and nests_badly(below, obj):
            raise NoRoom(f"{obj.name} would sink into {below.name}; start it on the table", start.group)
        if below is None or shares(below, obj) or start.offset is not None:
            continue
        if below.name in on:
            raise NoRoom(
                f"{on[below.name]} and {obj.name} of '{start.group}' both start on {below.name}, which has "
                f"room for one; declare fewer, more places, or larger ones (trays: above 12 cm both ways)",
                start.group,
            )
        on[below.name] = obj.name


def _on_grid(
    items: Sequence[SceneObject], starts: Mapping[str, Start], rng: np.random.Generator
) -> dict[str, Spot]:
    """Place plain cubes on the authors' grid."""
    spots = spots_on_grid(len(items), CENTRE, rng)
    if spots is None:
        message = f"{len(items)} objects do not fit on the table; its grid has {len(COLUMNS) ** 2} cells"
        raise NoRoom(message, _largest_group(items, starts))
    return {obj.name: spot for obj, spot in zip(items, spots, strict=True)}


def _largest_group(items: Iterable[SceneObject], starts: Mapping[str, Start]) -> str:
    counted = Counter(starts[obj.name].group for obj in items if obj.name in starts)
    return counted.most_common(1)[0][0] if counted else ""


def _spread(
    items: Sequence[SceneObject],
    starts: Mapping[str, Start],
    yaws: Mapping[str, float],
    rng: np.random.Generator,
) -> dict[str, Spot]:
    """Place objects of any size: those with exact places, then the largest, each at a free point.

    Args:
        yaws: of objects of which they are declared [rad].
    """
    by_name = {obj.name: obj for obj in items}
    sizes = _with_loads(items, starts)
    given = _aside(items, starts)
    order = sorted(items, key=lambda t: (not starts.get(t.name, NOWHERE).exact, t.movable, -max(t.size[:2])))
    exact = sum(starts.get(obj.name, NOWHERE).exact for obj in order)
    settled = exact + sum(not obj.movable for obj in order[exact:])
    failed: Counter[str] = Counter()
    for _ in range(RESTARTS):
        spots: dict[str, Spot] = dict(given)
        for index, obj in enumerate(order):
            if index == settled:  # all fixed objects have their places
                in_place = [(spots[name], sizes[name]) for name in spots]
                spots |= _crowded(order[settled:], starts, sizes, in_place, rng)
            start = starts.get(obj.name, NOWHERE)
            if start.surface in by_name or obj.name in spots:
                continue
            if start.exact:
                spots[obj.name] = _exact_spot(obj, starts, spots, by_name, rng)
                continue
            spot = _free_spot(sizes[obj.name], _region(obj, start), start.spacing, spots, sizes, starts, rng)
            if spot is None:
                failed[obj.name] += 1
                break
            spots[obj.name] = spot
        else:
            stuck = _stack_up(items, starts, spots, by_name, yaws, rng)
            if stuck is None:
                return spots
            failed[stuck] += 1
    raise _no_room(by_name[failed.most_common(1)[0][0]], by_name, starts)


def _no_room(obj: SceneObject, by_name: Mapping[str, SceneObject], starts: Mapping[str, Start]) -> NoRoom:
    start = starts.get(obj.name, NOWHERE)
    alike = [name for name in by_name if name in starts and starts[name].group == start.group] or [obj.name]
    names = ", ".join(alike[:LISTED]) + (", ..." if len(alike) > LISTED else "")
    if start.surface in by_name:
        message = f"{names} do not fit on {start.surface}, where {obj.name} ({_in_cm(obj.size)}) is to start"
        return NoRoom(f"{message}; declare fewer or smaller ones, or larger places", start.group)
    message = f"{names} do not fit where they are to start, among them {obj.name} ({_in_cm(obj.size)})"
    return NoRoom(
        f"{message}; declare fewer or smaller ones, or wider regions: x(0.3 .. 0.7 m), y(-0.3 .. 0.3 m)",
        start.group,
    )


def _in_cm(lengths: Sequence[float]) -> str:
    return f"{100 * lengths[0]:g} x {100 * lengths[1]:g} cm"


def _with_loads(items: Sequence[SceneObject], starts: Mapping[str, Start]) -> Sizes:
    """Return each object's extents seen from above, with those of the objects that start centred on it."""
    by_name = {obj.name: obj for obj in items}
    sizes = {obj.name: _seen_from_above(obj, starts.get(obj.name, NOWHERE)) for obj in items}
    for obj in reversed(items):  # the highest first
        surface = starts.get(obj.name, NOWHERE).surface
        if surface in by_name and not shares(by_name[surface], obj):
            (x, y), (its_x, its_y) = sizes[surface], sizes[obj.name]
            dx, dy = starts[obj.name].offset or (0.0, 0.0)
            if starts.get(surface, NOWHERE).yaw is not None:
                dx = dy = hypot(dx, dy)
            sizes[surface] = max(x, its_x + 2 * abs(dx)), max(y, its_y + 2 * abs(dy))
    return sizes


def _seen_from_above(obj: SceneObject, start: Start) -> tuple[float, float]:
    """Return the extents along x and y of an object as it lies, with what it is turned beyond that [m]."""
    length, width = obj.size[:2]
    if start.yaw is None:
        return length, width
    low, high = start.yaw
    if low != high:
        return (hypot(length, width),) * 2
    beyond = remainder(low, pi / 2)  # what it is turned beyond quarter turns, by which it lies already
    across, along = abs(sin(beyond)), abs(cos(beyond))
    return along * length + across * width, across * length + along * width


def _region(obj: SceneObject, start: Start) -> Region:
    default = REGION if obj.movable else WIDE
    return start.x or default[0], start.y or default[1]


def _exact_spot(
    obj: SceneObject,
    starts: Mapping[str, Start],
    spots: Mapping[str, Spot],
    by_name: Mapping[str, SceneObject],
    rng: np.random.Generator,
) -> Spot:
    """Return where an object is told to stand: as close to others as that may be, but not in them."""
    start = starts[obj.name]
    (x0, x1), (y0, y1) = _region(obj, start)
    spot = float(rng.uniform(x0, x1)), float(rng.uniform(y0, y1))
    for name, other in spots.items():
        if clearance(spot, obj.size, [(other, by_name[name].size)]) < -1e-9:
            told = ((by_name[name], other), (obj, spot))
            places = " and ".join(
                f"{each.name} ({_in_cm(each.size)}) at x {100 * at[0]:g} cm, y {100 * at[1]:g} cm"
                for each, at in told
            )
            raise NoRoom(f"two objects are to start inside each other: {places}", start.group)
    return spot


def _aside(items: Sequence[SceneObject], starts: Mapping[str, Start]) -> dict[str, Spot]:
    """Place trays that the scene does not mention, clear of objects with exact positions."""
    taken: list[Footprint] = []
    for obj in items:
        start = starts.get(obj.name, NOWHERE)
        if start.exact and start.x and start.y:
            taken.append(((start.x[0], start.y[0]), obj.size))
    found: dict[str, Spot] = {}
    for tray in (t for t in items if t.fixed and t.name not in starts and t.roomy):
        free = [spot for spot in ASIDE if clearance(spot, tray.size, taken) > TIGHT]
        if not free:
            raise NoRoom(
                f"the tray '{tray.name}' has no room beside the others; declare it as a group of the scene"
            )
        found[tray.name] = free[0]
        taken.append((found[tray.name], tray.size))
    return found


def _crowded(
    items: Sequence[SceneObject],
    starts: Mapping[str, Start],
    sizes: Sizes,
    taken: Sequence[Footprint],
    rng: np.random.Generator,
) -> dict[str, Spot]:
    """Place objects, too many to find room by chance, in the free cells of a jittered grid."""
    shared: dict[Start, list[SceneObject]] = {}
    for obj in items:
        start = starts.get(obj.name, NOWHERE)
        if start.surface == TABLE:
            shared.setdefault(Start(x=start.x, y=start.y), []).append(obj)
    in_place = list(taken)
    cells: dict[str, Spot] = {}
    for start, objects in shared.items():
        region = _region(objects[0], start)
        (x0, x1), (y0, y1) = region
        if x0 == x1 or y0 == y1:
            continue  # their start is exact
        width = max(max(sizes[obj.name]) for obj in objects)
        covered = sum(covered_area(region, spot, size) for spot, size in in_place)
        if len(objects) * (width + GAP) ** 2 < CROWDED * ((x1 - x0) * (y1 - y0) - covered):
            continue
        found = free_cells(len(objects), width, region, in_place)
        if found is None:
            continue
        free, pitch = found
        for obj, cell in zip(objects, in_cells(free, pitch, width, rng), strict=False):
            cells[obj.name] = cell
            in_place.append((cells[obj.name], sizes[obj.name]))
    return cells


def _free_spot(
    size: Sequence[float],
    region: Region,
    spacing: float | None,
    spots: Mapping[str, Spot],
    sizes: Sizes,
    starts: Mapping[str, Start],
    rng: np.random.Generator,
) -> Spot | None:
    """Return a point of a region with a gap to all spots, and the spacing that either of two asks for."""
    (x0, x1), (y0, y1) = region
    others = [(spots[name], sizes[name]) for name in spots]
    spacings = {name: max(spacing or 0.0, starts.get(name, NOWHERE).spacing or 0.0) for name in spots}
    for _ in range(TRIES):
        x, y = float(rng.uniform(x0, x1)), float(rng.uniform(y0, y1))
        spaced = all(hypot(x - spots[name][0], y - spots[name][1]) >= spacings[name] for name in spots)
        if spaced and clearance((x, y), size, others) > GAP:
            return x, y
    return None


def _stack_up(
    items: Sequence[SceneObject],
    starts: Mapping[str, Start],
    spots: dict[str, Spot],
    by_name: Mapping[str, SceneObject],
    yaws: Mapping[str, float],
    rng: np.random.Generator,
) -> str | None:
    """Add the spots of objects that start on others, from the bottom up; return one without room, if any.

    Args:
        yaws: of objects of which they are declared [rad].
    """
    for obj in items:
        surface = starts.get(obj.name, NOWHERE).surface
        if surface not in by_name or obj.name in spots:
            continue
        offset = starts[obj.name].offset
        if offset is not None or not shares(by_name[surface], obj):
            dx, dy = _turned_by(offset, yaws.get(surface, 0.0)) if offset else (0.0, 0.0)
            if offset is not None:
                _check_is_part(obj, by_name[surface], (dx, dy), starts[obj.name])
            spots[obj.name] = spots[surface][0] + dx, spots[surface][1] + dy
            continue
        there = [t for t in items if _is_spread_over(starts.get(t.name, NOWHERE), surface)]
        found = _beside_each_other(there, by_name[surface], starts, spots[surface], rng)
        if found is None:
            return obj.name
        spots |= found
    standing = _stacked(items, starts, spots)
    stacked = (obj.name for obj in items if starts.get(obj.name, NOWHERE).surface in by_name)
    return next((name for name in stacked if not standing.is_free(name, standing.positions[name])), None)


def _fits_on(surface: SceneObject, size: Sequence[float]) -> bool:
    inner = surface.cavity or (surface.size[0] / 2, surface.size[1] / 2)
    return all(extent <= 2 * half for extent, half in zip(size, inner[:2], strict=False))


def _turned_by(offset: Spot, yaw: float) -> Spot:
    x, y = offset
    return cos(yaw) * x - sin(yaw) * y, sin(yaw) * x + cos(yaw) * y


def _check_is_part(obj: SceneObject, below: SceneObject, offset: Spot, start: Start) -> None:
    """Raise `NoRoom` for an offset from something that moves, or to beyond its edge."""
    if below.movable:
        raise NoRoom(
            f"{obj.name} has an offset from {below.name}, which moves; parts are of something fixed",
            start.group,
        )
    if any(abs(way) > extent / 2 for way, extent in zip(offset, below.size, strict=False)):
        raise NoRoom(
            f"the offset of {obj.name} is beyond the edge of {below.name} ({_in_cm(below.size)})", start.group
        )


def _is_spread_over(start: Start, surface: str) -> bool:
    return start.surface == surface and start.offset is None


def _beside_each_other(
    items: Sequence[SceneObject],
    surface: SceneObject,
    starts: Mapping[str, Start],
    at: Spot,
    rng: np.random.Generator,
) -> dict[str, Spot] | None:
    """Place objects on a tray or in a container: at free points, or in a grid; None without room."""
    found: dict[str, Spot] = {}
    sizes = {obj.name: _seen_from_above(obj, starts[obj.name]) for obj in items}
    for obj in items:
        size = sizes[obj.name]
        if starts[obj.name].yaw is not None and not _fits_on(surface, size):
            return None
        region = region_within(surface, at, size)
        spot = _free_spot(size, region, starts[obj.name].spacing, found, sizes, starts, rng)
        if spot is None:
            break
        found[obj.name] = spot
    else:
        return found
    width = max(max(size) for size in sizes.values())
    cells = free_cells(len(items), width, region_within(surface, at, (0.0, 0.0)), ())
    if cells is None or any(starts[obj.name].spacing for obj in items):
        return None
    return dict(zip(sizes, in_cells(*cells, width, rng), strict=False))


def furniture_positions(objects: Iterable[SceneObject]) -> dict[str, Vector]:
    """Return the positions of tables, whose tops are at height zero."""
    return {obj.name: (*CENTRE, -obj.size[2] / 2) for obj in objects if obj.size[0] > TOO_WIDE}
