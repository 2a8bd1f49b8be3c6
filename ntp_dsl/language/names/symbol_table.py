"""The symbol table of a library: every declaration that it sees, by name."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar, cast

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
EVERYTHING = "*"  # asked for by whoever goes through a whole dictionary; no name is spelt so


class Watched(dict[K, V]):
    """A dictionary that notes what was asked for, so that an answer's grounds are known."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: set[object] = set()

    def __getitem__(self, key: K) -> V:
        self.asked.add(key)
        return super().__getitem__(key)

    def __contains__(self, key: object) -> bool:
        self.asked.add(key)
        return super().__contains__(key)

    def get(self, key: K, default: Any = None) -> V | Any:
        self.asked.add(key)
        return super().get(key, default)

    def __iter__(self) -> Iterator[K]:
        self.asked.add(EVERYTHING)
        return super().__iter__()

    def keys(self) -> Any:
        self.asked.add(EVERYTHING)
        return super().keys()

    def values(self) -> Any:
        self.asked.add(EVERYTHING)
        return super().values()

    def items(self) -> Any:
        self.asked.add(EVERYTHING)
        return super().items()

    def answer(self, key: object) -> object:
        """What asking would yield, unnoted."""
        return tuple(super().items()) if key == EVERYTHING else super().get(cast(K, key))


@dataclass
class SymbolTable:
    """Every declaration by name, in the namespaces of the language.

    Programs and apis share one, and so do the kinds of type, and constants with enumerations'
    members. A predicate may be called like a program.
    """

    types: Watched[str, nodes.TypeDeclaration] = field(default_factory=Watched)
    enums: Watched[str, nodes.EnumDeclaration] = field(default_factory=Watched)
    records: Watched[str, nodes.RecordDeclaration] = field(default_factory=Watched)
    constants: Watched[str, nodes.ConstantDeclaration] = field(default_factory=Watched)
    predicates: Watched[str, nodes.PredicateDeclaration] = field(default_factory=Watched)
    apis: Watched[str, nodes.ApiDeclaration] = field(default_factory=Watched)
    programs: Watched[str, nodes.ProgramDeclaration] = field(default_factory=Watched)
    tasks: Watched[str, nodes.TaskDeclaration] = field(default_factory=Watched)
    members: Watched[str, tuple[str, ...]] = field(default_factory=Watched)  # -> their enumerations

    def dictionaries(self) -> tuple[Watched[Any, Any], ...]:
        """All in which names are looked up."""
        return (
            self.types, self.enums, self.records, self.constants, self.predicates, self.apis,
            self.programs, self.tasks, self.members,
        )  # fmt: skip

    def add(self, declaration: Declaration) -> None:
        """The first declaration of a name stands."""
        getattr(self, SPACES[type(declaration)][0]).setdefault(declaration.name, declaration)
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
        """Whatever may stand as a parameter's type."""
        return ChainMap[str, object](
            cast(dict[str, object], self.types),
            cast(dict[str, object], self.enums),
            cast(dict[str, object], self.records),
            dict.fromkeys(NUMBER_TYPES),
        )

    def is_a(self, name: str, ancestor: str) -> bool:
        """Whether one type descends from another; where nobody can tell, it does."""
        line = list(self.ancestors(name))
        if ancestor in line:
            return True
        oldest = self.types.get(line[-1])
        return line[-1] not in self.type_names() if oldest is None else oldest.parent is not None

    def ancestors(self, name: str) -> Iterator[str]:
        """The type itself, then its parents; a circle is walked once."""
        seen: set[str] = set()
        current: str | None = name
        while current is not None and current not in seen:
            yield current
            seen.add(current)
            declared = self.types.get(current)
            current = declared.parent.name if declared and declared.parent else None

    def enum_of(self, member: str) -> Sequence[str]:
        """The enumerations that have such a member."""
        return self.members.get(member) or ()


SPACES: Mapping[type[Declaration], tuple[str, str, str]] = {  # kind -> (field, namespace, word)
    nodes.TypeDeclaration: ("types", "type", "type"),
    nodes.EnumDeclaration: ("enums", "type", "enum"),
    nodes.RecordDeclaration: ("records", "type", "record"),
    nodes.ConstantDeclaration: ("constants", "value", "constant"),
    nodes.PredicateDeclaration: ("predicates", "predicate", "predicate"),
    nodes.ApiDeclaration: ("apis", "call", "api"),
    nodes.ProgramDeclaration: ("programs", "call", "program"),
    nodes.TaskDeclaration: ("tasks", "task", "task"),
}


# What other languages call what a number measures.
ELSEWHERE = {
    "float": "number", "double": "number", "real": "number", "int": "number", "integer": "number",
    "num": "number", "scalar": "number", "distance": "length", "meters": "length", "metres": "length",
    "duration": "time", "seconds": "time", "degrees": "angle", "radians": "angle", "weight": "mass",
    "newton": "force", "string": "", "str": "", "bool": "", "boolean": "",
}  # fmt: skip


def check_type(table: SymbolTable, name: nodes.TypeName) -> Checked[bool]:
    """Return whether the type exists."""
    if name.name in table.type_names():
        return True
    known = table.type_names()
    meant = ELSEWHERE.get(name.name.lower())
    if meant is None and name.name in UNITS:
        meant = UNITS[name.name][0]
    if meant is None:
        yield unknown("E103", "there is no type", name.name, name.span, known)
        return False
    help = "" if meant else "a predicate is true or false by itself, and words are members of an enumeration"
    message = f"there is no type '{name.name}'" + (f"; did you mean '{meant}'?" if meant else "")
    fix = Fix(name.span, meant) if meant else None
    yield Diagnostic("E103", message, name.span, (), help, fix, name.name)
    return False
