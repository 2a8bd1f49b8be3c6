"""From libraries to all that is wrong with their meaning: each in turn, after those that it uses.

What is sound is checked although other declarations are broken; nothing is reported where it could follow
from what is broken.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ntp_dsl.language.checks.call_hierarchy import check_calls, check_hierarchy
from ntp_dsl.language.checks.contracts import check_contract
from ntp_dsl.language.checks.declarations import check_declaration
from ntp_dsl.language.checks.sentences import check_said_alike
from ntp_dsl.language.checks.state_changes import check_state_changes
from ntp_dsl.language.checks.unused import unused_between, unused_within
from ntp_dsl.language.diagnostics.checked import outcome
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, has_errors
from ntp_dsl.language.logic.preconditions import Contracts
from ntp_dsl.language.names.incremental_cache import IncrementalCache
from ntp_dsl.language.names.poisoned_spans import PoisonedSpans
from ntp_dsl.language.names.symbol_table import KINDS, SymbolTable
from ntp_dsl.language.names.unknown_names import AvailableNames, resolve_unknown, standard_names
from ntp_dsl.language.names.use_statements import repeated_uses
from ntp_dsl.language.names.visibility import Unit, dependencies, key, visible_names
from ntp_dsl.language.parsing.partial_library import PartialLibrary
from ntp_dsl.language.syntax.nodes import (
    ApiDeclaration,
    Declaration,
    PredicateDeclaration,
    ProgramDeclaration,
    TaskDeclaration,
)
from ntp_dsl.language.syntax.visitors import callees, predicates

CALLED = (ApiDeclaration, ProgramDeclaration)
# Codes that an incomplete declaration, or an incomplete task, may have only because lines are missing.
IF_INCOMPLETE = ({"E405"}, {"E101", "E106", "E501"})


def examine(
    units: Sequence[Unit], available: AvailableNames = standard_names, cache: IncrementalCache | None = None
) -> tuple[SymbolTable, list[Diagnostic]]:
    """Return the symbol table of a library, and all that is wrong with the meaning of all units.

    Args:
        units: the library in question first, then all that it uses.
        available: where else a name may be declared.
        cache: of earlier checks, of libraries like these.
    """
    cache = cache or IncrementalCache()
    examination = _Examination(cache)
    found: list[Diagnostic] = []
    for index in [*dependencies(units, 0), 0]:
        table, of_library = outcome(visible_names(units, index))
        of_library += examination.library(units[index].partial, table)
        found += resolve_unknown(of_library, units, index, available)
        found += repeated_uses(units[index].library)
    is_broken = any(unit.partial.diagnostics or None in unit.uses for unit in units)
    if not is_broken and not has_errors(found):
        found += unused_between(units, table, cache.references)
    return table, found


class _Examination:
    """Checks libraries in turn, and remembers which declarations no conclusions may rest on."""

    def __init__(self, cache: IncrementalCache) -> None:
        self._cache = cache
        self._found: list[Diagnostic] = []  # about names and types, in all libraries so far
        self._faulty: dict[int, Declaration] = {}  # by identity
        self._incomplete: dict[int, Declaration] = {}  # likewise
        self._unclear: set[str] = set()  # predicates whose meaning is not known

    def library(self, partial: PartialLibrary, table: SymbolTable) -> Iterator[Diagnostic]:
        """Check a library after all that it uses."""
        for declaration in partial.library.declarations:
            yield from self._declaration(declaration, partial, table)
        own = [each for each in partial.library.declarations if _is_in(each, table)]
        complete = [each for each in own if id(each) not in self._incomplete]
        known = self._without_incomplete(table)
        yield from check_hierarchy(known, complete)
        yield from check_state_changes(complete, known)
        yield from check_said_alike(complete, known)
        contracts = Contracts(self._without_unclear(known), PoisonedSpans(self._found))
        for each in complete:
            if isinstance(each, ProgramDeclaration):
                check = check_calls(each, known)
                yield from self._cache.reuse_or_run(each, check_calls, known.dictionaries(), (), check)
            if isinstance(each, ProgramDeclaration | TaskDeclaration):
                yield from self._contract(each, contracts)

    def _contract(
        self, declaration: ProgramDeclaration | TaskDeclaration, contracts: Contracts
    ) -> Sequence[Diagnostic]:
        table = contracts.table
        if not _is_in(declaration, table):
            return ()
        if isinstance(declaration, ProgramDeclaration):
            called = callees(declaration)
        else:
            called = (declaration.run.callee,) if declaration.run else ()
        named = [declaration, *filter(None, map(table.callable, called))]
        faulty = frozenset(each.name for each in named if id(each) in self._faulty)
        basis = (faulty, contracts.inferred)
        check = check_contract(declaration, contracts)
        return self._cache.reuse_or_run(declaration, check_contract, contracts.dictionaries(), basis, check)

    def _declaration(
        self, declaration: Declaration, partial: PartialLibrary, table: SymbolTable
    ) -> Iterator[Diagnostic]:
        is_incomplete = key(declaration) in partial.incomplete
        check = _check_alone(declaration, table, is_incomplete)
        found = self._cache.reuse_or_run(
            declaration, check_declaration, table.dictionaries(), is_incomplete, check
        )
        self._found += found
        if found:
            self._faulty[id(declaration)] = declaration
        if is_incomplete:
            self._incomplete[id(declaration)] = declaration
        is_clear = not is_incomplete and all(each.severity == "warning" for each in found)
        if isinstance(declaration, PredicateDeclaration) and not is_clear:
            self._unclear.add(declaration.name)
        passed_over = IF_INCOMPLETE[isinstance(declaration, TaskDeclaration)] if is_incomplete else ()
        yield from (each for each in found if each.code not in passed_over)

    def _without_incomplete(self, table: SymbolTable) -> SymbolTable:
        """Return the table without programs and apis of which lines are missing."""
        missing = {number for number, each in self._incomplete.items() if isinstance(each, CALLED)}
        return table.select(lambda each: id(each) not in missing) if missing else table

    def _without_unclear(self, table: SymbolTable) -> SymbolTable:
        """Return the table without unclear predicates, and without contracts that apply them."""
        unclear = {name for name in self._unclear if name in table.predicates}
        if not unclear:
            return table
        while more := {
            each.name
            for each in table.predicates.values()
            if each.name not in unclear and predicates(each.body) & unclear
        }:
            unclear |= more

        def is_clear(declaration: Declaration) -> bool:
            if isinstance(declaration, CALLED):
                applied = predicates(declaration.requires) | predicates(declaration.achieves)
                return not applied & unclear
            return not (isinstance(declaration, PredicateDeclaration) and declaration.name in unclear)

        return table.select(is_clear)


def _check_alone(declaration: Declaration, table: SymbolTable, is_incomplete: bool) -> Iterator[Diagnostic]:
    """Check a declaration; of a sound one, also report what in it is unused."""
    found = [*check_declaration(declaration, table)]
    yield from found
    if not found and not is_incomplete:
        yield from unused_within(declaration)


def _is_in(declaration: Declaration, table: SymbolTable) -> bool:
    """Return whether this declaration is the one in the table, and not another of its name."""
    return getattr(table, KINDS[type(declaration)].field).get(declaration.name) is declaration
