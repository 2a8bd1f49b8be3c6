"""Whether what a call requires can hold when its turn comes, as far as contracts tell."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence, Set
from dataclasses import dataclass
from typing import Any

from ntp_dsl.language.logic.facts import (
    ANY,
    EVERY,
    bind,
    facts,
    implies,
    negated,
    normalised,
    substitute,
    value_of,
)
from ntp_dsl.language.names.poisoned_spans import PoisonedSpans
from ntp_dsl.language.names.symbol_table import SymbolTable, TrackedDict
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import (
    Atom,
    Compare,
    Expression,
    Name,
    Not,
    Or,
    ProgramDeclaration,
    Statement,
)
from ntp_dsl.language.syntax.visitors import free_names, guards, innermost, loops, walk

Kind = tuple[bool, str]  # whether a predicate holds, and its name; a reading that is compared counts as True
MAX_DEPTH = 8  # of predicates composed of predicates


@dataclass(frozen=True)
class UnmetRequirement:
    """A fact that a call requires and that nothing before it provides."""

    program: ProgramDeclaration
    index: int  # of the statement
    call: nodes.Call
    fact: Expression
    certain: bool = True  # only a contract can provide it


class Contracts:
    """What calls require and achieve, according to the declarations.

    Args:
        poisoned: where names and types are wrong.
    """

    def __init__(self, table: SymbolTable, poisoned: PoisonedSpans) -> None:
        self.table = table
        self.members = table.members
        self._poisoned = poisoned
        self._achievers: TrackedDict[Kind, list[str]] = TrackedDict()
        for each in table.callables():
            for kind in self._kinds(each.achieves):
                self._achievers.setdefault(kind, []).append(each.name)
        self._opposites = self._find_opposites()

    def dictionaries(self) -> tuple[TrackedDict[Any, Any], ...]:
        """Return all dictionaries that are looked up; with `inferred`, all that a check rests on."""
        return (*self.table.dictionaries(), self._achievers)

    @property
    def inferred(self) -> object:
        """What is inferred from all contracts together."""
        return self._opposites

    def has_error(self, node: nodes.Node | None) -> bool:
        """Return whether there is an error inside, so that nothing can be concluded from it."""
        return self._poisoned.within(node)

    def _kinds(self, condition: Expression | None) -> Set[Kind]:
        return {kind for fact in self.expand(facts(condition)) for kind in _kinds(fact)}

    def _find_opposites(self) -> Set[tuple[Kind, Kind]]:
        """Return the pairs of facts that apis turn into each other (grasp: empty to holding; release: back).

        They exclude each other: a call that provides one is due only while the other holds.
        """
        turns = {
            (before, after)
            for api in self.table.apis.values()
            for before in self._kinds(api.requires)
            for after in self._kinds(api.achieves)
        }
        return {(before, after) for before, after in turns if (after, before) in turns}

    def expand(self, conditions: Iterable[Expression], depth: int = MAX_DEPTH) -> Iterator[Expression]:
        """Yield the facts, and those of which composed predicates among them are made."""
        for fact in conditions:
            yield fact
            yield from self.expand(self.parts(fact), depth - 1) if depth else ()

    def parts(self, fact: Expression) -> list[Expression]:
        """Return the facts of which a composed predicate, or its negation, is made."""
        holds, atom = (True, fact) if isinstance(fact, Atom) else (False, getattr(fact, "value", None))
        if not isinstance(atom, Atom):
            return []
        declared = self.table.predicates.get(atom.predicate)
        if declared is None or declared.body is None:
            return []
        values = bind(declared.parameters, atom.arguments)
        return [substitute(part, values) for part in facts(declared.body, holds)]

    def achievers(self, fact: Expression) -> list[str]:
        """Return the programs and apis that promise such a fact, perhaps of other objects."""
        names = [name for kind in _kinds(fact) for name in self._achievers.get(kind, ())]
        return list(dict.fromkeys(names))

    def contract(self, call: nodes.Call, side: str) -> list[Expression]:
        """Return what the callee requires or achieves, in the caller's terms."""
        callee = self.table.callable(call.callee)
        if callee is None:
            return []
        values = bind(callee.parameters, call.arguments)
        return [substitute(fact, values) for fact in facts(getattr(callee, side))]

    def unmet(self, program: ProgramDeclaration) -> Iterator[UnmetRequirement]:
        """Yield every fact that a call of the program requires and nothing before it provides.

        Where names or types are wrong nothing is concluded: not from a contract that has a mistake,
        nor from what comes after a statement that has one.
        """
        if self._poisoned.within(program.requires):
            return
        known = list(self.expand([*facts(program.requires), *self._to_do(program)]))
        for index, statement in enumerate(program.body):
            call = innermost(statement)
            callee = self.table.callable(call.callee)
            if callee is None or self._poisoned.within(statement):
                return
            here = [*known, *self._guarded(statement)]
            variables = {generator.variable for generator in loops(statement)}
            if not self._poisoned.within(callee.requires):
                for fact in self.contract(call, "requires"):
                    if not self._holds(fact, here, call, variables):
                        yield UnmetRequirement(program, index, call, fact, self._is_certain(fact))
                        if not free_names(fact) & variables:
                            known.append(fact)  # whatever provides it, provides it for later calls too
            if self._poisoned.within(callee.achieves) or _is_silent(callee):
                return
            known += self.promised(statement)

    def _to_do(self, program: ProgramDeclaration) -> list[Expression]:
        """Return what holds as long as a program runs: that the one fact that it is to achieve does not."""
        wanted = None if self._poisoned.within(program.achieves) else program.achieves
        is_one_fact = isinstance(wanted, Atom) or isinstance(wanted, Not) and isinstance(wanted.value, Atom)
        return [negated(wanted)] if wanted is not None and is_one_fact else []

    def promised(self, statement: Statement) -> list[Expression]:
        """Return what holds after the statement, of every element that it loops over."""
        call = innermost(statement)
        every: dict[str, Expression] = {each.variable: EVERY for each in loops(statement)}
        achieved = self.expand(self.contract(call, "achieves"))
        return [substitute(fact, every) for fact in achieved]

    def _guarded(self, statement: Statement) -> Iterator[Expression]:
        for guard in guards(statement):
            yield from self.expand(facts(guard))

    def _holds(
        self,
        fact: Expression,
        known: Sequence[Expression],
        call: nodes.Call,
        variables: Set[str],
        depth: int = MAX_DEPTH,
    ) -> bool:
        if any(implies(have, fact, self.members) for have in known) or self._is_excused(fact, call):
            return True
        if isinstance(fact, Or | nodes.And):
            some = any if isinstance(fact, Or) else all
            return some(self._holds(each, known, call, variables, depth) for each in fact.values)
        if isinstance(fact, Compare) and not self._is_reading(fact):
            return True  # about numbers that a caller passes: its own responsibility
        parts = self.parts(fact) if depth else []
        if not parts:
            return self._is_given(fact, variables)
        return all(self._holds(part, known, call, variables, depth - 1) for part in parts)

    def _is_given(self, fact: Expression, variables: Set[str]) -> bool:
        """Return whether a fact needs no call: nothing achieves it, and it is about what every scene has, or
        about a loop's variable, which skips other elements; or no api changes it, such as that the table is
        clear."""
        achievers = self.achievers(fact)
        subjects = free_names(fact) - set(self.members)
        if not achievers:
            return subjects <= set(self.table.constants) or bool(subjects & variables)
        is_changed = any(name in self.table.apis for name in achievers)
        return not is_changed and subjects <= set(self.table.constants) and not _is_vague(fact)

    def _is_excused(self, fact: Expression, call: nodes.Call) -> bool:
        """Return whether a call is due only while the fact holds: `put_down` requires holding(any), and is
        due only while empty(gripper) does not hold.

        The two must speak of the same things: that x is not held does not make the hand empty.
        """
        for achieved in self.expand(self.contract(call, "achieves")):
            if negated(achieved) == fact or self._same_reading(achieved, fact):
                return True
            is_changed = any(
                (kind, other) in self._opposites for kind in _kinds(fact) for other in _kinds(achieved)
            )
            if is_changed and self._subjects(achieved) == self._subjects(fact):
                return True
        return False

    def _subjects(self, fact: Expression) -> Set[str]:
        return free_names(fact) - set(self.table.constants) - set(self.members)

    def _same_reading(self, achieved: Expression, fact: Expression) -> bool:
        """Return whether the call changes the very reading that it requires."""
        if not isinstance(achieved, Compare) or not isinstance(fact, Compare):
            return False
        return normalised(achieved).left == normalised(fact).left

    def _is_reading(self, fact: Compare) -> bool:
        side = normalised(fact)
        written = value_of(side.right) is not None or isinstance(side.right, Name)
        return isinstance(side.left, Atom) and written

    def _is_certain(self, fact: Expression) -> bool:
        """Return whether only a contract can provide the fact; a number may change by itself."""
        return not any(
            isinstance(each, Compare) and not isinstance(normalised(each).right, Name) for each in walk(fact)
        ) or bool(self.achievers(fact))


def _kinds(fact: Expression) -> Iterator[Kind]:
    match fact:
        case Atom(predicate, _):
            yield True, predicate
        case Not(Atom(predicate, _)):
            yield False, predicate
        case Compare(_, left, right):
            for side in (left, right):
                if isinstance(side, Atom):
                    yield True, side.predicate
        case Or(values) | nodes.And(values):
            for value in values:
                yield from _kinds(value)


def _is_silent(callee: nodes.ApiDeclaration | ProgramDeclaration) -> bool:
    """Return whether a program lacks its promise (reported elsewhere), so that it may achieve anything."""
    return isinstance(callee, ProgramDeclaration) and callee.achieves is None


def _is_vague(fact: Expression) -> bool:
    return any(each == ANY for each in walk(fact))
