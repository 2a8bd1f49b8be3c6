"""Numbers in an element of a list: of those for which the contract holds, the middle."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import combinations, product
from math import hypot, pi

import numpy as np

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.logic.facts import value_of
from ntp_dsl.language.registry import Parameter, Program, Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.visitors import innermost, loops, walk
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.value_checks import SLACK

Range = tuple[float, float]
Numbers = tuple[float, ...]
Ranges = Mapping[str, Range]  # by field
ANYWHERE: Mapping[str, Range] = {  # for a number that nothing bounds, by what it measures [SI]
    "length": (-0.6, 0.6),
    "angle": (-pi, pi),
}
ANY_NUMBER: Range = (0.0, 10.0)
MOST = 30_000  # combinations of numbers that are tried
STEPS = 49  # over its range, in which a number is sought
HALVINGS = 14


def ranges_of(registry: Registry, program: Program, parameter: Parameter) -> Ranges:
    """Return the ranges of the number fields of a list's elements: their own, or those of calls."""
    found: dict[str, Range] = {}
    for field in registry.records.get(parameter.type, ()):
        if field.type in registry.parents or field.type in registry.enums:
            continue
        if field.low is not None and field.high is not None:
            found[field.name] = (field.low, field.high)
            continue
        within = [*_of_field(registry, program, parameter.name, field.name, set())]
        if within:
            low, high = max(low for low, _ in within), min(high for _, high in within)
            if low <= high:
                found[field.name] = (low, high)
    return found


def _of_field(
    registry: Registry, program: Program, source: str, field: str, seen: set[tuple[str, str, str]]
) -> Iterator[Range]:
    """Yield the ranges of the parameters that a field of a list's elements, or of a record, is passed to."""
    if (program.name, source, field) in seen:
        return
    seen.add((program.name, source, field))
    for statement in program.body:
        names = {source} | {each.variable for each in loops(statement) if each.iterable.id == source}
        call = innermost(statement)
        callee = registry[call.callee]
        for parameter, term in zip(callee.parameters, call.arguments, strict=True):
            if isinstance(term, nodes.Name) and term.id in names and isinstance(callee, Program):
                yield from _of_field(registry, callee, parameter.name, field, seen)
            else:
                found: set[nodes.Expression] = {nodes.Field(nodes.Name(name), field) for name in names}
                yield from _through(registry, callee, parameter, term, found, seen)


def _of_number(
    registry: Registry, program: Program, name: str, seen: set[tuple[str, str, str]]
) -> Iterator[Range]:
    """Yield the ranges of the parameters that a program passes a number on to."""
    if (program.name, name, "") in seen:
        return
    seen.add((program.name, name, ""))
    for statement in program.body:
        call = innermost(statement)
        callee = registry[call.callee]
        for parameter, term in zip(callee.parameters, call.arguments, strict=True):
            yield from _through(registry, callee, parameter, term, {nodes.Name(name)}, seen)


def _through(
    registry: Registry,
    callee: object,
    parameter: Parameter,
    term: nodes.Expression,
    number: set[nodes.Expression],
    seen: set[tuple[str, str, str]],
) -> Iterator[Range]:
    """Yield the range of a parameter in terms of the number that its argument is calculated from."""
    line = _affine(term, number)
    if line is None or not line[0]:
        return
    inner = [(parameter.low, parameter.high)]
    if (parameter.low is None or parameter.high is None) and isinstance(callee, Program):
        inner = [*_of_number(registry, callee, parameter.name, seen)]
    for low, high in inner:
        if low is not None and high is not None:
            ends = sorted((end - line[1]) / line[0] for end in (low, high))
            yield ends[0], ends[1]


def lines(condition: nodes.Expression) -> Iterator[tuple[float, float]]:
    """Yield a and b for each term of a condition that is a times some field plus b."""
    yield 1.0, 0.0
    for each in walk(condition):
        if isinstance(each, nodes.Arithmetic):
            fields = {part for part in walk(each) if isinstance(part, nodes.Field)}
            line = _affine(each, set(fields)) if len(fields) == 1 else None
            if line is not None and line[0]:
                yield line


def _affine(term: nodes.Expression, number: set[nodes.Expression]) -> tuple[float, float] | None:
    """Return a and b where a term is a times the number plus b; None where it is not."""
    if term in number:
        return 1.0, 0.0
    known = value_of(term)
    if known is not None:
        return 0.0, known
    if not isinstance(term, nodes.Arithmetic):
        return None
    left, right = _affine(term.left, number), _affine(term.right, number)
    if left is None or right is None:
        return None
    match term.operator:
        case "+":
            return left[0] + right[0], left[1] + right[1]
        case "-":
            return left[0] - right[0], left[1] - right[1]
        case "*" if not left[0]:
            return left[1] * right[0], left[1] * right[1]
        case "*" if not right[0]:
            return left[0] * right[1], left[1] * right[1]
        case "/" if not right[0] and right[1]:
            return left[0] / right[1], left[1] / right[1]
    return None


def fitting_numbers(
    holds: Callable[[Numbers], bool], limits: Sequence[Range], likely: Sequence[float], thorough: bool
) -> Numbers | None:
    """Return numbers for which something holds: of all that do, the middle; None where none was found.

    Args:
        limits: of each number.
        likely: what is tried for each.
        thorough: then a grid over each range is tried, too.
    """
    near = [list(dict.fromkeys(v for v in likely if low <= v <= high)) for low, high in limits]
    steps = STEPS if len(limits) <= 2 else STEPS // 6
    grids = [np.linspace(low, high, steps).tolist() for low, high in limits] if thorough else []
    for options in (near, grids) if thorough else (near,):
        most = int(MOST ** (1 / len(limits)))
        hit = next((values for values in product(*(each[:most] for each in options)) if holds(values)), None)
        if hit is not None:
            return _middle(hit, limits, holds)
    return None


def distances(places: Sequence[Vector]) -> list[float]:
    """Return the offsets and distances between places, each once [m]."""
    found: list[float] = []
    for a, b in combinations(places, 2):
        dx, dy, dz = (p - q for p, q in zip(a, b, strict=True))
        found += [dx, -dx, dy, -dy, dz, -dz, hypot(dx, dy), hypot(dx, dy, dz)]
    return list(dict.fromkeys(round(each, 4) for each in found))


def _middle(hit: Numbers, limits: Sequence[Range], holds: Callable[[Numbers], bool]) -> Numbers:
    """Return the middle of what holds around a hit, along each axis in turn.

    It is sought beyond the ranges, too, so that it does not lie off where a range ends; where what holds does
    not end there either, the hit is kept.
    """
    values = list(hit)
    for _ in range(2 if len(hit) > 1 else 1):
        for axis, (low, high) in enumerate(limits):
            before, after = tuple(values[:axis]), tuple(values[axis + 1 :])
            at = partial(_with, holds, before, after)
            beyond = (high - low) / 2 + SLACK
            ends = low - beyond, high + beyond
            if not any(map(at, ends)):
                middle = sum(_edge(values[axis], end, at) for end in ends) / 2
                values[axis] = min(max(round(middle, 5), low), high)
    return tuple(values)


def _with(holds: Callable[[Numbers], bool], before: Numbers, after: Numbers, value: float) -> bool:
    with suppress(NtpError):  # a predicate in Python need not expect numbers beyond their range
        return holds((*before, value, *after))
    return False


def _edge(inside: float, outside: float, at: Callable[[float], bool]) -> float:
    for _ in range(HALVINGS):
        half = (inside + outside) / 2
        inside, outside = (half, outside) if at(half) else (inside, half)
    return inside
