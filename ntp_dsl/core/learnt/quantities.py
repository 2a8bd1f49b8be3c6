"""What can be said of a call in numbers: where its objects lie, how large they are, what is read of them."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import combinations
from math import dist, hypot
from typing import TYPE_CHECKING

from msgspec import Struct

from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.policies.expert import NextCall
from ntp_dsl.semantics.facts import Literal
from ntp_dsl.semantics.predicates import MissingTrait

if TYPE_CHECKING:  # which brings torch, and whoever only reads a row needs none
    from ntp_dsl.core.perception.perceived import Believed

DISTANCE = "distance"
ALONE = 1.0  # [m] from the nearest movable object, where there is no other

Placed = tuple[str, str]  # a parameter, and the object in its place


class Quantity(Struct, frozen=True, order=True):
    """What a number says of a call: of its statement, of a parameter's object, or of two of them."""

    what: str = ""  # an axis, an extent, a distance, or a predicate's name
    of: tuple[str, ...] = ()  # parameters of the callee
    member: str = ""  # of an enumeration: the number is 1 where that is read
    is_declared: bool = False  # `what` is a predicate or a reading of the library

    def __str__(self) -> str:
        asked = f" is {self.member}" if self.member else ""
        if self.is_declared:
            return f"{self.what}({', '.join(self.of)}){asked}"
        if not self.what or not self.of:
            return f"{self.what}{', '.join(self.of)}{asked}"
        owner, *other = self.of
        if self.what == DISTANCE:
            return f"distance of {owner} from {other[0]}"
        own = f"{owner} {self.what}" if " " in self.what else f"{owner}.{self.what}"
        return f"{own} from {other[0]}" if other else own


Number = tuple[Quantity, float, bool]  # whether it is a measure, which may be squared, and no truth value


def quantities(
    call: NextCall, statement: int, state: Believed, wanted: Collection[Quantity] | None = None
) -> Iterator[Number]:
    """Yield the numbers of a call, lengths in metres.

    Args:
        statement: of the body, which makes the call.
        wanted: the only ones that are worked out; all where it is None.
    """
    yield Quantity(f"statement {statement}"), 1.0, False
    seen, callee = state.observation, state.registry[call.callee]
    placed: list[Placed] = []
    for parameter, value in zip(callee.parameters, call.arguments, strict=True):
        if isinstance(value, float | int):
            yield Quantity(of=(parameter.name,)), float(value), True
        elif isinstance(value, str) and value in seen.positions:
            placed.append((parameter.name, value))
        elif isinstance(value, str):
            yield Quantity(of=(parameter.name,), member=value), 1.0, False
    for each in placed:
        yield from _of_one(*each, state)
        yield from _declared((each,), state, wanted)
    for one, other in combinations(placed, 2):
        if one[1] != other[1]:
            yield from _of_two(one, other, state)
            yield from _declared((one, other), state, wanted)
            yield from _declared((other, one), state, wanted)


def _of_one(name: str, item: str, state: Believed) -> Iterator[Number]:
    seen, of = state.observation, (name,)
    place = seen.positions[item]
    for axis, value in zip("xyz", place, strict=True):
        yield Quantity(axis, of), value, True
    for extent, value in zip(("length", "width", "height"), seen.by_name[item].size, strict=True):
        yield Quantity(extent, of), value, True
    yield Quantity("from the hand", of), hypot(place[0] - seen.gripper[0], place[1] - seen.gripper[1]), True
    movable = [each.name for each in seen.objects if each.movable and each.name in seen.positions]
    others = [dist(place, seen.positions[other]) for other in movable if other != item]
    yield Quantity("from the nearest", of), min(others, default=ALONE), True


def _of_two(one: Placed, other: Placed, state: Believed) -> Iterator[Number]:
    of = one[0], other[0]
    at, to = state.observation.positions[one[1]], state.observation.positions[other[1]]
    yield Quantity(DISTANCE, of), hypot(at[0] - to[0], at[1] - to[1]), True
    for axis, value in zip("xyz", (x - y for x, y in zip(at, to, strict=True)), strict=True):
        yield Quantity(axis, of), value, True


def _declared(
    placed: tuple[Placed, ...], state: Believed, wanted: Collection[Quantity] | None
) -> Iterator[Number]:
    """Yield what the library's predicates and readings say of objects; nothing of traits that they lack."""
    of, items = tuple(name for name, _ in placed), tuple(item for _, item in placed)
    asked = None if wanted is None else {each.what for each in wanted if each.is_declared and each.of == of}
    for declared in state.registry.predicates.values():
        is_asked = asked is None or declared.name in asked
        if not is_asked or not _fits(state.registry, declared, items, state):
            continue
        quantity = Quantity(declared.name, of, is_declared=True)
        try:
            if declared.result is None:
                yield quantity, float(state.probability(Literal(declared.name, items))), False
                continue
            value = state.reading(declared.name, items)
        except MissingTrait:
            continue
        if isinstance(value, str):
            yield Quantity(declared.name, of, value, is_declared=True), 1.0, False
        else:
            yield quantity, float(value), True


def _fits(
    registry: Registry, declared: nodes.PredicateDeclaration, items: tuple[str, ...], state: Believed
) -> bool:
    if len(declared.parameters) != len(items):
        return False
    kinds = [state.observation.by_name[item].type for item in items]
    wanted = [each.type.name for each in declared.parameters]
    pairs = zip(kinds, wanted, strict=True)
    return all(want in registry.parents and registry.is_a(kind, want) for kind, want in pairs)
