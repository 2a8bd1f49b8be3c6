"""The key-program memory: a row per program, with a slot for each callee that its declaration names.

The core answers with a slot, never with a name. Keys of slots are fixed and orthonormal, so a program can
only call what it declares, and a new program cannot capture the calls of an old one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from graphlib import TopologicalSorter
from typing import Annotated, TypeVar

from msgspec import Meta

from ntp_dsl.language.registry import Callable, Parameter, Registry, bounds
from ntp_dsl.semantics.observation import Argument, Record

Given = TypeVar("Given")

# Bounds of what a file states.
Place = Annotated[int, Meta(ge=0, le=100)]  # among arguments
Number = Annotated[float, Meta(ge=-1e12, le=1e12)]
Few = Meta(max_length=100)
MAX_CALLEES = 1000
MAX_CELLS = 10**7  # of the largest table over rows, slots and values


@dataclass(frozen=True)
class Value:
    """An argument that is no object: a member of an enumeration, or a number of a range."""

    index: Place  # among all arguments that are no lists
    members: tuple[str, ...] = ()
    low: Number = 0.0
    high: Number = 1.0

    def scaled(self, number: float) -> float:
        """Where in its range a number lies, from 0 to 1."""
        return (number - self.low) / max(self.high - self.low, 1e-9)

    def number(self, scaled: float) -> float:
        """Return the inverse of `scaled`; what lies outside of the range is brought into it."""
        return self.low + min(max(scaled, 0.0), 1.0) * (self.high - self.low)


@dataclass(frozen=True)
class Packed:
    """A record among the arguments, of which the core gives each field."""

    index: Place  # of its first field, among all arguments that are no lists
    type: str
    fields: tuple[str, ...]


@dataclass(frozen=True)
class Signature:
    """What the arguments are, by their types; lists are not among them, and records are their fields."""

    name: str
    hash: str
    object_types: Annotated[tuple[str, ...], Few]  # of those that point at objects
    values: Annotated[tuple[Value, ...], Few] = ()  # the others
    records: Annotated[tuple[Packed, ...], Few] = ()

    def __post_init__(self) -> None:
        count = len(self.object_types) + len(self.values)
        places = [value.index for value in self.values]
        ends = [record.index + len(record.fields) for record in self.records]
        if places != sorted({*places}) or max([*places, -1]) >= count or max([*ends, 0]) > count:
            raise ValueError(f"the arguments of '{self.name}' do not follow one another")

    def split(self, arguments: Sequence[str | float]) -> tuple[tuple[str, ...], tuple[str | float, ...]]:
        """Return the objects among the arguments, and the values, each in their order."""
        places = {value.index for value in self.values}
        objects = tuple(str(a) for n, a in enumerate(arguments) if n not in places)
        return objects, tuple(a for n, a in enumerate(arguments) if n in places)

    def join(self, objects: Sequence[Given], values: Sequence[Given]) -> tuple[Given, ...]:
        """Return what was split as one, in the order of the arguments."""
        arguments: list[Given] = list(objects)
        for value, given in zip(self.values, values, strict=True):
            arguments.insert(value.index, given)
        return tuple(arguments)

    def packed(self, arguments: Sequence[str | float]) -> tuple[Argument, ...]:
        """Return the arguments of a call, the fields of each record put together."""
        given: list[Argument] = list(arguments)
        for record in reversed(self.records):
            end = record.index + len(record.fields)
            fields = zip(record.fields, arguments[record.index : end], strict=True)
            given[record.index : end] = [Record(record.type, tuple(fields))]
        return tuple(given)


@dataclass(frozen=True)
class Row:
    """A program's row: its signature and the callees of its slots."""

    signature: Signature
    callees: Annotated[tuple[str, ...], Meta(max_length=MAX_CALLEES)]


