"""Numbers in an element of a list: of those for which the contract holds, the middle."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import combinations, pairwise, permutations, product
from math import atan2, ceil, hypot, pi

import numpy as np

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.logic.facts import value_of
from ntp_dsl.language.registry import Parameter, Program, Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.visitors import innermost, loops, walk
from ntp_dsl.semantics.geometry import Vector

Range = tuple[float, float]
Numbers = tuple[float, ...]
Ranges = Mapping[str, Range]  # by field
ANYWHERE: Mapping[str, Range] = {  # for a number that nothing bounds, by what it measures [SI]
    "length": (-0.6, 0.6),
    "angle": (-pi, pi),
}
ANY_NUMBER: Range = (0.0, 10.0)
MOST = 30_000  # combinations of numbers that are tried
STEPS = 49  # over its range, in which an amount is sought
FINE = 145  # and in which a length or an angle is
HALVINGS = 14


def ranges_of(registry: Registry, program: Program, parameter: Parameter) -> Ranges:
    """Return the ranges of the number fields of a list's elements: their own, or those of calls."""
    found: dict[str, Range] = {}
    for field in registry.records.get(parameter.type, ()):
        if not registry.is_number(field.type):
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
    holds: Callable[[Numbers], bool],
    limits: Sequence[Range],
    likely: Sequence[Sequence[float]],
    thorough: bool,
) -> Iterator[Numbers]:
    """Yield numbers for which something holds.

    Args:
        limits: of each number.
        likely: what is tried first for each.
        thorough: a grid over each range is tried where none of these fits.
    """
    most = int(MOST ** (1 / len(limits)))
    near = [
        list(dict.fromkeys(value for value in values if low <= value <= high))[:most]
        for values, (low, high) in zip(likely, limits, strict=True)
    ]
    found = False
    for values in filter(holds, product(*near)):
        found = True
        yield values
    if thorough and not found:
        steps = [max(2, min(FINE, most - len(each))) for each in near]
        grids = [np.linspace(*limit, count).tolist() for limit, count in zip(limits, steps, strict=True)]
        mixed = [[*each, *grid] for each, grid in zip(near, grids, strict=True)]
        yield from filter(holds, product(*mixed))


def cuts(values: Sequence[float]) -> list[float]:
    """Return numbers that tell values apart: these themselves, one between each two, one beyond each end."""
    known = sorted(set(values))
    if not known:
        return []
    between = [(a + b) / 2 for a, b in pairwise(known)]
    beyond = min((b - a for a, b in pairwise(known)), default=abs(known[0]) or 1.0) / 2
    return [*known, *between, known[0] - beyond, known[-1] + beyond]


def amounts(limits: Range, whole: bool) -> list[float]:
    """Return the whole numbers of a range, if those are asked for and there are few; else a grid over it."""
    low, high = limits
    if whole and ceil(low) <= high < ceil(low) + STEPS:
        return [float(each) for each in range(ceil(low), int(high) + 1)]
    return [float(each) for each in np.linspace(low, high, STEPS)]


def bearings(places: Sequence[Vector]) -> list[float]:
    """Return the directions from each place to each other, about the vertical from x [rad]."""
    found = [atan2(b[1] - a[1], b[0] - a[0]) for a, b in permutations(places, 2)]
    return list(dict.fromkeys(round(each, 4) for each in found))


def distances(places: Sequence[Vector]) -> list[float]:
    """Return the offsets and distances between places, each once [m]."""
    found: list[float] = []
    for a, b in combinations(places, 2):
        dx, dy, dz = (p - q for p, q in zip(a, b, strict=True))
        found += [dx, -dx, dy, -dy, dz, -dz, hypot(dx, dy), hypot(dx, dy, dz)]
    return list(dict.fromkeys(round(each, 4) for each in found))


def middle(hit: Numbers, limits: Sequence[Range | None], holds: Callable[[Numbers], bool]) -> Numbers:
    """Return the middle of what holds around a hit, along each axis in turn; along one without limits, none.

    It is sought beyond the ranges, too, so that it does not lie off where a range ends; where what holds has
    no edge there either, the hit is kept.
    """
    values = list(hit)
    for _ in range(2 if len(hit) > 1 else 1):
        for axis, limit in enumerate(limits):
            if limit is None:
                continue
            low, high = limit
            before, after = tuple(values[:axis]), tuple(values[axis + 1 :])
            at = partial(_with, holds, before, after)
            edges = [_edge(values[axis], way * (high - low), at) for way in (-1, 1)]
            if edges[0] is not None and edges[1] is not None:
                values[axis] = min(max(round((edges[0] + edges[1]) / 2, 5) + 0.0, low), high)  # no -0
    return tuple(values)


def _with(holds: Callable[[Numbers], bool], before: Numbers, after: Numbers, value: float) -> bool:
    with suppress(NtpError):  # a predicate in Python need not expect numbers beyond their range
        return holds((*before, value, *after))
    return False


def _edge(inside: float, span: float, at: Callable[[float], bool]) -> float | None:
    """Return where what holds ends on one side; None if it does not within the span."""
    step = span / 256
    outside = inside + step
    while at(outside):
        if abs(step) >= abs(span):
            return None
        inside, step = outside, 2 * step
        outside = inside + step
    for _ in range(HALVINGS):
        half = (inside + outside) / 2
        inside, outside = (half, outside) if at(half) else (inside, half)
    return inside
