"""The symbol table of a library: every declaration that it sees, by name."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeVar, cast

from ntp_dsl.language.diagnostics.checked import Checked
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, unknown
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import Declaration

UNITS: Mapping[str, tuple[str, float]] = {  # unit -> (what it measures, its size in SI)
    "m": ("length", 1.0),
    "cm": ("length", 0.01),
    "mm": ("length", 0.001),
    "rad": ("angle", 1.0),
    "deg": ("angle", 0.017453292519943295),
    "s": ("time", 1.0),
    "ms": ("time", 0.001),
    "N": ("force", 1.0),
    "kg": ("mass", 1.0),
}
NUMBER_TYPES = ("number", *dict.fromkeys(kind for kind, _ in UNITS.values()))


K = TypeVar("K")
V = TypeVar("V")
ALL_KEYS = "*"  # looked up by whoever iterates over a dictionary; no name is spelt so


class TrackedDict(dict[K, V]):
    """A dictionary that records what is looked up, so that it is known on what a result rests."""

    def __init__(self) -> None:
        super().__init__()
        self.looked_up: set[object] = set()

    def __getitem__(self, key: K) -> V:
        self.looked_up.add(key)
        return super().__getitem__(key)

    def __contains__(self, key: object) -> bool:
        self.looked_up.add(key)
        return super().__contains__(key)

    def get(self, key: K, default: Any = None) -> V | Any:
        self.looked_up.add(key)
        return super().get(key, default)

    def __iter__(self) -> Iterator[K]:
        self.looked_up.add(ALL_KEYS)
        return super().__iter__()

    def keys(self) -> Any:
        self.looked_up.add(ALL_KEYS)
        return super().keys()

    def values(self) -> Any:
        self.looked_up.add(ALL_KEYS)
        return super().values()

    def items(self) -> Any:
        self.looked_up.add(ALL_KEYS)
        return super().items()

    def peek(self, key: object) -> object:
        """Return what a look-up yields, without recording it."""
        return tuple(super().items()) if key == ALL_KEYS else super().get(cast(K, key))


@dataclass
class SymbolTable:
    """Every declaration by name, in the namespaces of the language.

    Programs and apis share one, and so do the kinds of type, and constants with enumerations'
    members. A predicate may be called like a program.
    """

    types: TrackedDict[str, nodes.TypeDeclaration] = field(default_factory=TrackedDict)
    enums: TrackedDict[str, nodes.EnumDeclaration] = field(default_factory=TrackedDict)
    records: TrackedDict[str, nodes.RecordDeclaration] = field(default_factory=TrackedDict)
    constants: TrackedDict[str, nodes.ConstantDeclaration] = field(default_factory=TrackedDict)
    predicates: TrackedDict[str, nodes.PredicateDeclaration] = field(default_factory=TrackedDict)
    apis: TrackedDict[str, nodes.ApiDeclaration] = field(default_factory=TrackedDict)
    programs: TrackedDict[str, nodes.ProgramDeclaration] = field(default_factory=TrackedDict)
    tasks: TrackedDict[str, nodes.TaskDeclaration] = field(default_factory=TrackedDict)
    members: TrackedDict[str, tuple[str, ...]] = field(default_factory=TrackedDict)  # -> their enumerations

    def dictionaries(self) -> tuple[TrackedDict[Any, Any], ...]:
        """Return all dictionaries in which names are looked up."""
        return (
            self.types, self.enums, self.records, self.constants, self.predicates, self.apis,
            self.programs, self.tasks, self.members,
        )  # fmt: skip

    def add(self, declaration: Declaration) -> None:
        """Add a declaration; the first one of a name stays."""
        getattr(self, KINDS[type(declaration)].field).setdefault(declaration.name, declaration)
        for member in declaration.members if isinstance(declaration, nodes.EnumDeclaration) else ():
            owners = self.members.get(member, ())
            self.members[member] = tuple(dict.fromkeys([*owners, declaration.name]))

    def select(self, is_chosen: Callable[[Declaration], bool]) -> SymbolTable:
        """Return a table of some of the declarations."""
        chosen = SymbolTable()
        for dictionary in self.dictionaries():
            for each in dictionary.values():
                if isinstance(each, Declaration) and is_chosen(each):
                    chosen.add(each)
        return chosen

    def callable(self, name: str) -> nodes.ApiDeclaration | nodes.ProgramDeclaration | None:
        return self.programs.get(name) or self.apis.get(name)

    def callables(self) -> list[nodes.ApiDeclaration | nodes.ProgramDeclaration]:
        return [*self.programs.values(), *self.apis.values()]

    def type_names(self) -> Collection[str]:
        """Return whatever may be a parameter's type."""
        return ChainMap[str, object](
            cast(dict[str, object], self.types),
            cast(dict[str, object], self.enums),
            cast(dict[str, object], self.records),
            dict.fromkeys(NUMBER_TYPES),
        )

    def is_a(self, name: str, ancestor: str) -> bool:
        """Return whether one type descends from another; True where that cannot be told."""
        ancestors = list(self.ancestors(name))
        if ancestor in ancestors:
            return True
        oldest = self.types.get(ancestors[-1])
        return ancestors[-1] not in self.type_names() if oldest is None else oldest.parent is not None

    def ancestors(self, name: str) -> Iterator[str]:
        """Yield the type itself, then its ancestors; a cycle is walked once."""
        seen: set[str] = set()
        current: str | None = name
        while current is not None and current not in seen:
            yield current
            seen.add(current)
            declared = self.types.get(current)
            current = declared.parent.name if declared and declared.parent else None

    def enum_of(self, member: str) -> Sequence[str]:
        """Return the enumerations that have such a member."""
        return self.members.get(member) or ()


