"""From libraries to one table of names: what was declared, twice, in a circle, or not at all."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from ntp_dsl.language import syntax
from ntp_dsl.language.diagnostics import Diagnostic, Fix, Note, unknown
from ntp_dsl.language.syntax import Declaration, Span

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

D = TypeVar("D", bound=Declaration)


@dataclass
class Table:
    """Every declaration by name, in the namespaces of the language.

    Programs and apis share one, and so do the kinds of type, and constants with enumerations'
    members. A predicate may be called like a program.
    """

    types: dict[str, syntax.TypeDeclaration] = field(default_factory=dict)
    enums: dict[str, syntax.EnumDeclaration] = field(default_factory=dict)
    records: dict[str, syntax.RecordDeclaration] = field(default_factory=dict)
    constants: dict[str, syntax.ConstantDeclaration] = field(default_factory=dict)
    predicates: dict[str, syntax.PredicateDeclaration] = field(default_factory=dict)
    apis: dict[str, syntax.ApiDeclaration] = field(default_factory=dict)
    programs: dict[str, syntax.ProgramDeclaration] = field(default_factory=dict)
    tasks: dict[str, syntax.TaskDeclaration] = field(default_factory=dict)
    mistakes: list[Diagnostic] = field(default_factory=list)
    home: syntax.Library | None = None  # the one that is checked, and uses the others
    missing: set[str] = field(default_factory=set)  # libraries that it ought to use

    def callable(self, name: str) -> syntax.ApiDeclaration | syntax.ProgramDeclaration | None:
        return self.programs.get(name) or self.apis.get(name)

    def callables(self) -> list[syntax.ApiDeclaration | syntax.ProgramDeclaration]:
        return [*self.programs.values(), *self.apis.values()]

    def type_names(self) -> list[str]:
        """Whatever may stand as a parameter's type."""
        return [*self.types, *self.enums, *self.records, *NUMBER_TYPES]

    def is_a(self, name: str, ancestor: str) -> bool:
        return ancestor in self.ancestors(name)

    def ancestors(self, name: str) -> Iterator[str]:
        """The type itself, then its parents; a circle is walked once."""
        seen: set[str] = set()
        current: str | None = name
        while current is not None and current not in seen:
            yield current
            seen.add(current)
            declared = self.types.get(current)
            current = declared.parent.name if declared and declared.parent else None

    def enum_of(self, member: str) -> list[str]:
        """The enumerations that have such a member."""
        return [name for name, enum in self.enums.items() if member in enum.members]

    def report(
        self,
        code: str,
        message: str,
        span: Span,
        help: str = "",
        *notes: Note,
        fix: Fix | None = None,
    ) -> None:
        self.mistakes.append(Diagnostic(code, message, span, notes, help, fix))


SPACES: Mapping[type[Declaration], tuple[str, str, str]] = {  # kind -> (field, namespace, word)
    syntax.TypeDeclaration: ("types", "type", "type"),
    syntax.EnumDeclaration: ("enums", "type", "enum"),
    syntax.RecordDeclaration: ("records", "type", "record"),
    syntax.ConstantDeclaration: ("constants", "value", "constant"),
    syntax.PredicateDeclaration: ("predicates", "predicate", "predicate"),
    syntax.ApiDeclaration: ("apis", "call", "api"),
    syntax.ProgramDeclaration: ("programs", "call", "program"),
    syntax.TaskDeclaration: ("tasks", "task", "task"),
}


def collect(libraries: Iterable[syntax.Library]) -> Table:
    """One table of all libraries; a name's first declaration stands, later ones are mistakes."""
    table = Table()
    owners: dict[tuple[str, str], tuple[str, Declaration]] = {}
    for library in libraries:
        table.home = library
        for declaration in library.declarations:
            attribute, space, word = SPACES[type(declaration)]
            key = space, declaration.name
            if key in owners:
                _clash(table, library.name, declaration, word, *owners[key])
                continue
            owners[key] = library.name, declaration
            getattr(table, attribute)[declaration.name] = declaration
    _check_numbers_are_free(table)
    _check_parents(table)
    _check_enums(table)
    return table


def _clash(
    table: Table, library: str, again: Declaration, word: str, owner: str, first: Declaration
) -> None:
    note = Note("first declared here", first.name_span)
    if owner == library:
        message = f"{word} '{again.name}' is declared twice"
        table.report("E301", message, again.name_span, "rename or remove one of them", note)
    else:
        message = f"{word} '{again.name}' is also declared by library '{owner}', which is used here"
        table.report("E302", message, again.name_span, "choose another name", note)


def _check_numbers_are_free(table: Table) -> None:
    for declaration in [*table.types.values(), *table.enums.values(), *table.records.values()]:
        if declaration.name in NUMBER_TYPES:
            message = f"'{declaration.name}' is a number type of the language already"
            table.report("E301", message, declaration.name_span, "choose another name")


def _check_parents(table: Table) -> None:
    for declaration in table.types.values():
        parent = declaration.parent
        if parent is None:
            continue
        if parent.name not in table.types or parent.is_list:
            table.mistakes.append(
                unknown("E103", "there is no type", parent.name, parent.span, table.types)
            )
        elif _is_own_ancestor(table, declaration):
            message = f"type '{declaration.name}' is its own ancestor"
            table.report(
                "E303", message, parent.span, "one of the types in the circle has no parent"
            )


def _is_own_ancestor(table: Table, declaration: syntax.TypeDeclaration) -> bool:
    assert declaration.parent is not None
    return declaration.name in table.ancestors(declaration.parent.name)


def _check_enums(table: Table) -> None:
    for enum in table.enums.values():
        for index, member in enumerate(enum.members):
            span = enum.member_spans[index] if enum.member_spans else enum.name_span
            if member in enum.members[:index]:
                table.report("E301", f"'{member}' is a member of '{enum.name}' twice", span)
            elif member in table.constants:
                note = Note("declared here", table.constants[member].name_span)
                table.report("E301", f"'{member}' is a constant already", span, "", note)


def check_type(table: Table, name: syntax.TypeName) -> bool:
    """Whether the type exists; says so if not."""
    if name.name in table.type_names():
        return True
    known = table.type_names()
    table.mistakes.append(unknown("E103", "there is no type", name.name, name.span, known))
    return False
