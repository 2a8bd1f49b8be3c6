"""The contents of a task's scene: names, sizes and traits of its objects, and where each may start."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ntp_dsl.language.checks.scenes import FILES, PLACING, SHAPES
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.names.signatures import si
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import SceneGroup, TaskDeclaration
from ntp_dsl.semantics.free_space import Interval
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import TOO_WIDE, SceneObject

CUBE = 0.05  # the default object [m]
TABLE = "table"
TABLE_SIZE = (1.5, 1.5, 0.04)
TRAY_SIZE = (0.16, 0.16, 0.02)  # of a constant that is a place other than the table
LIFTED, SURFACE = "Movable", "Table"  # types of the standard library that worlds know by name


@dataclass(frozen=True)
class Start:
    """Where an object starts: its support, its region, and its distance from others [m]."""

    surface: str = TABLE
    x: Interval | None = None
    y: Interval | None = None
    spacing: float | None = None  # between centres, seen from above
    yaw: Interval | None = None  # from the x axis to the object's [rad]
    offset: tuple[float, float] | None = None  # from the middle of its support, along that one's own x and y
    group: str = field(default="", compare=False)  # of the scene

    @property
    def exact(self) -> bool:
        """Return whether the object starts at one point of the table."""
        x, y = self.x or (0.0, 1.0), self.y or (0.0, 1.0)
        return self.surface == TABLE and x[0] == x[1] and y[0] == y[1]


class NoRoom(NtpError):
    """A scene cannot be made: the objects of `group` find no place where they are to start."""

    def __init__(self, message: str, group: str = "") -> None:
        self.group = group
        super().__init__(message)


@dataclass(frozen=True)
class Layout:
    """The objects of one instance of a task, by group, and where each starts."""

    objects: tuple[SceneObject, ...]
    groups: Mapping[str, list[str]]
    starts: Mapping[str, Start] = field(default_factory=dict)


def layout(registry: Registry, task: TaskDeclaration, rng: np.random.Generator | None = None) -> Layout:
    """Return the objects of all groups: `blocks: 8 Block` is block_0 … block_7; ranges are drawn.

    Args:
        rng: for counts that are ranges, and for who starts on whom; without it, the largest counts, in order.
    """
    used: Counter[str] = Counter()
    loads: Counter[str] = Counter()  # how many objects start on each
    groups: dict[str, list[str]] = {}
    objects: list[SceneObject] = []
    starts: dict[str, Start] = {}
    for group in task.scene:
        count = _count(group, rng)
        stem, first = group.type.name.lower(), used[group.type.name]  # numbers go on over groups
        if group.is_single:
            names = [group.name]
        else:
            used[group.type.name] += count
            names = [f"{stem}_{number}" for number in range(first, first + count)]
        surfaces = _dealt(groups.get(group.place, [group.place]), count, loads, rng)
        for index, (name, surface) in enumerate(zip(names, surfaces, strict=True)):
            objects.append(_object(name, group, index, registry))
            _check_width(objects[-1], group, registry)
            starts[name] = _start(group, index, surface)
        groups[group.name] = names
    return Layout(with_furniture(registry, objects), groups, starts)


def _count(group: SceneGroup, rng: np.random.Generator | None) -> int:
    if group.most is None:
        return group.count
    return group.most if rng is None else int(rng.integers(group.count, group.most + 1))


def _dealt(
    places: Sequence[str], count: int, loads: Counter[str], rng: np.random.Generator | None
) -> list[str]:
    """Return a place for each of so many objects, the least loaded first; who goes where is drawn."""
    shuffled = rng if len(places) > 1 else None
    order = [places[index] for index in shuffled.permutation(len(places))] if shuffled else places
    dealt: list[str] = []
    for _ in range(count):
        dealt.append(min(order, key=lambda place: loads[place]))
        loads[dealt[-1]] += 1
    return [dealt[index] for index in shuffled.permutation(count)] if shuffled else dealt


def _object(name: str, group: SceneGroup, index: int, registry: Registry) -> SceneObject:
    """Return an object of a group; a cube by default."""
    type_name = group.type.name
    fixed = LIFTED in registry.parents and not registry.is_a(type_name, LIFTED)
    size: Vector = (CUBE, CUBE, CUBE)
    shape, file, traits = "box", "", {}
    for detail in group.details:
        settings = detail.settings
        if detail.name in SHAPES:
            shape = "box" if detail.name == "cube" else detail.name
            size = _size(detail)
            if detail.name in FILES and isinstance(settings[0], nodes.Text):
                folder = group.span.path.parent if group.span.path else Path()
                file = str(folder / settings[0].value)
        elif detail.name not in PLACING:
            traits[detail.name] = _trait(settings[index % len(settings)])
    return SceneObject(name, type_name, size, shape, file, fixed, tuple(traits.items()))


def _check_width(obj: SceneObject, group: SceneGroup, registry: Registry) -> None:
    """Raise `NoRoom` for an object that would be taken for a table."""
    if obj.size[0] > TOO_WIDE and not (SURFACE in registry.parents and registry.is_a(obj.type, SURFACE)):
        message = f"{obj.name} measures {100 * obj.size[0]:g} cm along x; {100 * TOO_WIDE:g} cm is the most"
        raise NoRoom(message, group.name)


def _size(detail: nodes.Detail) -> Vector:
    lengths = [si(each) or 0.0 for each in detail.settings if isinstance(each, nodes.Number)]
    if detail.name == "cube":
        return (lengths[0],) * 3
    if len(lengths) == 2:  # diameter and height
        return lengths[0], lengths[0], lengths[1]
    return lengths[0], lengths[1], lengths[2]


def _trait(setting: nodes.Setting) -> str | float:
    return setting.id if isinstance(setting, nodes.Name) else float(_number(setting))


def _number(setting: nodes.Setting) -> float:
    value = si(setting) if isinstance(setting, nodes.Number) else None
    assert value is not None
    return value


def _start(group: SceneGroup, index: int, surface: str) -> Start:
    settings = {detail.name: detail.settings[0] for detail in group.details if detail.name in PLACING}
    spacing = settings.get("spacing")
    yaw, offset = _interval(settings.get("yaw")), _pair(group, "offset", index)
    if (at := _pair(group, "at", index)) is not None:
        x, y = at
        return Start(surface, (x, x), (y, y), yaw=yaw, group=group.name)
    return Start(
        surface,
        _interval(settings.get("x")),
        _interval(settings.get("y")),
        None if spacing is None else _number(spacing),
        yaw,
        offset,
        group.name,
    )


def _pair(group: SceneGroup, name: str, index: int) -> tuple[float, float] | None:
    """Return the pair of lengths that a detail gives the object of that number, if it is there [m]."""
    given = next((detail.settings for detail in group.details if detail.name == name), ())
    if not given:
        return None
    x, y = (_number(given[(2 * index + axis) % len(given)]) for axis in (0, 1))
    return x, y


def _interval(setting: nodes.Setting | None) -> Interval | None:
    match setting:
        case nodes.Interval(low, high):
            return _number(low), _number(high)
        case nodes.Number():
            return _number(setting), _number(setting)
    return None


def with_furniture(registry: Registry, objects: Iterable[SceneObject]) -> tuple[SceneObject, ...]:
    """Return the objects and the constants that are places: the table, and trays beside it."""
    furniture = [
        SceneObject(name, type_name, *_extent(registry, type_name))
        for name, type_name in registry.constants.items()
        if registry.is_a(type_name, "Place")
    ]
    return (*objects, *furniture)


def _extent(registry: Registry, type_name: str) -> tuple[Vector, str, str, bool]:
    table = SURFACE not in registry.parents or registry.is_a(type_name, SURFACE)
    return (TABLE_SIZE if table else TRAY_SIZE), "box", "", not table


def movable(objects: Iterable[SceneObject]) -> list[SceneObject]:
    return [obj for obj in objects if obj.movable]
