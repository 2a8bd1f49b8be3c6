"""What a task's scene says of its things: how many, where they start, and what they look like."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ntp_dsl.language.diagnostics.diagnostics import Fix, unknown
from ntp_dsl.language.names.signatures import check_order, fits, head, measure, phrase, si
from ntp_dsl.language.names.symbol_table import UNITS, Table
from ntp_dsl.language.repairs.task_repairs import reversed_count
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.nodes import (
    Detail,
    Interval,
    Name,
    Number,
    SceneGroup,
    Span,
    TaskDeclaration,
    Text,
    TypeName,
)

GOAL = "goal"  # what `run` and `success` call the list that the sampler draws
LENGTH = TypeName("length")
SHAPES: Mapping[str, tuple[str, ...]] = {  # shape -> what its settings measure
    "cube": ("edge",),
    "box": ("length", "width", "height"),
    "cylinder": ("diameter", "height"),
    "bowl": ("diameter", "height"),
    "bin": ("length", "width", "height"),
    "mesh": ("file", "length", "width", "height"),
    "urdf": ("file", "length", "width", "height"),
}
PLACING: Mapping[str, tuple[str, ...]] = {  # where the things of a group may start
    "x": ("region",),
    "y": ("region",),
    "spacing": ("distance",),
    "at": ("positions",),
}
LARGEST = 2.0  # of things before an arm [m]
FILES = {"mesh", "urdf"}  # with the extents of what they describe


def check_scene(task: TaskDeclaration, table: Table) -> None:
    """Every group has a type, a number, a place to start from, and details that exist."""
    for index, group in enumerate(task.scene):
        _check_group(group, task, task.scene[:index], table)
        for number, detail in enumerate(group.details):
            _check_detail(detail, group, group.details[:number], table)


def _check_group(
    group: SceneGroup, task: TaskDeclaration, before: tuple[SceneGroup, ...], table: Table
) -> None:
    if group.type.name not in table.types or group.type.is_list:
        table.mistakes.append(
            unknown("E103", "there is no type", group.type.name, group.type.span, table.types)
        )
    others = [other for other in task.scene if other is not group]
    most = group.count if group.most is None else group.most
    if most < 1 or (group.count < 1 and not any(other.count for other in others)):
        table.report("E502", f"a scene of no {group.type.name} leaves nothing to do", group.span)
    if group.name == GOAL:
        message = f"'{GOAL}' is the task's goal, so no group of its scene can be called that"
        table.report("E305", message, head(group.span, group.name))
    if group.most is not None and group.most < group.count:
        message = f"{group.count}..{group.most} is empty: it ends below its start"
        table.report("E502", message, group.span, fix=reversed_count(group))
    if group.name in {other.name for other in before} or group.name in table.constants:
        table.report("E305", f"'{group.name}' is in the scene already", head(group.span, group.name))
    stem = f"{group.type.name.lower()}_"
    for constant in table.constants:
        if constant.startswith(stem) and constant.removeprefix(stem).isdecimal():
            message = f"'{constant}' is a constant, and the objects of '{group.name}' are called so as well"
            table.report("E305", message, head(group.span, group.name))
    places = [*table.constants, *(other.name for other in before)]
    if group.place not in places:
        table.mistakes.append(unknown("E101", "there is no place", group.place, group.place_span, places))
    if any(other.name == group.place and other.count < 1 for other in before):
        message = f"'{group.name}' start on '{group.place}', of which there may be none"
        table.report("E502", message, group.place_span, "declare at least 1 of those")


def _check_detail(detail: Detail, group: SceneGroup, before: tuple[Detail, ...], table: Table) -> None:
    span = head(detail.span, detail.name)
    same = [other.name for other in before if other.name == detail.name]
    shaped = [other.name for other in before if other.name in SHAPES and detail.name in SHAPES]
    if same or shaped:
        message = f"'{group.name}' has a {(same or shaped)[0]} already"
        last, end = before[-1].span, detail.span
        rest = Span(end.path, last.end_line, last.end_column, end.end_line, end.end_column)
        table.report("E305", message, span, "one of the two is enough", fix=Fix(rest, ""))
    elif detail.name in SHAPES or detail.name in PLACING:
        _check_settings(detail, group, {**SHAPES, **PLACING}[detail.name], table)
    elif detail.name in table.predicates:
        _check_reading(detail, group, table)
    else:
        readings = [each.name for each in table.predicates.values() if each.result is not None]
        known = [*SHAPES, *PLACING, *readings]
        table.mistakes.append(unknown("E111", "things have no", detail.name, span, known))


def _check_positions(detail: Detail, group: SceneGroup, table: Table) -> None:
    """`at(0.3 m, -0.2 m, 0.3 m, 0.2 m)`: x and y, for one thing after the other."""
    places, things = len(detail.settings) // 2, max(group.count, group.most or 0)
    if detail.settings and not len(detail.settings) % 2 and places < things:
        message = f"'{group.name}' are {things}, and here are places for {places}"
        table.report("E504", message, head(detail.span, detail.name), "each takes an x and a y")
    if not detail.settings or len(detail.settings) % 2:
        message = f"'at' takes pairs of x and y, here are {len(detail.settings)} numbers"
        help = "for example: at(0.4 m, -0.2 m, 0.4 m, 0.2 m)"
        table.report("E201", message, head(detail.span, detail.name), help)
    for setting in detail.settings:
        if not isinstance(setting, Number):
            table.report("E504", "a position is a length", setting.span, "for example: -20 cm")
            continue
        found = measure(table, setting, LENGTH)
        if found is not None and not fits(table, found, LENGTH):
            table.report("E204", f"a position is a length, and this {phrase(found)}", setting.span)


def _check_settings(detail: Detail, group: SceneGroup, wanted: tuple[str, ...], table: Table) -> None:
    if detail.name == "at":
        _check_positions(detail, group, table)
        return
    span = head(detail.span, detail.name)
    if len(detail.settings) != len(wanted):
        message = f"'{detail.name}' takes {len(wanted)}, here are {len(detail.settings)}"
        fix = None
        match wanted, detail.settings:
            case ("region",), (Number() as low, Number() as high):
                low = low if low.unit or not high.unit else replace(low, unit=high.unit)
                start, end = low.span, high.span
                whole = Span(start.path, start.line, start.column, end.end_line, end.end_column)
                fix = Fix(whole, f"{format_expression(low)} .. {format_expression(high)}")
        table.report("E201", message, span, f"{detail.name}({', '.join(wanted)})", fix=fix)
        return
    for setting, meaning in zip(detail.settings, wanted, strict=True):
        if meaning == "file":
            if not isinstance(setting, Text):
                message = f"'{detail.name}' takes a file's name in quotes, then its extents"
                help = f'for example: {detail.name}("cup.urdf", 8 cm, 8 cm, 10 cm)'
                table.report("E504", message, setting.span, help)
        elif meaning == "region" and not isinstance(setting, Interval):
            message = f"'{detail.name}' takes a range of positions"
            table.report("E504", message, setting.span, f"for example: {detail.name}(0.3 .. 0.5 m)")
        elif isinstance(setting, Interval) and meaning == "region":
            _check_interval(setting, table)
        elif isinstance(setting, Number):
            _check_length(setting, meaning, table)
        else:
            message = f"the {meaning} of a {detail.name} is a length"
            table.report("E504", message, setting.span, "for example: 5 cm")


def _check_length(number: Number, meaning: str, table: Table) -> None:
    found = measure(table, number, LENGTH)
    if found is not None and not fits(table, found, LENGTH):
        table.report("E204", f"the {meaning} is a length, and this {phrase(found)}", number.span)
    elif number.unit in ("", *UNITS) and (size := si(number)) is not None and not 0 < size <= LARGEST:
        meant = replace(number, unit="cm")
        is_near = number.unit in {"", "m"} and 0 < size <= 100
        fix = Fix(number.span, format_expression(meant)) if is_near else None
        help = f"did you mean {fix.replacement}?" if fix else ""
        message = f"{size:g} m is no size for a thing before an arm"
        table.report("E504", message, number.span, help, fix=fix)


def _check_interval(interval: Interval, table: Table) -> None:
    for bound in (interval.low, interval.high):
        found = measure(table, bound, LENGTH)
        if found is not None and not fits(table, found, LENGTH):
            table.report("E204", f"a position is a length, and this {phrase(found)}", bound.span)
    check_order(table, interval.low, interval.high, interval.span)


def _check_reading(detail: Detail, group: SceneGroup, table: Table) -> None:
    """`category(cup, plate)`: the things take these in turn."""
    declared = table.predicates[detail.name]
    span = head(detail.span, detail.name)
    if declared.result is None or declared.body is not None or len(declared.parameters) != 1:
        message = f"'{detail.name}' is not a reading of one thing, so a scene cannot set it"
        help = f"a reading is declared with its type: predicate {detail.name}(o: Object) -> ..."
        table.report("E504", message, span, help)
        return
    if not fits(table, group.type, declared.parameters[0].type):
        message = f"'{detail.name}' reads {phrase(declared.parameters[0].type)}, and these are each"
        table.report("E202", f"{message} {phrase(group.type)}", span)
    if not detail.settings:
        table.report("E201", f"'{detail.name}' takes at least one value", span)
    if declared.result.name not in table.type_names():
        return  # said already
    enum = table.enums.get(declared.result.name)
    for setting in detail.settings:
        if enum is not None:
            value = setting.id if isinstance(setting, Name) else ""
            if not value:
                message = f"'{detail.name}' is {phrase(declared.result)}, and this is no member of it"
                table.report("E202", message, setting.span, f"there is: {', '.join(enum.members)}")
            elif value not in enum.members:
                what = f"'{enum.name}' has no member"
                table.mistakes.append(unknown("E101", what, value, setting.span, enum.members))
        elif not isinstance(setting, Number):
            message = f"'{detail.name}' is {phrase(declared.result)}, and this is no number"
            table.report("E202", message, setting.span)
        else:
            found = measure(table, setting, declared.result)
            if found is not None and not fits(table, found, declared.result):
                message = f"'{detail.name}' is {phrase(declared.result)}, and this {phrase(found)}"
                table.report("E204", message, setting.span)
