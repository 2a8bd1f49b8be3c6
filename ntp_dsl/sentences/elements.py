"""Elements of lists from which something that was said follows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import product
from math import prod

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Parameter, Program, Registry
from ntp_dsl.semantics.facts import Fact
from ntp_dsl.semantics.observation import Argument, Observation, Record
from ntp_dsl.semantics.state import State
from ntp_dsl.sentences.consequences import Said, consequences, element_said

Element = Record | str
Placed = tuple[str, Element]  # a list parameter's name, and an element of that list
MOST_ELEMENTS = 3000  # that are tried for one thing that was said


class Elements:
    """The elements that a program's lists may have in a scene.

    Args:
        given: the program's arguments; what its lists hold does not count.
        types: of objects and constants by name.
    """

    def __init__(
        self,
        registry: Registry,
        program: Program,
        given: Sequence[Argument],
        seen: Observation,
        types: Mapping[str, str],
    ) -> None:
        self.registry, self.program, self.types, self.seen = registry, program, types, seen
        self._given = tuple(() if isinstance(each, tuple) else each for each in given)
        self._state = State(registry, seen)
        self._consequences: dict[Placed, frozenset[Said]] = {}
        self._offered: dict[Said, list[Placed]] = {}
        self._mentioned: list[str] = []

    def may_be_about(self, names: Iterable[str]) -> None:
        """Let objects and members fill what a sentence leaves open."""
        self._mentioned = list(dict.fromkeys(names))
        self._offered.clear()

    @property
    def lists(self) -> list[Parameter]:
        """Return the program's list parameters."""
        return [each for each in self.program.parameters if each.is_list]

    def saying(self, said: Said) -> list[Placed]:
        """Return the elements from which something that was said follows."""
        if said in self._offered:
            return self._offered[said]
        found = []
        for parameter in self.lists:
            for wide, twice in ((False, False), (True, False), (True, True)):
                elements = [
                    (parameter.name, each)
                    for each in self._candidates(parameter, said, wide)
                    if (twice or not _names_twice(each)) and not _overuses_numbers(each, said)
                    if any(said.covers(other) for other in self._following(parameter, each))
                ]
                if elements:
                    found += elements
                    break
        found = list(dict.fromkeys(found))
        self._offered[said] = found
        return found

    def names_all(self, placed: Placed, said: Said) -> bool:
        """Return whether an element has all objects that were named and that a field of it would take."""
        parameter = next(each for each in self.lists if each.name == placed[0])
        fields = self.registry.records.get(parameter.type, (Parameter(parameter.name, parameter.type),))
        others = {*said.arguments} - {*values_of(placed[1])}
        return not any(self._is_a(each, field.type) for each in others for field in fields)

    def mean_the_same(self, one: Placed, other: Placed) -> bool:
        """Return whether two elements name the same things, and the program achieves the same by both."""
        if one == other:
            return True
        names = [sorted(map(str, values_of(each))) for _, each in (one, other)]
        if one[0] != other[0] or names[0] != names[1]:
            return False
        achieved = [{*self._achieved(each)} for each in (one, other)]
        return bool(achieved[0]) and achieved[0] == achieved[1]

    def _achieved(self, placed: Placed) -> list[Fact]:
        given = self.called_with({placed[0]: (placed[1],)})
        return self._state.literals(self.program.achieves, self.program.bind(given))

    def go_without_saying(self, said: Said) -> bool:
        """Return whether something follows from the program's call, whatever its lists hold."""
        return any(said.covers(each) for each in self._without_elements)

    def _following(self, parameter: Parameter, element: Element) -> frozenset[Said]:
        """Return what follows from an element, and not without it."""
        key = parameter.name, element
        if key not in self._consequences:
            own = self.called_with({parameter.name: (element,)})
            found = consequences(self._state, self.program, own) - self._without_elements
            found.add(element_said(parameter.name, values_of(element)))
            self._consequences[key] = frozenset(found)
        return self._consequences[key]

    @cached_property
    def _without_elements(self) -> frozenset[Said]:
        return frozenset(consequences(self._state, self.program, self.called_with({})))

    def called_with(self, lists: Mapping[str, tuple[Element, ...]]) -> tuple[Argument, ...]:
        pairs = zip(self.program.parameters, self._given, strict=True)
        return tuple(lists.get(each.name, ()) if each.is_list else value for each, value in pairs)

    def _candidates(self, parameter: Parameter, said: Said, wide: bool) -> Iterator[Element]:
        """Yield elements of a list, of what was said; of all that is mentioned where that is not enough."""
        fields = self.registry.records.get(parameter.type)
        if fields is None:
            own = Parameter(parameter.name, parameter.type)
            yield from (str(value) for value in self._values(own, said, wide))
            return
        pools = [self._values(each, said, wide) for each in fields]
        if prod(map(len, pools)) > MOST_ELEMENTS:
            raise NtpError(
                f"more than {MOST_ELEMENTS} elements of '{parameter.name}' may be meant: name every object"
            )
        if all(pools):
            for values in product(*pools):
                names = [each.name for each in fields]
                yield Record(parameter.type, tuple(zip(names, values, strict=True)))

    def _values(self, wanted: Parameter, said: Said, wide: bool) -> list[str | float]:
        named = [each for each in said.arguments if isinstance(each, str | float)]
        if self.registry.is_number(wanted.type):
            return [each for each in named if isinstance(each, float)]
        if wanted.type in self.registry.enums:
            members = self.registry.enums[wanted.type]
            own: list[str | float] = [each for each in named if each in members]
            own = own or [*self.traits(named, members)]
            return own if own and not wide else [*members]
        own = [each for each in named if self._is_a(each, wanted.type)]
        if own and not wide:
            return list(dict.fromkeys(own))
        mentioned = [each for each in self._mentioned if self._is_a(each, wanted.type)]
        known = list(dict.fromkeys([*own, *mentioned]))
        return known if len(known) > len(own) else list(self._state.values(wanted.type))

    def traits(self, named: Iterable[str | float], members: Sequence[str]) -> list[str]:
        """Return the members of an enumeration that objects have as traits."""
        traits = {obj.name: [value for _, value in obj.traits] for obj in self.seen.objects}
        values = [value for each in named for value in traits.get(str(each), ())]
        return list(dict.fromkeys(str(value) for value in values if value in members))

    def _is_a(self, name: object, kind: str) -> bool:
        return isinstance(name, str) and name in self.types and self.registry.is_a(self.types[name], kind)


def _names_twice(element: Element) -> bool:
    """Return whether an element names an object or a member more than once."""
    names = [value for value in values_of(element) if isinstance(value, str)]
    return len({*names}) < len(names)


def _overuses_numbers(element: Element, said: Said) -> bool:
    """Return whether an element has a number in more fields than it was said for."""
    numbers = [value for value in values_of(element) if isinstance(value, float)]
    return any(numbers.count(each) > said.arguments.count(each) for each in {*numbers})


def values_of(element: Record | str) -> tuple[str | float, ...]:
    """Return the values of a list's element."""
    return tuple(value for _, value in element.fields) if isinstance(element, Record) else (element,)
