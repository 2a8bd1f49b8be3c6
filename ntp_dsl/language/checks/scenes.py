"""Checks of a task's scene: how many objects there are, where they start, and what they look like."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, unknown
from ntp_dsl.language.names.signatures import (
    are_given,
    check_order,
    counted,
    fits,
    leading_span,
    measure,
    si,
    with_article,
)
from ntp_dsl.language.names.symbol_table import UNITS, SymbolTable
from ntp_dsl.language.repairs.argument_repairs import decimal_points
from ntp_dsl.language.repairs.task_repairs import reversed_count
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.nodes import (
    Detail,
    Interval,
    Name,
    Number,
    SceneGroup,
    Setting,
    Span,
    TaskDeclaration,
    Text,
    TypeName,
)

GOAL = "goal"  # what `run` and `success` call the list that the sampler draws
LENGTH, ANGLE = TypeName("length"), TypeName("angle")
SHAPES: Mapping[str, tuple[str, ...]] = {  # shape -> what its settings measure
    "cube": ("edge",),
    "box": ("length", "width", "height"),
    "cylinder": ("diameter", "height"),
    "bowl": ("diameter", "height"),
    "bin": ("length", "width", "height"),
    "mesh": ("file", "length", "width", "height"),
    "urdf": ("file", "length", "width", "height"),
}
PLACING: Mapping[str, tuple[str, ...]] = {  # where the objects of a group may start
    "x": ("region",),
    "y": ("region",),
    "spacing": ("distance",),
    "at": ("positions",),
    "offset": ("positions",),
    "yaw": ("angle",),
}
TOGETHER = {"E101", "E305"}  # codes of what depends on all groups of a scene
TABLE = "table"
# About how far to either side, at an x, the Panda gets from above: it gets farther than the others [m].
REACH = ((0.23, 0.6), (0.5, 0.6), (0.65, 0.45), (0.77, 0.2))
TURN = 6.3  # [rad]
EXAMPLES = {"at": "0.4 m, -0.2 m, 0.4 m, 0.2 m", "offset": "-8 cm, 0 cm, 8 cm, 0 cm"}
PHYSICAL = {"mass": "mass", "friction": "number"}  # readings that the arm's simulation heeds, and their types
LARGEST = 2.0  # extent of an object in front of an arm [m]
FILES = {"mesh", "urdf"}  # with the extents of what they describe


def named_objects(task: TaskDeclaration) -> Iterator[tuple[str, TypeName]]:
    """Yield the names by which a task may call single objects of its scene, each with its type.

    They are those that are declared by themselves, and the numbered ones that are always there.
    """
    yield from ((group.name, group.type) for group in task.scene if group.is_single)
    uncertain: set[str] = set()  # types of which there is a varying number
    for group, names in numbered_objects(task):
        if group.type.name not in uncertain:
            yield from ((name, group.type) for name in names[: group.count])
        if group.most is not None:
            uncertain.add(group.type.name)


def numbered_objects(task: TaskDeclaration) -> Iterator[tuple[SceneGroup, list[str]]]:
    """Yield the groups of numbered objects with the names that these may have."""
    used: Counter[str] = Counter()
    for group in task.scene:
        if not group.is_single:
            stem, first = group.type.name.lower(), used[group.type.name]
            used[group.type.name] += group.most or group.count
            yield group, [f"{stem}_{number}" for number in range(first, used[group.type.name])]


def check_scene(task: TaskDeclaration, table: SymbolTable) -> Iterator[Diagnostic]:
    """Check that every group has a type, a number, a place to start from, and details that exist."""
    own = {each.name for each in task.shared.own} if task.shared else None
    for index, group in enumerate(task.scene):
        if task.shared and own is not None and group.name not in own:
            for each in _check_group(group, task, task.scene[:index], table):
                if each.code in TOGETHER:  # the rest is checked where it is declared
                    yield replace(each, span=task.shared.task_span, fix=None)
            continue
        yield from _check_group(group, task, task.scene[:index], table)
        for number, detail in enumerate(group.details):
            yield from _check_detail(detail, group, group.details[:number], table)
        yield from _check_reach(group)


def _check_group(
    group: SceneGroup, task: TaskDeclaration, before: tuple[SceneGroup, ...], table: SymbolTable
) -> Iterator[Diagnostic]:
    if group.type.name not in table.types or group.type.is_list:
        yield unknown("E103", "there is no type", group.type.name, group.type.span, table.types)
    others = [other for other in task.scene if other is not group]
    most = group.count if group.most is None else group.most
    if most < 1 or (group.count < 1 and not any(other.count for other in others)):
        yield Diagnostic("E502", f"a scene with no {group.type.name} leaves nothing to do", group.span)
    if group.name == GOAL:
        message = f"'{GOAL}' is the task's goal, so no group of its scene can be called that"
        yield Diagnostic("E305", message, leading_span(group.span, group.name))
    if group.most is not None and group.most < group.count:
        message = f"{group.count}..{group.most} is empty: it ends below its start"
        yield Diagnostic("E502", message, group.span, fix=None if task.shared else reversed_count(group))
    taken = {other.name for other in before} | {name for _, names in numbered_objects(task) for name in names}
    if group.name in taken or group.name in table.constants:
        yield Diagnostic(
            "E305", f"'{group.name}' is in the scene already", leading_span(group.span, group.name)
        )
    stem = f"{group.type.name.lower()}_"
    for constant in table.constants:
        if constant.startswith(stem) and constant.removeprefix(stem).isdecimal():
            message = f"'{constant}' is a constant, and an object of '{group.name}' has the same name"
            yield Diagnostic("E305", message, leading_span(group.span, group.name))
    places = [*table.constants, *(other.name for other in before)]
    if group.place not in places:
        yield unknown("E101", "there is no place", group.place, group.place_span, places)
    if any(other.name == group.place and other.count < 1 for other in before):
        message = f"'{group.name}' starts on '{group.place}', which may be empty"
        yield Diagnostic("E502", message, group.place_span, help="declare at least 1 of those")


def _check_detail(
    detail: Detail, group: SceneGroup, before: tuple[Detail, ...], table: SymbolTable
) -> Iterator[Diagnostic]:
    span = leading_span(detail.span, detail.name)
    same = [other.name for other in before if other.name == detail.name]
    shaped = [other.name for other in before if other.name in SHAPES and detail.name in SHAPES]
    if same or shaped:
        message = f"'{group.name}' has a {(same or shaped)[0]} already"
        last, end = before[-1].span, detail.span
        rest = Span(end.path, last.end_line, last.end_column, end.end_line, end.end_column)
        yield Diagnostic("E305", message, span, help="one of the two is enough", fix=Fix(rest, ""))
    elif clashes := [other.name for other in before if _exclude_each_other(detail.name, other.name)]:
        message = f"'{detail.name}' and '{clashes[0]}' both say where or how '{group.name}' start"
        yield Diagnostic("E504", message, span, help="one of the two is enough")
    elif detail.name in SHAPES or detail.name in PLACING:
        yield from _check_settings(detail, group, {**SHAPES, **PLACING}[detail.name], table)
    elif detail.name in table.predicates:
        yield from _check_reading(detail, group, table)
    else:
        readings = [each.name for each in table.predicates.values() if each.result is not None]
        known = [*SHAPES, *PLACING, *readings]
        help = (
            f"there is: {', '.join(known)}; or declare a reading:"
            f" predicate {detail.name}(o: {group.type.name}) -> ..., with a number type or an enumeration"
        )
        yield unknown("E111", "objects have no property", detail.name, span, known, help)


def _exclude_each_other(one: str, other: str) -> bool:
    """Return whether two details cannot be heeded together: places twice, or a bowl or bin that is turned."""
    pair = {one, other}
    return any(pair <= {"offset", place} for place in ("at", "x", "y", "spacing")) or any(
        pair <= {"yaw", shape} for shape in ("bowl", "bin")
    )


def _check_reach(group: SceneGroup) -> Iterator[Diagnostic]:
    """Note places on the table that the arms that ship do not reach: the kinematic world gets anywhere."""
    for detail in group.details:
        places = [*_places(detail)] if group.place == TABLE else []
        beyond = [(x, y) for x, y in places if not _is_within_reach(x, y)]
        if beyond:
            told = dict(zip("xy", (f"{100 * each:g} cm" for each in beyond[0]), strict=True))
            axes = detail.name if detail.name in told else "xy"
            where = ", ".join(f"{axis} {told[axis]}" for axis in axes)
            message = f"the arms do not reach {where} from above"
            help = "the kinematic world does; with an arm, keep to what the reference says of its reach"
            yield Diagnostic("N502", message, leading_span(detail.span, detail.name), help=help)


def _places(detail: Detail) -> Iterator[tuple[float, float]]:
    """Yield the places of `at`, and the far ends of `x` and `y` [m]."""
    match detail.name, detail.settings:
        case "at", settings:
            numbers = [si(each) or 0.0 for each in settings if isinstance(each, Number)]
            yield from zip(numbers[::2], numbers[1::2], strict=False)
        case "x", (Interval(low, high),):
            yield from ((si(bound) or 0.0, 0.0) for bound in (low, high))
        case "y", (Interval(low, high),):
            yield from ((REACH[0][0], si(bound) or 0.0) for bound in (low, high))


def _is_within_reach(x: float, y: float) -> bool:
    for (x0, side0), (x1, side1) in pairwise(REACH):
        if x0 - 1e-9 <= x <= x1 + 1e-9:
            return abs(y) <= side0 + (side1 - side0) * (x - x0) / (x1 - x0) + 1e-9
    return False


def _check_positions(detail: Detail, group: SceneGroup, table: SymbolTable) -> Iterator[Diagnostic]:
    """Check `at(0.3 m, -0.2 m, 0.3 m, 0.2 m)`, or `offset`: x and y, for one object after the other."""
    span = leading_span(detail.span, detail.name)
    places, count = len(detail.settings) // 2, max(group.count, group.most or 0)
    if detail.settings and not len(detail.settings) % 2 and places < count:
        message = f"'{group.name}' are {counted(count, 'object')}, and here are places for {places}"
        yield Diagnostic("E504", message, span, help="each takes an x and a y")
    if not detail.settings or len(detail.settings) % 2:
        message = f"'{detail.name}' takes pairs of x and y, and {are_given(len(detail.settings))}"
        yield Diagnostic("E201", message, span, help=f"for example: {detail.name}({EXAMPLES[detail.name]})")
    if detail.name == "offset" and group.place in table.constants:
        message = f"an offset is from the middle of an object of the scene, and '{group.name}' start on"
        help = "on a constant, such as the table, say where: at(0.4 m, -0.2 m)"
        yield Diagnostic("E504", f"{message} '{group.place}'", span, help=help)
    for setting in detail.settings:
        if isinstance(setting, Number):
            yield from _check_position(setting, table)
        else:
            yield Diagnostic("E504", "a position is a length", setting.span, help="for example: -20 cm")


def _check_position(number: Number, table: SymbolTable) -> Iterator[Diagnostic]:
    found = yield from measure(number, LENGTH)
    if found is not None and not fits(table, found, LENGTH):
        message = f"a position is a length, and this is {with_article(found)}"
        yield Diagnostic("E204", message, number.span)
    elif number.unit in ("", *UNITS) and (at := si(number)) is not None and abs(at) > LARGEST:
        meant = format_expression(replace(number, unit="cm"))
        help = f"did you mean {meant}?" if number.unit in ("", "m") and abs(at) <= 100 else ""
        yield Diagnostic("E504", f"{at:g} m is no place in front of an arm", number.span, help=help)


def _check_settings(
    detail: Detail, group: SceneGroup, wanted: tuple[str, ...], table: SymbolTable
) -> Iterator[Diagnostic]:
    if detail.name in ("at", "offset"):
        yield from _check_positions(detail, group, table)
        return
    span = leading_span(detail.span, detail.name)
    if len(detail.settings) != len(wanted):
        message = (
            f"'{detail.name}' takes {counted(len(wanted), 'setting')}, and {are_given(len(detail.settings))}"
        )
        fix = decimal_points(detail.settings, len(wanted))
        match wanted, detail.settings:
            case ("region",), (Number() as low, Number() as high) if fix is None:
                start, end = low.span, high.span
                whole = Span(start.path, start.line, start.column, end.end_line, end.end_column)
                text = f"{format_expression(low)} .. {format_expression(high)}"
                fix = Fix(whole, text, certain=low.unit == high.unit)
        yield Diagnostic("E201", message, span, help=f"{detail.name}({', '.join(wanted)})", fix=fix)
        return
    for setting, meaning in zip(detail.settings, wanted, strict=True):
        if meaning == "angle":
            yield from _check_angle(setting, table)
        elif meaning == "file":
            if not isinstance(setting, Text):
                message = f"'{detail.name}' takes a file's name in quotes, then its extents"
                help = f'for example: {detail.name}("cup.urdf", 8 cm, 8 cm, 10 cm)'
                yield Diagnostic("E504", message, setting.span, help=help)
        elif meaning == "region" and not isinstance(setting, Interval):
            message = f"'{detail.name}' takes a range of positions"
            yield Diagnostic("E504", message, setting.span, help=f"for example: {detail.name}(0.3 .. 0.5 m)")
        elif isinstance(setting, Interval) and meaning == "region":
            yield from _check_interval(setting, table)
        elif isinstance(setting, Number):
            yield from _check_length(setting, meaning, table)
        else:
            message = f"the {meaning} of a {detail.name} is a length"
            yield Diagnostic("E504", message, setting.span, help="for example: 5 cm")


def _check_angle(setting: Setting, table: SymbolTable) -> Iterator[Diagnostic]:
    """Check `yaw(30 deg)` or `yaw(-45 .. 45 deg)`."""
    bounds = [setting.low, setting.high] if isinstance(setting, Interval) else [setting]
    for bound in bounds:
        found = (yield from measure(bound, ANGLE)) if isinstance(bound, Number) else None
        if not isinstance(bound, Number) or (found is not None and not fits(table, found, ANGLE)):
            message = "'yaw' takes an angle about the vertical, or a range of angles"
            yield Diagnostic("E504", message, bound.span, help="for example: yaw(-45 .. 45 deg)")
        elif not bound.unit and abs(bound.value) > TURN:
            meant = format_expression(replace(bound, unit="deg"))
            message = f"{bound.value:g} rad is more than a turn"
            yield Diagnostic(
                "E504", message, bound.span, help=f"did you mean {meant}?", fix=Fix(bound.span, meant)
            )
    if isinstance(setting, Interval):
        yield from check_order(setting.low, setting.high, setting.span)


def _check_length(number: Number, meaning: str, table: SymbolTable) -> Iterator[Diagnostic]:
    found = yield from measure(number, LENGTH)
    if found is not None and not fits(table, found, LENGTH):
        yield Diagnostic("E204", f"the {meaning} is a length, and this is {with_article(found)}", number.span)
    elif number.unit in ("", *UNITS) and (size := si(number)) is not None and not 0 < size <= LARGEST:
        meant = replace(number, unit="cm")
        is_near = number.unit in {"", "m"} and 0 < size <= 100
        help = f"did you mean {format_expression(meant)}?" if is_near else ""
        message = f"{size:g} m is no size for an object in front of an arm"
        yield Diagnostic("E504", message, number.span, help=help)


def _check_interval(interval: Interval, table: SymbolTable) -> Iterator[Diagnostic]:
    for bound in (interval.low, interval.high):
        yield from _check_position(bound, table)
    yield from check_order(interval.low, interval.high, interval.span)


def _check_physical(detail: Detail, result: TypeName) -> Iterator[Diagnostic]:
    """Check what the arm's simulation makes of a reading: an object's mass, or its friction."""
    wanted = PHYSICAL.get(detail.name)
    if wanted is None:
        return
    span = leading_span(detail.span, detail.name)
    if result.name != wanted:
        message = (
            f"'{detail.name}' is that of the simulated object, and a {wanted}; this is {with_article(result)}"
        )
        yield Diagnostic("E504", message, span, help=f"declare it '-> {wanted}', or call it something else")
        return
    for setting in detail.settings:
        if isinstance(setting, Number) and setting.value <= 0:
            message = f"the {detail.name} of an object is above zero"
            yield Diagnostic("E504", message, setting.span)


def _check_reading(detail: Detail, group: SceneGroup, table: SymbolTable) -> Iterator[Diagnostic]:
    """Check `category(cup, plate)`: the objects take these values in turn."""
    declared = table.predicates[detail.name]
    span = leading_span(detail.span, detail.name)
    if declared.result is None or declared.body is not None or len(declared.parameters) != 1:
        message = f"'{detail.name}' is not a reading of one object, so a scene cannot set it"
        help = f"a reading is declared with its type: predicate {detail.name}(o: Object) -> ..."
        yield Diagnostic("E504", message, span, help=help)
        return
    if not fits(table, group.type, declared.parameters[0].type):
        message = f"'{detail.name}' reads {with_article(declared.parameters[0].type)}, and each of these is"
        yield Diagnostic("E202", f"{message} {with_article(group.type)}", span)
    if not detail.settings:
        yield Diagnostic("E201", f"'{detail.name}' takes at least one value", span)
    if declared.result.name not in table.type_names():
        return  # reported where the predicate is declared
    yield from _check_physical(detail, declared.result)
    enum = table.enums.get(declared.result.name)
    for setting in detail.settings:
        if enum is not None:
            value = setting.id if isinstance(setting, Name) else ""
            if not value:
                message = f"'{detail.name}' is {with_article(declared.result)}, and this is no member of it"
                yield Diagnostic("E202", message, setting.span, help=f"there is: {', '.join(enum.members)}")
            elif value not in enum.members:
                what = f"'{enum.name}' has no member"
                yield unknown("E101", what, value, setting.span, enum.members)
        elif not isinstance(setting, Number):
            message = f"'{detail.name}' is {with_article(declared.result)}, and this is not a number"
            yield Diagnostic("E202", message, setting.span)
        else:
            found = yield from measure(setting, declared.result)
            if found is not None and not fits(table, found, declared.result):
                message = (
                    f"'{detail.name}' is {with_article(declared.result)}, and this is {with_article(found)}"
                )
                yield Diagnostic("E204", message, setting.span)
