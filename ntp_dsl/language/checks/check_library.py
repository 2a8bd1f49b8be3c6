"""From drafts to all that is wrong with their meaning: of each library in turn, those that it uses first.

What stands is checked although other things do not. Nothing is said of what cannot be told because something
that it rests on is broken.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from ntp_dsl.language.checks.call_hierarchy import check_calls, check_hierarchy
from ntp_dsl.language.checks.contracts import check_contract
from ntp_dsl.language.checks.declarations import check_declaration
from ntp_dsl.language.checks.unused import unused_between, unused_within
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.logic.preconditions import Contracts
from ntp_dsl.language.names import use_statements
from ntp_dsl.language.names.incremental_cache import Memory
from ntp_dsl.language.names.symbol_table import SPACES, Table
from ntp_dsl.language.names.unknown_names import Shelf, settle, standard_names
from ntp_dsl.language.names.visibility import Unit, below, collect, key
from ntp_dsl.language.parsing.partial_library import Draft
from ntp_dsl.language.syntax.nodes import (
    ApiDeclaration,
    Declaration,
    PredicateDeclaration,
    ProgramDeclaration,
    TaskDeclaration,
)
from ntp_dsl.language.syntax.visitors import callees, predicates

CALLED = (ApiDeclaration, ProgramDeclaration)
# What may only seem to be wrong with a declaration, or with a task, of which lines are missing.
IN_HOLES = ({"E405"}, {"E101", "E106", "E501"})


def examine(
    units: Sequence[Unit], shelf: Shelf = standard_names, memory: Memory | None = None
) -> list[Diagnostic]:
    """Everything that is wrong with the libraries' meaning, as far as they could be read.

    Args:
        units: the library in question first, then all that it uses.
        shelf: where else a name may be declared.
        memory: what was found out before, about libraries like these.
    """
    memory = memory or Memory()
    examination = _Examination(memory)
    mistakes: list[Diagnostic] = []
    for index in [*below(units, 0), 0]:
        table = Table()
        collect(units, index, table)
        found = [*table.mistakes, *examination.library(units[index].draft, table)]
        mistakes += settle(found, units, index, shelf)
        mistakes += use_statements.repeated(units[index].draft)
    broken = any(each.severity == "error" for each in mistakes) or any(
        unit.draft.mistakes or None in unit.uses for unit in units
    )
    if not broken:
        mistakes += unused_between(units, table, memory.mentions)
    return mistakes


class _Examination:
    """Goes through libraries, and keeps in mind what is not to be relied on."""

    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        self._said: list[Diagnostic] = []  # of names and types, in all libraries so far
        self._faulty: dict[int, Declaration] = {}  # by identity
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
        contracts = Contracts(clear)
        for program in judged:
            if isinstance(program, ProgramDeclaration):
                yield from self._memory.recall(
                    program,
                    check_calls,
                    known.dictionaries(),
                    (),
                    partial(_left, known, check_calls, program),
                )
            if isinstance(program, ProgramDeclaration | TaskDeclaration):
                yield from self._contract(program, contracts)

    def _contract(
        self, declaration: ProgramDeclaration | TaskDeclaration, contracts: Contracts
    ) -> Iterator[Diagnostic]:
        table = contracts.table
        if not _stands(declaration, table):
            return
        if isinstance(declaration, ProgramDeclaration):
            called = callees(declaration)
        else:
            called = (declaration.run.callee,) if declaration.run else ()
        named = [declaration, *filter(None, map(table.callable, called))]
        faulty = frozenset(each.name for each in named if id(each) in self._faulty)
        yield from self._memory.recall(
            declaration,
            check_contract,
            contracts.dictionaries(),
            (faulty, contracts.outlook),
            partial(_judged, declaration, contracts),
        )

    def _declaration(self, declaration: Declaration, draft: Draft, table: Table) -> Iterator[Diagnostic]:
        is_holed = key(declaration) in draft.holed
        found = self._memory.recall(
            declaration,
            check_declaration,
            table.dictionaries(),
            is_holed,
            partial(self._meaning, declaration, table, is_holed),
        )
        raw = [each for each in found if each.code[0] != "W"]
        self._said += found
        if found:
            self._faulty[id(declaration)] = declaration
        if is_holed:
            self._holed.append(declaration)
        if isinstance(declaration, PredicateDeclaration) and (is_holed or raw):
            self._wrong.add(declaration.name)
        missed = IN_HOLES[isinstance(declaration, TaskDeclaration)] if is_holed else ()
        yield from (each for each in found if each.code not in missed)

    def _meaning(self, declaration: Declaration, table: Table, is_holed: bool) -> list[Diagnostic]:
        found = _left(table, check_declaration, declaration)
        return found if found or is_holed else list(unused_within(declaration))

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


def _left(table: Table, check: Callable[[Any, Table], None], declaration: Declaration) -> list[Diagnostic]:
    """What a check leaves in the table."""
    table.mistakes = []
    check(declaration, table)
    return table.mistakes


def _judged(declaration: ProgramDeclaration | TaskDeclaration, contracts: Contracts) -> list[Diagnostic]:
    said = len(contracts.table.mistakes)
    check_contract(declaration, contracts)
    found = contracts.table.mistakes[said:]
    del contracts.table.mistakes[said:]
    return found


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