class Kind(NamedTuple):
    """A kind of declaration: its field of the symbol table, its namespace, and its keyword."""

    field: str
    namespace: str
    keyword: str


KINDS: Mapping[type[Declaration], Kind] = {
    nodes.TypeDeclaration: Kind("types", "type", "type"),
    nodes.EnumDeclaration: Kind("enums", "type", "enum"),
    nodes.RecordDeclaration: Kind("records", "type", "record"),
    nodes.ConstantDeclaration: Kind("constants", "value", "constant"),
    nodes.PredicateDeclaration: Kind("predicates", "predicate", "predicate"),
    nodes.ApiDeclaration: Kind("apis", "call", "api"),
    nodes.ProgramDeclaration: Kind("programs", "call", "program"),
    nodes.TaskDeclaration: Kind("tasks", "task", "task"),
}


# Types of other languages, and what they are called here.
FOREIGN_TYPES = {
    "float": "number", "double": "number", "real": "number", "int": "number", "integer": "number",
    "num": "number", "scalar": "number", "distance": "length", "meters": "length", "metres": "length",
    "duration": "time", "seconds": "time", "degrees": "angle", "radians": "angle", "weight": "mass",
    "newton": "force", "string": "", "str": "", "bool": "", "boolean": "",
}  # fmt: skip
# Of these, any number type may be meant.
UNCERTAIN_TYPES = {"float", "double", "real", "int", "integer", "num", "scalar"}


def check_type(table: SymbolTable, name: nodes.TypeName) -> Checked[bool]:
    """Return whether the type exists."""
    if name.name in table.type_names():
        return True
    known = table.type_names()
    meant = FOREIGN_TYPES.get(name.name.lower())
    if meant is None and name.name in UNITS:
        meant = UNITS[name.name][0]
    if meant is None:
        yield unknown("E103", "there is no type", name.name, name.span, known)
        return False
    help = (
        "" if meant else "a predicate is a condition without a type, and words are members of an enumeration"
    )
    message = f"there is no type '{name.name}'" + (f"; did you mean '{meant}'?" if meant else "")
    certain = name.name.lower() not in UNCERTAIN_TYPES
    fix = Fix(name.span, meant, certain=certain) if meant else None
    yield Diagnostic("E103", message, name.span, (), help, fix, name.name)
    return False
