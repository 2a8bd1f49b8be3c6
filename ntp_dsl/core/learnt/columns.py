"""What can be said of a call in numbers: where its objects lie, how large they are, what is read of them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from math import dist, hypot, log
from typing import TYPE_CHECKING, Any

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.policies.expert import NextCall
from ntp_dsl.semantics.facts import Literal

if TYPE_CHECKING:  # which brings torch
    from ntp_dsl.core.perception.perceived import Believed

Columns = dict[str, float]
Named = tuple[str, str]  # a parameter and the object in its place


def columns_of(call: NextCall, statement: int, state: Believed) -> Columns:
    """Return the numbers of a call, by what they say.

    Of a number there is also its square and, if it is positive, its logarithm: sums of these are weighted
    scores, ratios, and distances from a best value.
    """
    found: Columns = {f"statement {statement}": 1.0}
    for name, value in _plain(call, state):
        found[name] = value
        found[f"{name} squared"] = value * value
        if value > 0:
            found[f"log {name}"] = log(value)
    return found


def _plain(call: NextCall, state: Believed) -> Iterator[tuple[str, float]]:
    seen, callee = state.observation, state.registry[call.callee]
    objects: list[Named] = []
    for parameter, value in zip(callee.parameters, call.arguments, strict=True):
        if isinstance(value, float | int):
            yield parameter.name, float(value)
        elif isinstance(value, str) and value in seen.positions:
            objects.append((parameter.name, value))
        elif isinstance(value, str):
            yield f"{parameter.name} is {value}", 1.0
    for each in objects:
        yield from _of_one(*each, state)
    for one, other in combinations(objects, 2):
        yield from _of_two(one, other, state)


def _of_one(name: str, item: str, state: Believed) -> Iterator[tuple[str, float]]:
    seen = state.observation
    place = seen.positions[item]
    for axis, value in zip("xyz", place, strict=True):
        yield f"{name}.{axis}", value
    for axis, value in zip(("length", "width", "height"), seen.by_name[item].size, strict=True):
        yield f"{name}.{axis}", value
    yield f"{name} from the hand", hypot(place[0] - seen.gripper[0], place[1] - seen.gripper[1])
    others = [
        dist(place, at) for other, at in seen.positions.items() if other != item and _is_small(other, state)
    ]
    yield f"{name} from the nearest", min(others, default=1.0)
    yield from _declared((name,), (item,), state)


def _is_small(name: str, state: Believed) -> bool:
    return state.observation.by_name[name].movable


def _of_two(one: Named, other: Named, state: Believed) -> Iterator[tuple[str, float]]:
    (first, a), (second, b) = one, other
    if a == b:
        return
    at, to = state.observation.positions[a], state.observation.positions[b]
    yield f"{first} from {second}", hypot(at[0] - to[0], at[1] - to[1])
    for axis, value in zip("xyz", (x - y for x, y in zip(at, to, strict=True)), strict=True):
        yield f"{first}.{axis} from {second}", value
    yield from _declared((first, second), (a, b), state)
    yield from _declared((second, first), (b, a), state)


def _declared(names: tuple[str, ...], items: tuple[str, ...], state: Believed) -> Iterator[tuple[str, float]]:
    """Yield what the library's predicates and readings say of objects."""
    for declared in state.registry.predicates.values():
        if not _fits(state.registry, declared, items, state):
            continue
        said = f"{declared.name}({', '.join(names)})"
        if declared.result is None:
            yield said, float(state.probability(Literal(declared.name, items)))
            continue
        value = _reading(declared, items, state)
        if isinstance(value, str):
            yield f"{said} is {value}", 1.0
        elif value is not None:
            yield said, float(value)


def _reading(declared: nodes.PredicateDeclaration, items: tuple[str, ...], state: Believed) -> Any:
    try:
        return state.reading(declared.name, items)
    except NtpError:  # the scene gives it no such trait
        return None


def _fits(
    registry: Registry, declared: nodes.PredicateDeclaration, items: tuple[str, ...], state: Believed
) -> bool:
    if len(declared.parameters) != len(items):
        return False
    kinds = [state.observation.by_name[item].type for item in items]
    wanted = [each.type.name for each in declared.parameters]
    pairs = zip(kinds, wanted, strict=True)
    return all(want in registry.parents and registry.is_a(kind, want) for kind, want in pairs)
