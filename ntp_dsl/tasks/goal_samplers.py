"""How a task draws its goals: a length, a topology and a semantics, each of which can be held to a range.

See `ntp_dsl.language.names.samplers` for the checker's part.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from typing import SupportsFloat

import numpy as np

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.names.samplers import SAMPLERS as KINDS
from ntp_dsl.language.names.samplers import VARIED
from ntp_dsl.language.registry import Parameter, Registry, place_of
from ntp_dsl.language.syntax.nodes import Option, Sampler
from ntp_dsl.semantics.observation import Record
from ntp_dsl.semantics.value_checks import Types, misfit, plain, strays
from ntp_dsl.worlds.scenes import Layout

Goal = tuple[Record, ...]
Variation = Mapping[str, tuple[int, int]]  # length, topology, semantics -> range
Pair = tuple[str, str]
TOPOLOGY, SEMANTICS = 1, 2  # tell the choices of one index apart
STARTS = "starts"  # the parameter by which a function is told what each object starts on


class NoGoal(NtpError):
    """The scene can be made, and no goal can be drawn from it."""


@dataclass(frozen=True)
class Draw:
    """A sampler's input: the names in each of its sources, its parameters, and three random generators."""

    sources: tuple[Sequence[str], ...]
    options: Mapping[str, Option]
    rng: np.random.Generator  # of the length
    topology: np.random.Generator
    semantics: np.random.Generator
    topology_index: int | None = None

    def between(self, name: str, low: int, high: int) -> tuple[int, int]:
        """Return the range of a parameter, by default its widest."""
        option = self.options.get(name)
        return (option.low, option.high) if option else (low, high)


def draw_goal(
    registry: Registry,
    sampler: Sampler,
    laid: Layout,
    rng: np.random.Generator,
    varied: Variation | None = None,
) -> Goal:
    """Return a goal as the task declares it, over the objects of a layout.

    Args:
        varied: ranges for `length`, `topology` and `semantics` in place of the declared ones.

    Raises `NoGoal`.
    """
    try:
        return _draw_goal(registry, sampler, laid, rng, varied)
    except NtpError as error:
        raise NoGoal(str(error)) from error


def _draw_goal(
    registry: Registry,
    sampler: Sampler,
    laid: Layout,
    rng: np.random.Generator,
    varied: Variation | None,
) -> Goal:
    groups = laid.groups
    options = _options(sampler, varied or {})
    sources = tuple(groups[name] if name in groups else registry.enums[name] for name in sampler.groups)
    draw = _draw(sources, options, rng)
    if sampler.by is not None:
        return _by_function(registry, sampler, draw, laid)
    kind = KINDS[sampler.name]
    for parameter, flaw, _ in kind.flaws(options, [len(source) for source in sources]):
        raise NtpError(f"{sampler.name}: {parameter}: {flaw}")
    pairs = SAMPLERS[sampler.name](draw)
    record = sampler.result.name if sampler.result else kind.record
    first, second = (field.name for field in registry.records[record])
    return tuple(Record(record, ((first, a), (second, b))) for a, b in pairs)


def _options(sampler: Sampler, varied: Variation) -> dict[str, Option]:
    options = {option.name: option for option in sampler.options}
    for name, (low, high) in varied.items():
        if name == "length":
            name = KINDS[sampler.name].length if sampler.by is None else name
        options[name] = Option(name, low, high)
    return options


def _draw(
    sources: tuple[Sequence[str], ...], options: Mapping[str, Option], rng: np.random.Generator
) -> Draw:
    """Draw the choices; one that is held to a range depends on an index of that range alone."""
    indices = {
        name: int(rng.integers(options[name].low, options[name].high + 1))
        for name in VARIED
        if name in options
    }
    topology, semantics = (
        np.random.default_rng((kind, indices[name])) if name in indices else rng
        for kind, name in ((TOPOLOGY, "topology"), (SEMANTICS, "semantics"))
    )
    return Draw(sources, options, rng, topology, semantics, indices.get("topology"))


def _by_function(registry: Registry, sampler: Sampler, draw: Draw, laid: Layout) -> Goal:
    """Draw a goal by a function of a generator, the sources, and the parameters as drawn numbers, by name.

    Where it takes `topology` or `semantics`, each is a generator for choices of that kind; `starts` is what
    each object starts on, by name.
    """
    assert sampler.result is not None
    types = dict(registry.constants) | {obj.name: obj.type for obj in laid.objects}
    function = registry.python.get("sampler", sampler.name)
    where = f"{place_of(function)}: the sampler '{sampler.name}'"
    takes = signature(function).parameters
    parameters: dict[str, int | np.random.Generator | dict[str, str]] = {}
    for name, option in draw.options.items():
        if name not in takes:
            raise NtpError(f"{where} has no '{name}'; its function takes {', '.join(takes)}")
        if name not in VARIED:
            parameters[name] = int(draw.rng.integers(option.low, option.high + 1))
    chances = {"topology": draw.topology, "semantics": draw.semantics}
    parameters |= {name: chances[name] for name in VARIED if name in takes}
    if STARTS in takes and STARTS not in draw.options:
        parameters[STARTS] = {name: start.surface for name, start in laid.starts.items()}
    rows = function(draw.rng, *draw.sources, **parameters)
    fields = registry.records[sampler.result.name]
    goal = []
    for row in rows:
        values = None if isinstance(row, str | Mapping) or not isinstance(row, Iterable) else tuple(row)
        if values is None or len(values) != len(fields):
            expected = ", ".join(field.name for field in fields) + ("," if len(fields) == 1 else "")
            found = plain(row) if values is None else tuple(map(plain, values))
            raise NtpError(f"{where} yields rows of ({expected}); found {found!r}")
        entries = (
            (field.name, _entry(registry, where, field, value, types))
            for field, value in zip(fields, values, strict=True)
        )
        goal.append(Record(sampler.result.name, tuple(entries)))
    if not goal:
        raise NtpError(f"{where} drew an empty goal; draw at least one element")
    asked = parameters.get("length")
    if isinstance(asked, int) and len(goal) < asked:
        raise NtpError(
            f"{where} was asked for length={asked}, and drew {len(goal)} elements; ask for less, or let the "
            f"scene have more to draw from"
        )
    return tuple(goal)