@dataclass(frozen=True)
class Memory:
    """What a core was trained over. It travels in the checkpoint.

    Raises `ValueError` where it refers to undeclared names, and where a type is its own ancestor.
    """

    library: str
    registry_hash: str
    types: Annotated[tuple[str, ...], Meta(min_length=1)]
    parents: tuple[tuple[str, str | None], ...]
    rows: Annotated[tuple[Row, ...], Meta(min_length=1)]
    apis: tuple[Signature, ...]

    def __post_init__(self) -> None:
        TopologicalSorter({name: (parent,) for name, parent in self.parents}).prepare()
        used = {name for signature in self.signatures() for name in signature.object_types}
        called = {name for row in self.rows for name in row.callees}
        missing = (used - {*self.types}) | (called - {signature.name for signature in self.signatures()})
        if missing:
            raise ValueError(f"'{min(missing)}' is not declared")
        if self.rows and not self.slots:
            raise ValueError("no program calls anything")
        if self.rows and len(self.rows) * self.slots * (1 + self.value_arity) > MAX_CELLS:
            raise ValueError("there are too many programs, callees and values")

    @classmethod
    def of(cls, registry: Registry) -> Memory:
        programs = sorted(registry.programs.values(), key=lambda program: program.name)
        rows = tuple(Row(signature(registry, program), program.callees) for program in programs)
        apis = sorted(registry.apis.values(), key=lambda api: api.name)
        return cls(
            registry.name,
            registry.hash,
            tuple(registry.parents),
            tuple(registry.parents.items()),
            rows,
            tuple(signature(registry, api) for api in apis),
        )

    @cached_property
    def slots(self) -> int:
        return max(len(row.callees) for row in self.rows)

    @cached_property
    def arity(self) -> int:
        return max(1, *(len(s.object_types) for s in self.signatures()))

    @cached_property
    def value_arity(self) -> int:
        """The most values that a call takes."""
        return max(len(s.values) for s in self.signatures())

    @cached_property
    def choices(self) -> int:
        """The most members of an enumeration, and one for numbers: what a value's head yields."""
        members = (len(v.members) for s in self.signatures() for v in s.values)
        return 1 + max(members, default=0)

    def signatures(self) -> Iterable[Signature]:
        yield from (row.signature for row in self.rows)
        yield from self.apis

    def index(self, program: str) -> int:
        return self._places[program]

    def row(self, program: str) -> Row:
        return self.rows[self.index(program)]

    def signature(self, name: str) -> Signature:
        return self._by_name[name]

    def takes(self, type_name: str, declared: str) -> bool:
        """Whether a thing of a type may stand where another type is declared."""
        return declared in self.lineage[type_name]

    @cached_property
    def lineage(self) -> dict[str, tuple[str, ...]]:
        """Each type with its ancestors, itself first."""
        parents = dict(self.parents)
        found = {}
        for name in self.types:
            chain = [name]
            while parent := parents.get(chain[-1]):
                chain.append(parent)
            found[name] = tuple(chain)
        return found

    @cached_property
    def _places(self) -> dict[str, int]:
        return {row.signature.name: index for index, row in enumerate(self.rows)}

    @cached_property
    def _by_name(self) -> dict[str, Signature]:
        return {signature.name: signature for signature in self.signatures()}


def signature(registry: Registry, row: Callable) -> Signature:
    """Choose the output head of each argument by its type: a pointer, a choice, or a number."""
    object_types: list[str] = []
    values: list[Value] = []
    records: list[Packed] = []
    given: list[Parameter] = []
    for parameter in row.parameters:
        fields = () if parameter.is_list else registry.records.get(parameter.type, ())
        if fields:
            records.append(Packed(len(given), parameter.type, tuple(field.name for field in fields)))
            given += fields
        elif not parameter.is_list:
            given.append(parameter)
    for place, parameter in enumerate(given):
        if parameter.type in registry.parents:
            object_types.append(parameter.type)
        elif parameter.type in registry.enums:
            values.append(Value(place, registry.enums[parameter.type]))
        else:
            values.append(Value(place, (), *bounds(parameter)))
    return Signature(row.name, row.hash, tuple(object_types), tuple(values), tuple(records))
