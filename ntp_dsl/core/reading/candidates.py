"""Which elements a list may have: those whose part of the contract comes true in what is shown."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

from ntp_dsl.core.reading.numbers import (
    ANY_NUMBER,
    ANYWHERE,
    Range,
    Ranges,
    amounts,
    bearings,
    cuts,
    distances,
    fitting_numbers,
    lines,
    middle,
)
from ntp_dsl.language.logic.list_contracts import conditions, parts_about, unfolded, unmentioned
from ntp_dsl.language.registry import Parameter, Program, Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.visitors import walk
from ntp_dsl.semantics.facts import Fact, Literal
from ntp_dsl.semantics.observation import Argument, Record, without_lists
from ntp_dsl.semantics.predicates import MissingTrait
from ntp_dsl.semantics.state import State

Element = Record | str
Bound = tuple[tuple[str, str | float], ...]
ANGLE = "angle"
NUMBER = "number"  # the type of what has no unit
COMMON = 0.3  # of the objects of a type


@dataclass(frozen=True)
class Candidate:
    """An element that a list may have, and the phase from which on its part of the contract holds."""

    parameter: str
    element: Element
    rise: int


class ListContract:
    """What a program's contract says of the elements of one of its lists.

    Args:
        scope: the program's other arguments.
        moved: objects that the hand moves: numbers are sought thoroughly for elements with one of these.
    """

    def __init__(
        self,
        registry: Registry,
        program: Program,
        parameter: Parameter,
        scope: Mapping[str, Argument],
        moved: Container[str],
    ) -> None:
        self.registry, self.parameter, self._scope, self._moved = registry, parameter, scope, moved
        self.parts = parts_about(parameter.name, program.achieves)
        declared = registry.records.get(parameter.type, (Parameter("", parameter.type),))
        self._declared = [field.name for field in declared]
        self.fields = sorted(declared, key=lambda field: registry.is_number(field.type))  # numbers last
        self._atoms = [found for part in self.parts for found in self._of_the_element(part)]
        self._is_taken_apart = all(map(self._can_be_taken_apart, self.parts))
        self._read = [*dict.fromkeys(name for part in self.parts for name in self._readings_in(part, set()))]
        said = conditions(self.parts, registry.predicates)
        self._lines = list(dict.fromkeys(each for condition in said for each in lines(condition)))

    @property
    def unmentioned(self) -> list[str]:
        """Return the fields of an element that the contract never mentions."""
        if not self._declared[0]:
            return []
        return unmentioned(self.parts, self.parameter.type, self._declared, self.registry.predicates)

    def holds(self, element: Element, state: State) -> bool:
        """Return whether all that the contract says of an element holds, and whether it says anything."""
        inner = {**self._scope, self.parameter.name: (element,)}
        with suppress(MissingTrait):  # which the scene gives to others only
            return all(state.true(part, inner) for part in self.parts) and self._says_something(inner, state)
        return False

    def _says_something(self, scope: Mapping[str, Argument], state: State) -> bool:
        return any(state.literals(part, scope) for part in self.parts)

    def facts(self, element: Element, state: State) -> list[Fact]:
        """Return what the contract says of an element."""
        scope = {**self._scope, self.parameter.name: (element,)}
        return [fact for part in self.parts for fact in state.literals(part, scope)]

    def is_common(self, element: Element, moved: str, state: State) -> bool:
        """Return whether much the same holds of many other objects: nothing brings it about there."""
        if not isinstance(element, Record):
            return False
        fields = {field.name: field for field in self.fields}
        others = [
            Record(
                element.type,
                tuple((name, other if value == moved else value) for name, value in element.fields),
            )
            for changed, value_of_it in element.fields
            if value_of_it == moved
            for other in state.objects(fields[changed].type)
            if other != moved
        ]
        true = sum(self.holds(each, state) for each in others)
        return bool(others) and true > COMMON * len(others)

    def elements(self, state: State, ranges: Ranges, thorough: bool) -> Iterator[Element]:
        """Yield the elements for which the contract holds in a state.

        Args:
            thorough: numbers are sought all over their ranges, where no distance between objects fits.
        """
        for bound in self._bindings(state, (), ranges, thorough):
            element = self._element(bound)
            if self.holds(element, state):
                yield element

    def _element(self, bound: Bound) -> Element:
        if self.parameter.type in self.registry.records:
            values = dict(bound)
            return Record(self.parameter.type, tuple((n, values[n]) for n in self._declared if n in values))
        return str(bound[0][1])

    def _bindings(self, state: State, bound: Bound, ranges: Ranges, thorough: bool) -> Iterator[Bound]:
        """Yield values for all fields, one field at a time: what the bound ones contradict is left out."""
        if len(bound) == len(self.fields):
            yield bound
            return
        field = self.fields[len(bound)]
        values = self._values(field, state)
        if values is None:
            yield from self._with_numbers(state, bound, ranges, thorough)
            return
        for value in values:
            longer = (*bound, (field.name, value))
            if self.agrees(longer, state, {field.name}):
                yield from self._bindings(state, longer, ranges, thorough)

    def _with_numbers(self, state: State, bound: Bound, ranges: Ranges, thorough: bool) -> Iterator[Bound]:
        """Yield the bound fields with numbers for all that are left, where there are any that fit."""
        left = [field for field in self.fields if field.name not in dict(bound)]
        if not left:
            yield bound
            return
        together = self._together(left)
        for values in self._numbers(together, state, bound, ranges, thorough):
            yield from self._with_numbers(state, (*bound, *values), ranges, thorough)

    def _together(self, numbers: Sequence[Parameter]) -> list[Parameter]:
        """Return some numbers that are to be sought together, as conditions name them; amounts come last."""
        if not self._is_taken_apart:
            return [*numbers]
        first = min(numbers, key=lambda field: field.type not in ANYWHERE)
        names, group = {field.name for field in numbers}, {first.name}
        while more := {n for *_, used in self._atoms if used & group for n in used & names} - group:
            group |= more
        return [field for field in numbers if field.name in group]

    def _numbers(
        self, fields: Sequence[Parameter], state: State, bound: Bound, ranges: Ranges, thorough: bool
    ) -> Iterator[Bound]:
        """Yield values for some fields with which all that is said of them and the bound ones holds."""
        names = [field.name for field in fields]

        def fits(values: tuple[float, ...]) -> bool:
            longer = (*bound, *zip(names, values, strict=True))
            if len(longer) == len(self.fields):
                return self.holds(self._element(longer), state)
            return self.agrees(longer, state, {*names})

        def said(values: tuple[float, ...]) -> frozenset[Fact]:
            return frozenset(self._said((*bound, *zip(names, values, strict=True)), state))

        limits = [ranges.get(field.name) or ANYWHERE.get(field.type, ANY_NUMBER) for field in fields]
        measured = [field.type in ANYWHERE for field in fields]
        moves = any(value in self._moved for _, value in bound if isinstance(value, str))
        likely = [
            self._likely(field, limit, state, bound) for field, limit in zip(fields, limits, strict=True)
        ]
        found: dict[frozenset[Fact], list[tuple[float, ...]]] = {}  # by what is said with them
        for values in fitting_numbers(fits, limits, likely, thorough and moves):
            facts = said(values)
            found.setdefault(facts, []).append(values)
            if all(measured) and any(map(_has_number, facts)):
                break  # with others, the same is said of another number
        around = [limit if is_measured else None for limit, is_measured in zip(limits, measured, strict=True)]
        for facts, hits in found.items():
            measures = any(map(_has_number, facts))
            same = fits if measures else lambda v, facts=facts: fits(v) and said(v) == facts
            yield tuple(zip(names, middle(hits[len(hits) // 2], around, same), strict=True))

    def _likely(self, field: Parameter, limits: Range, state: State, bound: Bound) -> list[float]:
        """Return the numbers that are tried first: with them, terms equal what the scene measures."""
        told = cuts(self._readings(field.type, state))
        if field.type not in ANYWHERE:
            return [*amounts(limits, whole=field.type == NUMBER), *told]
        positions = state.observation.positions
        places = [positions[value] for _, value in bound if isinstance(value, str) and value in positions]
        found = [*(bearings(places) if field.type == ANGLE else distances(places)), *told]
        return [(each - offset) / factor for factor, offset in self._lines for each in found]

    def _readings(self, kind: str, state: State) -> list[float]:
        """Return what the contract's readings of objects tell, of the kind of number that is asked for."""
        found: list[float] = []
        for name in self._read:
            declared = self.registry.predicates[name]
            if declared.result is None or declared.result.name != kind or len(declared.parameters) != 1:
                continue
            for item in state.objects(declared.parameters[0].type.name):
                with suppress(MissingTrait):
                    found.append(float(state.reading(name, (item,))))
        return found

    def _values(self, field: Parameter, state: State) -> Sequence[str] | None:
        if self.registry.is_number(field.type):
            return None
        return state.values(field.type)

    def agrees(self, bound: Bound, state: State, last: set[str]) -> bool:
        """Return whether the conditions that name a field bound last, and none that is not bound, hold."""
        element = self._element(bound)
        with suppress(MissingTrait):
            return all(
                state.true(atom, {**self._scope, variable: element})
                for variable, atom in self._about(bound, last)
            )
        return False

    def _said(self, bound: Bound, state: State) -> list[Fact]:
        """Return what the conditions that name bound fields only say."""
        if len(bound) == len(self.fields):
            return self.facts(self._element(bound), state)
        element = self._element(bound)
        return [
            fact
            for variable, atom in self._about(bound, {name for name, _ in bound})
            for fact in state.literals(atom, {**self._scope, variable: element})
        ]

    def _about(self, bound: Bound, some: set[str]) -> Iterator[tuple[str, nodes.Expression]]:
        names = {name for name, _ in bound}
        for variable, atom, used in self._atoms:
            if used & some and used <= names:
                yield variable, atom

    def _can_be_taken_apart(self, part: nodes.Expression) -> bool:
        """Return whether the conditions on an element's fields are all that a part says of it."""
        match part:
            case nodes.Quantified("all", body, (generator,)) if generator.condition is None:
                said = unfolded(body, self.registry.predicates)
                return all(self._fields_in(each, generator.variable) is not None for each in said)
        return False

    def _of_the_element(self, part: nodes.Expression) -> Iterator[tuple[str, nodes.Expression, set[str]]]:
        """Yield the conditions that every element must meet, each with its variable and fields."""
        match part:
            case nodes.Quantified("all", body, (generator,)) if generator.condition is None:
                if generator.iterable.id != self.parameter.name:
                    return
                for condition in unfolded(body, self.registry.predicates):
                    used = self._fields_in(condition, generator.variable)
                    if used is not None:
                        yield generator.variable, condition, used

    def _readings_in(self, expression: nodes.Expression, seen: set[str]) -> Iterator[str]:
        """Yield the predicates in an expression, and in the bodies of these, that tell a value."""
        for each in walk(expression):
            declared = self.registry.predicates.get(each.predicate) if isinstance(each, nodes.Atom) else None
            if declared is None or declared.name in seen:
                continue
            seen.add(declared.name)
            if declared.result is not None:
                yield declared.name
            elif declared.body is not None:
                yield from self._readings_in(declared.body, seen)

    def _fields_in(self, condition: nodes.Expression, variable: str) -> set[str] | None:
        """Return the fields of the element that a condition is about; None where it is about all of it."""
        if self.parameter.type not in self.registry.records:
            return {""} if nodes.Name(variable) in walk(condition) else None
        found = list(walk(condition))
        whole = sum(each == nodes.Name(variable) for each in found)
        fields = [each for each in found if isinstance(each, nodes.Field) and each.value.id == variable]
        return {each.name for each in fields} if whole == len(fields) else None


def _has_number(fact: Fact) -> bool:
    values = fact.arguments if isinstance(fact, Literal) else [value for _, value in fact.bindings]
    parts = [
        v for value in values for v in (without_lists((value,)) if isinstance(value, Record) else (value,))
    ]
    return any(isinstance(value, float) for value in parts)


def candidates(
    contract: ListContract,
    ends: Sequence[State],
    ranges: Ranges,
    thorough: bool,
) -> list[Candidate]:
    """Return the elements that hold in the last state, each with when it began to, in that order."""
    found = []
    for element in contract.elements(ends[-1], ranges, thorough):
        rise = len(ends) - 1
        while rise > 0 and contract.holds(element, ends[rise - 1]):
            rise -= 1
        found.append(Candidate(contract.parameter.name, element, rise))
    return sorted(found, key=lambda each: each.rise)
