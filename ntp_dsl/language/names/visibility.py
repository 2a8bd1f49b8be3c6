"""Which names a library sees: its own, and those of all libraries that it uses, directly or not.

A library that it does not use is invisible, though others may use it. No two visible libraries may declare
the same name in one namespace.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from ntp_dsl.language.diagnostics.checked import Checked
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, Note, unknown
from ntp_dsl.language.names.symbol_table import KINDS, NUMBER_TYPES, SymbolTable
from ntp_dsl.language.parsing.partial_library import Key, PartialLibrary
from ntp_dsl.language.syntax.nodes import (
    ConstantDeclaration,
    Declaration,
    EnumDeclaration,
    Library,
    Span,
    TaskDeclaration,
    TypeDeclaration,
)

MAX_LISTED = 3  # names that a message lists before it says "and more"


@dataclass(frozen=True)
class Unit:
    """A library, and the unit that each of its `use` lines names; None where there is no such library."""

    partial: PartialLibrary
    uses: tuple[int | None, ...] = ()

    @property
    def library(self) -> Library:
        return self.partial.library


def dependencies(units: Sequence[Unit], index: int) -> list[int]:
    """Return all units that a library uses, directly or not, each after those that it uses itself."""
    found: dict[int, None] = {}
    waiting = [(index, iter(units[index].uses))]
    entered = {index}
    while waiting:
        current, rest = waiting[-1]
        following = next((each for each in rest if each is not None and each not in entered), None)
        if following is None:
            waiting.pop()
            found[current] = None
        else:
            entered.add(following)
            waiting.append((following, iter(units[following].uses)))
    return [each for each in found if each != index]


def key(declaration: Declaration) -> Key:
    """Return the namespace that a declaration's name belongs to, and the name."""
    return KINDS[type(declaration)].namespace, declaration.name


def visible_names(units: Sequence[Unit], index: int) -> Checked[SymbolTable]:
    """Return the symbol table of a library; check the names that it declares itself."""
    table = SymbolTable()
    owners: dict[Key, tuple[int, Declaration]] = {}
    for position, used in enumerate(units[index].uses):
        if used is not None:
            yield from _add_used(units, index, position, used, owners, table)
    own = units[index].library.declarations
    for declaration in own:
        if key(declaration) in owners:
            yield _clash(units, index, declaration, *owners[key(declaration)])
        else:
            owners[key(declaration)] = index, declaration
            table.add(declaration)
    for declaration in own:
        yield from _check_own(declaration, own, table)
    return table


def _add_used(
    units: Sequence[Unit],
    index: int,
    position: int,
    used: int,
    owners: dict[Key, tuple[int, Declaration]],
    table: SymbolTable,
) -> Iterator[Diagnostic]:
    """Add what one `use` makes visible; a clash within that is reported where that library is checked."""
    inside = [each for each in [*dependencies(units, used), used] if each != index]
    clashes: dict[tuple[int, int], list[tuple[Declaration, Declaration]]] = {}
    for each in inside:
        for declaration in units[each].library.declarations:
            owner, first = owners.setdefault(key(declaration), (each, declaration))
            if first is declaration:
                table.add(declaration)
            elif owner != each and owner not in inside:
                clashes.setdefault((owner, each), []).append((first, declaration))
    for (owner, each), pairs in clashes.items():
        names = dict.fromkeys(f"'{declaration.name}'" for _, declaration in pairs)
        listing = ", ".join([*names][:MAX_LISTED]) + (", ..." if len(names) > MAX_LISTED else "")
        message = (
            f"library '{units[each].library.name}' declares {listing}, and so does"
            f" '{units[owner].library.name}', which is used already"
        )
        notes = tuple(Note("declared here", declaration.name_span) for declaration in pairs[0])
        span = units[index].library.uses[position].span
        yield Diagnostic("E302", message, span, notes, "use one of the two, or rename in one of them")


def _clash(
    units: Sequence[Unit], index: int, again: Declaration, owner: int, first: Declaration
) -> Diagnostic:
    note = Note("first declared here", first.name_span)
    word = KINDS[type(again)].keyword
    alike = replace(again, docstring="") == replace(first, docstring="")
    # Of an incomplete declaration some lines are placeholders, which cannot be removed.
    is_incomplete = key(again) in units[index].partial.incomplete
    fix = _removal(again) if alike and not is_incomplete else None
    if owner == index:
        message = f"{word} '{again.name}' is declared twice"
        help = "rename or remove one of them"
        if isinstance(again, TaskDeclaration) and fix is None:
            fix = Fix(again.name_span, f"{again.name}_again")  # nothing else names a task
        return Diagnostic("E301", message, again.name_span, (note,), help, fix)
    name = units[owner].library.name
    message = f"{word} '{again.name}' is also declared by library '{name}', which is used here"
    help = "remove it: the other is the same" if alike else "choose another name"
    return Diagnostic("E302", message, again.name_span, (note,), help, fix)


def _removal(declaration: Declaration) -> Fix:
    """Take out all lines of the declaration."""
    span = declaration.span
    end = (span.end_line, 1) if span.end_column == 1 else (span.end_line + 1, 1)
    return Fix(Span(span.path, span.line, 1, *end), "")


def _check_own(
    declaration: Declaration, own: Sequence[Declaration], table: SymbolTable
) -> Iterator[Diagnostic]:
    if KINDS[type(declaration)].namespace == "type" and declaration.name in NUMBER_TYPES:
        message = f"'{declaration.name}' is a number type of the language already"
        yield Diagnostic("E301", message, declaration.name_span, help="choose another name")
    if isinstance(declaration, TypeDeclaration):
        yield from _check_parent(declaration, table)
    elif isinstance(declaration, EnumDeclaration):
        yield from _check_members(declaration, table)
    elif isinstance(declaration, ConstantDeclaration):
        yield from _check_constant(declaration, own, table)


def _check_parent(declaration: TypeDeclaration, table: SymbolTable) -> Iterator[Diagnostic]:
    parent = declaration.parent
    if parent is None:
        return
    if parent.name not in table.types or parent.is_list:
        yield unknown("E103", "there is no type", parent.name, parent.span, table.types)
    elif declaration.name in table.ancestors(parent.name):
        message = f"type '{declaration.name}' is its own ancestor"
        help = "one of the types in the cycle must have no parent"
        yield Diagnostic("E303", message, parent.span, help=help)


def _check_members(enum: EnumDeclaration, table: SymbolTable) -> Iterator[Diagnostic]:
    for index, member in enumerate(enum.members):
        span = enum.member_spans[index] if enum.member_spans else enum.name_span
        if member in enum.members[:index]:
            before = enum.member_spans[index - 1] if enum.member_spans else span
            whole = Span(span.path, before.end_line, before.end_column, span.end_line, span.end_column)
            message = f"'{member}' is a member of '{enum.name}' twice"
            yield Diagnostic("E301", message, span, help="once is enough", fix=Fix(whole, ""))
        elif member in table.constants:
            note = Note("declared here", table.constants[member].name_span)
            yield Diagnostic("E301", f"'{member}' is a constant already", span, (note,))


def _check_constant(
    constant: ConstantDeclaration, own: Sequence[Declaration], table: SymbolTable
) -> Iterator[Diagnostic]:
    for name in table.members.get(constant.name, ()):
        if table.enums[name] not in own:  # of its own enumerations, `_check_members` reports it
            note = Note("declared here", table.enums[name].name_span)
            message = f"'{constant.name}' is a member of '{name}' already"
            yield Diagnostic("E302", message, constant.name_span, (note,), "choose another name")
