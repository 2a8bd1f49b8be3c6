"""What would provide a fact that a call lacks: another order, a call before it, another call, a requirement.

Each is tried out: only what leaves the program with fewer lacks than before is proposed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ntp_dsl.language.diagnostics.diagnostics import Edit, Fix
from ntp_dsl.language.logic.facts import EVERY, facts, implies
from ntp_dsl.language.logic.preconditions import Contracts, Lack
from ntp_dsl.language.names.signatures import fits
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression, format_statement
from ntp_dsl.language.syntax.nodes import Atom, Expression, ProgramDeclaration, Span, Statement
from ntp_dsl.language.syntax.visitors import everything, innermost, loops, mentions

Proposal = tuple[ProgramDeclaration, Fix, str]  # the program afterwards, the edits, and what to do


def repair(contracts: Contracts, lack: Lack) -> tuple[Fix, str] | None:
    """The fix, and what it does in words."""
    before = sum(1 for _ in contracts.lacks(lack.program))
    groups = [_reordered, _preceded, _replaced, _required]
    if not contracts.achievers(lack.fact):
        groups = [_required]
    for group in groups:
        good = [
            (fix, words)
            for program, fix, words in group(contracts, lack)
            if sum(1 for _ in contracts.lacks(program)) < before
        ]
        if len(good) == 1:
            return good[0]
    return None


def _reordered(contracts: Contracts, lack: Lack) -> Iterator[Proposal]:
    """A later call provides it, and comes first."""
    body = lack.program.body
    for later in range(lack.index + 1, len(body)):
        if any(implies(have, lack.fact) for have in contracts.promised(body[later])):
            moved = [*range(lack.index), later, *range(lack.index, later), *range(later + 1, len(body))]
            order = tuple(body[index] for index in moved)
            fix = reorder(body, order)
            if fix is not None:
                words = f"call '{innermost(body[later]).callee}' first"
                yield replace(lack.program, body=order), fix, words


def reorder(body: tuple[Statement, ...], order: tuple[Statement, ...]) -> Fix | None:
    """Each statement's text in its new place; only where every statement that moves is one line."""
    changed = [(old, new) for old, new in zip(body, order, strict=True) if old is not new]
    if not all(isinstance(each, nodes.Call) for pair in changed for each in pair):
        return None
    edits = [Edit(old.span, "\n".join(format_statement(new))) for old, new in changed]
    return Fix(edits[0].span, edits[0].replacement, tuple(edits[1:])) if edits else None


def _preceded(contracts: Contracts, lack: Lack) -> Iterator[Proposal]:
    """A call of what achieves it comes before; a program rather than an api."""
    place = lack.program.body[lack.index].span
    proposals: dict[bool, list[Proposal]] = {True: [], False: []}
    for call in _calls_for(contracts, lack.fact, lack.program.name):
        if mentions_loop(call, lack):
            continue
        body = list(lack.program.body)
        body.insert(lack.index, call)
        text = format_statement(call)[0] + "\n" + " " * (place.column - 1)
        fix = Fix(Span(place.path, place.line, place.column, place.line, place.column), text)
        proposal = replace(lack.program, body=tuple(body)), fix, f"call {text.strip()} before it"
        proposals[call.callee in contracts.table.programs].append(proposal)
    yield from proposals[True] or proposals[False]


def mentions_loop(call: nodes.Call, lack: Lack) -> bool:
    variables = {each.variable for each in loops(lack.program.body[lack.index])}
    named = {name for argument in call.arguments for name in mentions(argument)}
    return bool(named & variables)


def _calls_for(contracts: Contracts, fact: Expression, besides: str) -> Iterator[nodes.Call]:
    """The calls that achieve a fact, with arguments that the fact names."""
    for name in contracts.achievers(fact):
        callee = contracts.table.callable(name)
        if callee is None or name == besides:
            continue
        for achieved in facts(callee.achieves):
            bound = _match(achieved, fact, {each.name for each in callee.parameters})
            if bound is not None and set(bound) == {each.name for each in callee.parameters}:
                yield nodes.Call(name, tuple(bound[each.name] for each in callee.parameters))
                break


def _match(pattern: Expression, fact: Expression, parameters: set[str]) -> dict[str, Expression] | None:
    """What the parameters stand for where a promise becomes the fact."""
    match pattern, fact:
        case nodes.Not(left), nodes.Not(right):
            return _match(left, right, parameters)
        case (Atom(), Atom()) | (nodes.Compare(), nodes.Compare()):
            bound: dict[str, Expression] = {}
            return bound if _bind_term(pattern, fact, parameters, bound) else None
    return None


def _bind_term(
    term: Expression, value: Expression, parameters: set[str], bound: dict[str, Expression]
) -> bool:
    """Whether the term becomes the value, with what its parameters then stand for."""
    if isinstance(value, nodes.Wildcard) or value == EVERY:
        return False
    match term, value:
        case nodes.Name(id), _ if id in parameters:
            return bound.setdefault(id, value) == value
        case Atom(name, terms), Atom(other, values):
            pairs = zip(terms, values, strict=False)
            same = name == other and len(terms) == len(values)
            return same and all(_bind_term(a, b, parameters, bound) for a, b in pairs)
        case nodes.Compare(sign, left, right), nodes.Compare(other, one, two):
            sides = ((left, one), (right, two))
            return sign == other and all(_bind_term(a, b, parameters, bound) for a, b in sides)
    return term == value


