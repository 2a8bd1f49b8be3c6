"""What each library sees: its own names, and those of all that it uses, one way or another.

A library that it does not use is out of its sight, though others may use it. No two libraries in sight may
declare the same name in one namespace.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ntp_dsl.language.diagnostics.diagnostics import Fix, Note, unknown
from ntp_dsl.language.names.symbol_table import NUMBER_TYPES, SPACES, Table
from ntp_dsl.language.parsing.partial_library import Draft, Key
from ntp_dsl.language.syntax.nodes import (
    ConstantDeclaration,
    Declaration,
    EnumDeclaration,
    Span,
    TaskDeclaration,
    TypeDeclaration,
)

FEW = 3  # names that a message lists before it says "and more"


@dataclass(frozen=True)
class Unit:
    """A draft, and which unit each of its `use` lines stands for; None if that cannot be told."""

    draft: Draft
    uses: tuple[int | None, ...] = ()


def below(units: Sequence[Unit], index: int) -> list[int]:
    """All that a library uses, one way or another; each stands after what it uses itself."""
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
    """The namespace that a declaration's name belongs to, and the name."""
    return SPACES[type(declaration)][1], declaration.name


def collect(units: Sequence[Unit], index: int, table: Table) -> None:
    """Fill the table with what a library sees; what is wrong with its own names is left there."""
    owners: dict[Key, tuple[int, Declaration]] = {}
    for position, user in enumerate(units[index].uses):
        if user is not None:
            _bring_in(units, index, position, user, owners, table)
    for declaration in units[index].draft.declarations:
        if key(declaration) in owners:
            _clash(units, index, declaration, *owners[key(declaration)], table)
        else:
            owners[key(declaration)] = index, declaration
            table.add(declaration)
    for declaration in units[index].draft.declarations:
        _check_own(declaration, units[index].draft.declarations, table)


def _bring_in(
    units: Sequence[Unit],
    index: int,
    position: int,
    user: int,
    owners: dict[Key, tuple[int, Declaration]],
    table: Table,
) -> None:
    """What one `use` adds; a clash within what it brings is told where that is used."""
    inside = [each for each in [*below(units, user), user] if each != index]
    clashes: dict[tuple[int, int], list[tuple[Declaration, Declaration]]] = {}
    for each in inside:
        for declaration in units[each].draft.declarations:
            owner, first = owners.setdefault(key(declaration), (each, declaration))
            if first is declaration:
                table.add(declaration)
            elif owner != each and owner not in inside:
                clashes.setdefault((owner, each), []).append((first, declaration))
    for (owner, each), pairs in clashes.items():
        names = dict.fromkeys(f"'{declaration.name}'" for _, declaration in pairs)
        listing = ", ".join([*names][:FEW]) + (", ..." if len(names) > FEW else "")
        message = (
            f"library '{units[each].draft.name}' declares {listing}, and so does"
            f" '{units[owner].draft.name}', which is used already"
        )
        notes = [Note("declared here", declaration.name_span) for declaration in pairs[0]]
        span = units[index].draft.uses[position].span
        table.report("E302", message, span, "use one of the two, or rename in one of them", *notes)


def _clash(
    units: Sequence[Unit],
    index: int,
    again: Declaration,
    owner: int,
    first: Declaration,
    table: Table,
) -> None:
    note = Note("first declared here", first.name_span)
    word = SPACES[type(again)][2]
    alike = replace(again, docstring="") == replace(first, docstring="")
    # What was made up to read on is on no line that could be taken out.
    holed = key(again) in units[index].draft.holed
    fix = _removal(again) if alike and not holed else None
    if owner == index:
        message = f"{word} '{again.name}' is declared twice"
        help = "rename or remove one of them"
        if isinstance(again, TaskDeclaration) and fix is None:
            fix = Fix(again.name_span, f"{again.name}_again")  # nothing else names a task
        table.report("E301", message, again.name_span, help, note, fix=fix)
    else:
        name = units[owner].draft.name
        message = f"{word} '{again.name}' is also declared by library '{name}', which is used here"
        help = "remove it: the other says the same" if alike else "choose another name"
        table.report("E302", message, again.name_span, help, note, fix=fix)


def _removal(declaration: Declaration) -> Fix:
    """All lines of the declaration are taken out."""
    span = declaration.span
    end = (span.end_line, 1) if span.end_column == 1 else (span.end_line + 1, 1)
    return Fix(Span(span.path, span.line, 1, *end), "")


def _check_own(declaration: Declaration, own: Sequence[Declaration], table: Table) -> None:
    if SPACES[type(declaration)][1] == "type" and declaration.name in NUMBER_TYPES:
        message = f"'{declaration.name}' is a number type of the language already"
        table.report("E301", message, declaration.name_span, "choose another name")
    if isinstance(declaration, TypeDeclaration):
        _check_parent(declaration, table)
    elif isinstance(declaration, EnumDeclaration):
        _check_members(declaration, table)
    elif isinstance(declaration, ConstantDeclaration):
        _check_constant(declaration, own, table)


def _check_parent(declaration: TypeDeclaration, table: Table) -> None:
    parent = declaration.parent
    if parent is None:
        return
    if parent.name not in table.types or parent.is_list:
        table.mistakes.append(unknown("E103", "there is no type", parent.name, parent.span, table.types))
    elif declaration.name in table.ancestors(parent.name):
        message = f"type '{declaration.name}' is its own ancestor"
        help = "one of the types in the circle has no parent"
        table.report("E303", message, parent.span, help)


def _check_members(enum: EnumDeclaration, table: Table) -> None:
    for index, member in enumerate(enum.members):
        span = enum.member_spans[index] if enum.member_spans else enum.name_span
        if member in enum.members[:index]:
            before = enum.member_spans[index - 1] if enum.member_spans else span
            whole = Span(span.path, before.end_line, before.end_column, span.end_line, span.end_column)
            message = f"'{member}' is a member of '{enum.name}' twice"
            table.report("E301", message, span, "once is enough", fix=Fix(whole, ""))
        elif member in table.constants:
            note = Note("declared here", table.constants[member].name_span)
            table.report("E301", f"'{member}' is a constant already", span, "", note)


def _check_constant(constant: ConstantDeclaration, own: Sequence[Declaration], table: Table) -> None:
    for name in table.members.get(constant.name, ()):
        if table.enums[name] not in own:  # an own enumeration says it of its member
            note = Note("declared here", table.enums[name].name_span)
            message = f"'{constant.name}' is a member of '{name}' already"
            table.report("E302", message, constant.name_span, "choose another name", note)
