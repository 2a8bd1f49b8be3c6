"""From drafts to all that is wrong with their meaning: of each library in turn, those that it uses first.

What stands is checked although other things do not. Nothing is said of what cannot be told because something
that it rests on is broken.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from ntp_dsl.language import uses
from ntp_dsl.language.contracts import check_contracts
from ntp_dsl.language.declarations import check_declaration
from ntp_dsl.language.diagnostics import Diagnostic
from ntp_dsl.language.drafts import Draft
from ntp_dsl.language.hierarchy import check_hierarchy
from ntp_dsl.language.names import SPACES, Table
from ntp_dsl.language.scopes import Unit, below, collect, key
from ntp_dsl.language.syntax import (
    ApiDeclaration,
    Declaration,
    PredicateDeclaration,
    ProgramDeclaration,
    TaskDeclaration,
)
from ntp_dsl.language.unknowns import Shelf, settle, standard_names
from ntp_dsl.language.unused import unused_between, unused_within
from ntp_dsl.language.walks import predicates

CALLED = (ApiDeclaration, ProgramDeclaration)
# What may only seem to be wrong with a declaration, or with a task, of which lines are missing.
IN_HOLES = ({"E405"}, {"E101", "E106", "E501"})


def examine(units: Sequence[Unit], shelf: Shelf = standard_names) -> list[Diagnostic]:
    """Everything that is wrong with the libraries' meaning, as far as they could be read.

    Args:
        units: the library in question first, then all that it uses.
        shelf: where else a name may be declared.
    """
    examination = _Examination()
    mistakes: list[Diagnostic] = []
    for index in [*below(units, 0), 0]:
        table = Table()
        collect(units, index, table)
        found = [*table.mistakes, *examination.library(units[index].draft, table)]
        mistakes += settle(found, units, index, shelf)
        mistakes += uses.repeated(units[index].draft)
    broken = any(each.severity == "error" for each in mistakes) or any(
        unit.draft.mistakes or None in unit.uses for unit in units
    )
    if not broken:
        mistakes += unused_between(units, table)
    return mistakes


class _Examination:
    """Goes through libraries, and keeps in mind what is not to be relied on."""

    def __init__(self) -> None:
        self._said: list[Diagnostic] = []  # of names and types, in all libraries so far
        self._holed: list[Declaration] = []
        self._wrong: set[str] = set()  # predicates of which it is not known what they say

    def library(self, draft: Draft, table: Table) -> Iterator[Diagnostic]:
        """What is wrong with a library, where all that it uses was examined before."""
        for declaration in draft.declarations:
            yield from self._declaration(declaration, draft, table)
        holed = {id(each) for each in self._holed}
        own = [each for each in draft.declarations if _stands(each, table)]
        judged = [each for each in own if id(each) not in holed]
        known = self._without_holed(table)
        check_hierarchy(known, judged)
        yield from known.mistakes
        clear = self._without_wrong(known)
        clear.mistakes = list(self._said)
        check_contracts(clear, [each for each in judged if _stands(each, clear)])
        yield from clear.mistakes[len(self._said) :]

    def _declaration(
        self, declaration: Declaration, draft: Draft, table: Table
    ) -> Iterator[Diagnostic]:
        table.mistakes = []
        check_declaration(declaration, table)
        if not table.mistakes and key(declaration) not in draft.holed:
            yield from unused_within(declaration)
        self._said += table.mistakes
        is_holed = key(declaration) in draft.holed
        if is_holed:
            self._holed.append(declaration)
        if isinstance(declaration, PredicateDeclaration) and (is_holed or table.mistakes):
            self._wrong.add(declaration.name)
        missed = IN_HOLES[isinstance(declaration, TaskDeclaration)] if is_holed else ()
        yield from (each for each in table.mistakes if each.code not in missed)

    def _without_holed(self, table: Table) -> Table:
        """The table without programs and apis of which lines are missing."""
        holed = {id(each) for each in self._holed if isinstance(each, CALLED)}
        return _select(table, lambda each: id(each) not in holed) if holed else _fresh(table)

    def _without_wrong(self, table: Table) -> Table:
        """The table without the predicates that are wrong, and without contracts that rest on them."""
        wrong = {name for name in self._wrong if name in table.predicates}
        if not wrong:
            return _fresh(table)
        while more := {
            each.name
            for each in table.predicates.values()
            if each.name not in wrong and predicates(each.body) & wrong
        }:
            wrong |= more

        def is_clear(declaration: Declaration) -> bool:
            if isinstance(declaration, CALLED):
                said = predicates(declaration.requires) | predicates(declaration.achieves)
                return not said & wrong
            return not (isinstance(declaration, PredicateDeclaration) and declaration.name in wrong)

        return _select(table, is_clear)


def _fresh(table: Table) -> Table:
    return replace(table, mistakes=[])


def _stands(declaration: Declaration, table: Table) -> bool:
    """Whether the table has this very declaration of its name."""
    return getattr(table, SPACES[type(declaration)][0]).get(declaration.name) is declaration


def _select(table: Table, is_chosen: Callable[[Declaration], bool]) -> Table:
    chosen = Table()
    for dictionary in table.dictionaries():
        for each in dictionary.values():
            if isinstance(each, Declaration) and is_chosen(each):
                chosen.add(each)
    return chosen