def _replaced(contracts: Contracts, lack: Lack) -> Iterator[Proposal]:
    """Another program that promises what this call does, and asks for less."""
    callee = contracts.table.callable(lack.call.callee)
    promises = contracts.contract(lack.call, "achieves")
    if callee is None or not promises:
        return
    for call in _calls_for(contracts, promises[0], lack.program.name):
        if call.callee == lack.call.callee or call.callee in contracts.table.apis:
            continue
        if not _takes_alike(contracts, callee, call.callee):
            continue
        body = list(lack.program.body)
        body[lack.index] = _with_call(body[lack.index], call)
        text = format_statement(call)[0]
        words = f"call '{call.callee}' instead, which asks for less"
        yield replace(lack.program, body=tuple(body)), Fix(lack.call.span, text), words


def _takes_alike(contracts: Contracts, callee: nodes.ApiDeclaration | ProgramDeclaration, other: str) -> bool:
    """Whether another program takes whatever this one does."""
    meant = contracts.table.callable(other)
    pairs = zip(callee.parameters, meant.parameters if meant else (), strict=False)
    return all(fits(contracts.table, given.type, wanted.type) for given, wanted in pairs)


def _with_call(statement: Statement, call: nodes.Call) -> Statement:
    if isinstance(statement, nodes.Call):
        return call
    return replace(statement, body=_with_call(statement.body, call))


def _required(contracts: Contracts, lack: Lack) -> Iterator[Proposal]:
    """The program asks its caller for it, and for whatever else the call lacks that nobody achieves."""
    program = lack.program
    if not _can_ask(contracts, lack):
        return
    facts_asked = [lack.fact]
    if not contracts.achievers(lack.fact):
        facts_asked = [
            each.fact
            for each in contracts.lacks(program)
            if not contracts.achievers(each.fact)
            if _can_ask(contracts, each)
        ]
    wanted = facts_asked[0] if len(facts_asked) == 1 else nodes.And(tuple(facts_asked))
    fix = add_requirement(program, wanted)
    if fix is not None:
        old = program.requires
        whole = wanted if old is None else nodes.And((old, wanted), span=old.span)
        words = f"add it to what '{program.name}' requires"
        yield replace(program, requires=whole), fix, words


def _can_ask(contracts: Contracts, lack: Lack) -> bool:
    """Whether a caller would know what is spoken of."""
    sight = {each.name for each in lack.program.parameters} | set(contracts.table.constants)
    known = mentions(lack.fact) <= sight | set(contracts.members)
    return known and not any(each == EVERY for each in everything(lack.fact))


def add_requirement(program: ProgramDeclaration, fact: Expression) -> Fix | None:
    """`and FACT` at the end of what is required, or a clause of its own."""
    required = program.requires
    text = format_expression(fact)
    if isinstance(fact, nodes.Or):
        text = f"({text})"
    if required is None:
        return add_clause(program, f"requires {text}")
    if isinstance(required, nodes.Or):
        closing = Edit(_end(required.span), f") and {text}")
        return Fix(_start(required.span), "(", (closing,))
    if _is_open(required):
        return Fix(_start(required.span), f"{text} and ")
    return Fix(_end(required.span), f" and {text}")


def add_clause(program: ProgramDeclaration, clause: str) -> Fix | None:
    """A line of the contract: below the other one, or above the first statement."""
    other = program.requires or program.achieves
    margin = " " * (program.body[0].span.column - 1) if program.body else "    "
    if other is not None and other.span.line > program.name_span.line:
        return Fix(_end(other.span), f"\n{margin}{clause}")
    if program.body and program.body[0].span.line > program.name_span.line:
        return Fix(_start(program.body[0].span), f"{clause}\n{margin}")
    return None


def _is_open(condition: Expression) -> bool:
    """Whether what follows would be taken into a quantifier."""
    if isinstance(condition, nodes.And):
        return _is_open(condition.values[-1])
    if isinstance(condition, nodes.Not):
        return _is_open(condition.value)
    return isinstance(condition, nodes.Quantified)


def _start(span: Span) -> Span:
    return Span(span.path, span.line, span.column, span.line, span.column)


def _end(span: Span) -> Span:
    return Span(span.path, span.end_line, span.end_column, span.end_line, span.end_column)


def promise(contracts: Contracts, program: ProgramDeclaration) -> Expression | None:
    """What a program that does not say so probably achieves: what its last call does."""
    if not program.body:
        return None
    statement = program.body[-1]
    said = contracts.contract(innermost(statement), "achieves")
    names = {each.name for each in program.parameters} | set(contracts.table.constants)
    generators: list[nodes.Generator] = []
    while not isinstance(statement, nodes.Call):
        if isinstance(statement, nodes.When):
            return None
        generators.append(statement.generator)
        statement = statement.body
    names |= {each.variable for each in generators}
    kept = [fact for fact in said if mentions(fact) <= names and EVERY not in everything(fact)]
    if not kept:
        return None
    whole = kept[0] if len(kept) == 1 else nodes.And(tuple(kept))
    return nodes.Quantified("all", whole, tuple(generators)) if generators else whole
