"""Whether what a call requires can hold when its turn comes, as far as that can be decided."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Set

from ntp_dsl.language import syntax
from ntp_dsl.language.diagnostics import Diagnostic, Note
from ntp_dsl.language.formatter import format_expression
from ntp_dsl.language.names import Table
from ntp_dsl.language.signatures import head
from ntp_dsl.language.syntax import Atom, Expression, Field, Name, ProgramDeclaration, Statement
from ntp_dsl.language.walks import innermost, loops, mentions

Literal = tuple[bool, Atom]  # a predicate that holds, or does not
Kind = tuple[bool, str]

EVERY = Name("*")  # stands for each element of a loop; no text can spell it


def literals(condition: Expression | None, holds: bool = True) -> Iterator[Literal]:
    """The predicates that a condition surely settles; alternatives and comparisons settle none."""
    match condition:
        case Atom():
            yield holds, condition
        case syntax.Not(value):
            yield from literals(value, not holds)
        case syntax.And(values) if holds:
            for value in values:
                yield from literals(value)
        case syntax.Quantified(_, body, generators) if holds:
            every: dict[str, Expression] = {each.variable: EVERY for each in generators}
            for positive, atom in literals(body):
                yield positive, _substitute_atom(atom, every)


def _substitute_atom(atom: Atom, values: Mapping[str, Expression]) -> Atom:
    return Atom(atom.predicate, tuple(_substitute(each, values) for each in atom.arguments))


def _substitute(term: Expression, values: Mapping[str, Expression]) -> Expression:
    if isinstance(term, Name):
        return values.get(term.id, term)
    if isinstance(term, Field):
        value = values.get(term.value.id, term.value)
        return Field(value, term.name) if isinstance(value, Name) and value != EVERY else EVERY
    if isinstance(term, Atom):
        return _substitute_atom(term, values)
    return term


def _matches(needed: Literal, provided: Literal) -> bool:
    if (needed[0], needed[1].predicate) != (provided[0], provided[1].predicate):
        return False
    pairs = zip(needed[1].arguments, provided[1].arguments, strict=True)
    return all(
        need == have or isinstance(need, syntax.Wildcard) or EVERY in (need, have)
        for need, have in pairs
    )


class Contracts:
    """Whether each requirement of a call is provided before it: by contract, earlier call or loop.

    Everything that the table's contracts and predicates mention must be in the table.
    """

    def __init__(self, table: Table) -> None:
        self._table = table
        callables: list[syntax.ApiDeclaration | syntax.ProgramDeclaration] = []
        callables += [*table.apis.values(), *table.programs.values()]
        self._achievers: dict[Kind, list[str]] = {}
        for each in callables:
            for kind in self._kinds(each.achieves):
                self._achievers.setdefault(kind, []).append(each.name)
        self._opposites = self._find_opposites()

    def _kinds(self, condition: Expression | None) -> Set[Kind]:
        return {(holds, atom.predicate) for holds, atom in self._expand(literals(condition))}

    def _find_opposites(self) -> Set[tuple[Kind, Kind]]:
        """Facts that apis turn into one another (grasp: empty to holding, release: back) exclude
        one another: a call that provides one is due only while the other holds."""
        turns = {
            (before, after)
            for api in self._table.apis.values()
            for before in self._kinds(api.requires)
            for after in self._kinds(api.achieves)
        }
        return {(before, after) for before, after in turns if (after, before) in turns}

    def _expand(self, facts: Iterable[Literal], depth: int = 8) -> Iterator[Literal]:
        """The facts, and what composed predicates among them say."""
        for holds, atom in facts:
            yield holds, atom
            declared = self._table.predicates[atom.predicate]
            if holds and declared.body is not None and depth:
                values = _bind(declared.parameters, atom.arguments)
                parts = ((flag, _substitute_atom(a, values)) for flag, a in literals(declared.body))
                yield from self._expand(parts, depth - 1)

    def check(self, program: ProgramDeclaration) -> Iterator[Diagnostic]:
        """What is wrong with one program's calls; all its callees must be in the table."""
        known = list(self._expand(literals(program.requires)))
        for statement in program.body:
            call = innermost(statement)
            here = [*known, *self._expand(_conditions(statement))]
            variables = {generator.variable for generator in loops(statement)}
            for needed in self._contract(call, "requires"):
                if not self._holds(needed, here, call, variables):
                    yield self._missing(needed, call, program)
            every: dict[str, Expression] = dict.fromkeys(variables, EVERY)
            achieved = (
                (h, _substitute_atom(a, every)) for h, a in self._contract(call, "achieves")
            )
            known += self._expand(achieved)

    def _contract(self, call: syntax.Call, side: str) -> list[Literal]:
        """What the callee requires or achieves, in the caller's terms."""
        callee = self._table.callable(call.callee)
        assert callee is not None
        values = _bind(callee.parameters, call.arguments)
        condition = getattr(callee, side)
        return [(holds, _substitute_atom(atom, values)) for holds, atom in literals(condition)]

    def _holds(
        self, needed: Literal, known: list[Literal], call: syntax.Call, variables: Set[str]
    ) -> bool:
        holds, atom = needed
        if any(_matches(needed, fact) for fact in known) or self._is_excused(needed, call):
            return True
        if (holds, atom.predicate) not in self._achievers:
            # A fact that nobody achieves is taken as given for what every scene has, and a loop
            # passes over the elements that lack it.
            return mentions(atom) <= set(self._table.constants) or bool(mentions(atom) & variables)
        parts = self._parts(needed)
        return bool(parts) and all(self._holds(part, known, call, variables) for part in parts)

    def _is_excused(self, needed: Literal, call: syntax.Call) -> bool:
        """`put_down` requires holding(any), and is due only while empty(gripper) does not hold.

        The two must speak of the same things: that x is not held does not make the hand empty.
        """
        kind = needed[0], needed[1].predicate
        return any(
            (kind, (holds, atom.predicate)) in self._opposites
            and self._subjects(atom) == self._subjects(needed[1])
            or (not holds, atom) == needed
            for holds, atom in self._contract(call, "achieves")
        )

    def _subjects(self, atom: Atom) -> Set[str]:
        return mentions(atom) - set(self._table.constants)

    def _parts(self, needed: Literal) -> list[Literal]:
        """What a composed predicate is made of, where it is nothing but a conjunction."""
        holds, atom = needed
        body = self._table.predicates[atom.predicate].body
        if not holds or not isinstance(body, syntax.And | Atom):
            return []
        parts = list(literals(body))
        if len(parts) != len(body.values if isinstance(body, syntax.And) else (body,)):
            return []
        values = _bind(self._table.predicates[atom.predicate].parameters, atom.arguments)
        return [(flag, _substitute_atom(part, values)) for flag, part in parts]

    def _missing(
        self, needed: Literal, call: syntax.Call, program: ProgramDeclaration
    ) -> Diagnostic:
        holds, atom = needed
        fact = format_expression(atom if holds else syntax.Not(atom)).replace(EVERY.id, "any")
        callee = self._table.callable(call.callee)
        assert callee is not None
        message = f"'{call.callee}' requires {fact}, and nothing provides that before it"
        help = f"add it to what '{program.name}' requires"
        achievers = [name for name in self._achievers.get((holds, atom.predicate), ())
                     if name != program.name]  # fmt: skip
        if achievers:
            help = f"call what achieves it ({', '.join(achievers)}) before, or {help}"
        note = Note(f"'{callee.name}' is declared here", callee.name_span)
        return Diagnostic("E403", message, head(call.span, call.callee), (note,), help)


def _bind(
    parameters: Iterable[syntax.Parameter], arguments: Iterable[Expression]
) -> dict[str, Expression]:
    return {each.name: value for each, value in zip(parameters, arguments, strict=False)}


def _conditions(statement: Statement) -> Iterator[Literal]:
    """What loops' filters and `when` say about the call inside."""
    while not isinstance(statement, syntax.Call):
        if isinstance(statement, syntax.For):
            yield from literals(statement.generator.condition)
        else:
            yield from literals(statement.condition)
        statement = statement.body