def _entry(registry: Registry, where: str, field: Parameter, value: object, types: Types) -> str | float:
    """Return a field's drawn value: a number, a member of its enumeration, or an object of the scene."""
    if isinstance(value, SupportsFloat) and not isinstance(value, str):
        value = float(value)
    expected = misfit(registry, field, value, types) or strays(field, value)
    if expected:
        shown = f"{value:g}" if isinstance(value, float) else repr(plain(value))
        raise NtpError(f"{where} drew {shown} for '{field.name}: {field.type}'; expected {expected}")
    assert isinstance(value, str | float)
    return value if isinstance(value, float) else str(value)


# The samplers -----------------------------------------------------------------------------------


def towers(draw: Draw) -> list[Pair]:
    """Draw towers of a number of placements and a greatest height, listed from the bottom up."""
    names = [name for source in draw.sources for name in source]
    low, high = draw.between("height", 2, 4)
    fewest, most = draw.between("placements", 1, len(names) - 1)
    placements = int(draw.rng.choice(_possible(len(names), fewest, most, low, high)))
    heights = _heights(len(names), placements, low, high, draw)
    shuffled = [names[index] for index in draw.semantics.permutation(len(names))]
    goal: list[Pair] = []
    for height in heights:
        tower, shuffled = shuffled[:height], shuffled[height:]
        goal += [(item, support) for support, item in zip(tower, tower[1:], strict=False)]
    return goal


def _possible(objects: int, fewest: int, most: int, low: int, high: int) -> list[int]:
    counts = [n for n in range(fewest, most + 1) if _partitions(objects, n, low, high)]
    if not counts:
        raise NtpError(
            f"no goal has {fewest}..{most} placements in towers of {low}..{high} out of {objects} objects"
        )
    return counts


def _heights(objects: int, placements: int, low: int, high: int, draw: Draw) -> list[int]:
    partitions = _partitions(objects, placements, low, high)
    if draw.topology_index is not None:  # other indices are other towers, as long as there are any
        chosen = list(partitions[draw.topology_index % len(partitions)])
    else:
        chosen = list(partitions[int(draw.topology.integers(len(partitions)))])
    return [chosen[index] for index in draw.topology.permutation(len(chosen))]


def _partitions(objects: int, placements: int, low: int, high: int) -> list[tuple[int, ...]]:
    """Return the tower heights with that many placements and enough objects, the tallest in low..high."""

    def split(left: int, cap: int) -> list[tuple[int, ...]]:
        if left == 0:
            return [()]
        return [
            (first + 1, *rest)
            for first in range(min(left, cap), 0, -1)
            for rest in split(left - first, first)
        ]

    fits = (p for p in split(placements, high - 1) if sum(p) <= objects)
    return [partition for partition in fits if max(partition) >= low]


def matchings(draw: Draw) -> list[Pair]:
    """Draw some of the items, each with a support; at most `each` of them share one."""
    items, supports = draw.sources
    fewest, most = draw.between("pairs", 1, len(items))
    pairs = int(draw.rng.integers(fewest, min(most, len(items)) + 1))
    _, each = draw.between("each", 1, len(items))
    slots: list[int] = []
    for _ in range(pairs):
        free = [n for n in range(len(supports)) if slots.count(n) < each]
        slots.append(free[int(draw.topology.integers(len(free)))])
    chosen = [items[index] for index in draw.semantics.permutation(len(items))[:pairs]]
    order = [supports[index] for index in draw.semantics.permutation(len(supports))]
    return [(item, order[slot]) for item, slot in zip(chosen, slots, strict=True)]


def permutations(draw: Draw) -> list[Pair]:
    """Draw the items (or `length` of them), each on a place of its own."""
    items, places = draw.sources
    fewest, most = draw.between("length", len(items), len(items))
    length = int(draw.rng.integers(fewest, min(most, len(items), len(places)) + 1))
    order = [places[index] for index in draw.topology.permutation(len(places))[:length]]
    chosen = [items[index] for index in draw.semantics.permutation(len(items))[:length]]
    return list(zip(chosen, order, strict=True))


SAMPLERS: Mapping[str, Callable[[Draw], list[Pair]]] = {
    "towers": towers,
    "matchings": matchings,
    "permutations": permutations,
}
