"""Offers for unmet requirements: another order, a call before, another call, or a requirement of its own.

Each is tried: only what leaves the program with fewer unmet requirements is offered.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import permutations

from ntp_dsl.language.diagnostics.diagnostics import Edit, Fix
from ntp_dsl.language.logic.facts import EVERY, facts, implies
from ntp_dsl.language.logic.preconditions import Contracts, UnmetRequirement
from ntp_dsl.language.names.signatures import fits
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression, format_statement
from ntp_dsl.language.syntax.nodes import Atom, Expression, ProgramDeclaration, Span, Statement, TypeName
from ntp_dsl.language.syntax.visitors import free_names, innermost, loops, walk

MAX_ARGUMENTS = 4  # of which every order is tried
Proposal = tuple[ProgramDeclaration, Fix, str]  # the program afterwards, the fix, and what to do in words


def repair(contracts: Contracts, unmet: UnmetRequirement) -> tuple[Fix, str] | None:
    """Return the fix, and what it does in words."""
    before = sum(1 for _ in contracts.unmet(unmet.program))
    groups = [_swapped, _reordered, _preceded, _replaced, _required]
    if not contracts.achievers(unmet.fact):
        groups = [_swapped, _required]
    for group in groups:
        good = [
            (fix, words)
            for program, fix, words in group(contracts, unmet)
            if sum(1 for _ in contracts.unmet(program)) < before
        ]
        if len(good) == 1:
            return good[0]
    return None


def _swapped(contracts: Contracts, unmet: UnmetRequirement) -> Iterator[Proposal]:
    """Propose the call with its arguments in another order, if their types fit in it."""
    callee = contracts.table.callable(unmet.call.callee)
    if callee is None or len(unmet.call.arguments) > MAX_ARGUMENTS:
        return
    names = _types(contracts, unmet)
    wanted = [each.type for each in callee.parameters]
    for arguments in dict.fromkeys(permutations(unmet.call.arguments)):
        types = [_type_of(each, names, contracts) for each in arguments]
        fit = all(
            each and fits(contracts.table, each, type) for each, type in zip(types, wanted, strict=False)
        )
        if arguments != unmet.call.arguments and fit:
            call = nodes.Call(callee.name, arguments)
            body = list(unmet.program.body)
            body[unmet.index] = _with_call(body[unmet.index], call)
            text = format_statement(call)[0]
            words = f"give its arguments in the other order: {text}"
            yield replace(unmet.program, body=tuple(body)), Fix(unmet.call.span, text), words


def _types(contracts: Contracts, unmet: UnmetRequirement) -> dict[str, TypeName]:
    """Return the types of the names in scope at the call."""
    names = {each.name: each.type for each in unmet.program.parameters}
    for loop in loops(unmet.program.body[unmet.index]):
        names[loop.variable] = TypeName(names.get(loop.iterable.id, TypeName(loop.iterable.id)).name)
    return names | {each.name: each.type for each in contracts.table.constants.values()}


def _type_of(value: Expression, names: Mapping[str, TypeName], contracts: Contracts) -> TypeName | None:
    match value:
        case nodes.Name(id):
            return names.get(id)
        case nodes.Field(nodes.Name(id), name) if id in names:
            record = contracts.table.records.get(names[id].name)
            fields = {each.name: each.type for each in record.fields} if record else {}
            return fields.get(name)
    return None


def _reordered(contracts: Contracts, unmet: UnmetRequirement) -> Iterator[Proposal]:
    """Propose to move a later call that provides it to the front."""
    body = unmet.program.body
    for later in range(unmet.index + 1, len(body)):
        if any(implies(have, unmet.fact) for have in contracts.promised(body[later])):
            moved = [*range(unmet.index), later, *range(unmet.index, later), *range(later + 1, len(body))]
            order = tuple(body[index] for index in moved)
            fix = reorder(body, order)
            if fix is not None:
                words = f"call '{innermost(body[later]).callee}' first"
                yield replace(unmet.program, body=order), fix, words


def reorder(body: tuple[Statement, ...], order: tuple[Statement, ...]) -> Fix | None:
    """Write each statement in its new place; only where every statement that moves is one line."""
    changed = [(old, new) for old, new in zip(body, order, strict=True) if old is not new]
    if not all(isinstance(each, nodes.Call) for pair in changed for each in pair):
        return None
    edits = [Edit(old.span, "\n".join(format_statement(new))) for old, new in changed]
    return Fix(edits[0].span, edits[0].replacement, tuple(edits[1:])) if edits else None


def _preceded(contracts: Contracts, unmet: UnmetRequirement) -> Iterator[Proposal]:
    """Propose to call what achieves it before; a program rather than an api."""
    place = unmet.program.body[unmet.index].span
    proposals: dict[bool, list[Proposal]] = {True: [], False: []}
    for call in _calls_for(contracts, unmet.fact, unmet.program.name):
        if _names_loop_variable(call, unmet):
            continue
        body = list(unmet.program.body)
        body.insert(unmet.index, call)
        text = format_statement(call)[0] + "\n" + " " * (place.column - 1)
        fix = Fix(Span(place.path, place.line, place.column, place.line, place.column), text)
        proposal = replace(unmet.program, body=tuple(body)), fix, f"call {text.strip()} before it"
        proposals[call.callee in contracts.table.programs].append(proposal)
    yield from proposals[True] or proposals[False]


def _names_loop_variable(call: nodes.Call, unmet: UnmetRequirement) -> bool:
    variables = {each.variable for each in loops(unmet.program.body[unmet.index])}
    named = {name for argument in call.arguments for name in free_names(argument)}
    return bool(named & variables)


def _calls_for(contracts: Contracts, fact: Expression, besides: str) -> Iterator[nodes.Call]:
    """Yield the calls that achieve a fact, with arguments that the fact names."""
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
    """Return the arguments for which the pattern of a promise is the fact."""
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
    """Return whether the term matches the value; bind its parameters."""
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


def _replaced(contracts: Contracts, unmet: UnmetRequirement) -> Iterator[Proposal]:
    """Propose to call another program that promises the same and requires less."""
    callee = contracts.table.callable(unmet.call.callee)
    promises = contracts.contract(unmet.call, "achieves")
    if callee is None or not promises:
        return
    for call in _calls_for(contracts, promises[0], unmet.program.name):
        if call.callee == unmet.call.callee or call.callee in contracts.table.apis:
            continue
        if not _takes_alike(contracts, callee, call.callee):
            continue
        body = list(unmet.program.body)
        body[unmet.index] = _with_call(body[unmet.index], call)
        text = format_statement(call)[0]
        words = f"call '{call.callee}' instead, which requires less"
        yield replace(unmet.program, body=tuple(body)), Fix(unmet.call.span, text), words


def _takes_alike(contracts: Contracts, callee: nodes.ApiDeclaration | ProgramDeclaration, other: str) -> bool:
    """Return whether another program takes whatever this one does."""
    meant = contracts.table.callable(other)
    pairs = zip(callee.parameters, meant.parameters if meant else (), strict=False)
    return all(fits(contracts.table, given.type, wanted.type) for given, wanted in pairs)


def _with_call(statement: Statement, call: nodes.Call) -> Statement:
    if isinstance(statement, nodes.Call):
        return call
    return replace(statement, body=_with_call(statement.body, call))


def _required(contracts: Contracts, unmet: UnmetRequirement) -> Iterator[Proposal]:
    """Propose that the program requires it, and whatever else is unmet that nothing achieves."""
    program = unmet.program
    if not _can_ask(contracts, unmet):
        return
    facts_asked = [unmet.fact]
    if not contracts.achievers(unmet.fact):
        facts_asked = [
            each.fact
            for each in contracts.unmet(program)
            if not contracts.achievers(each.fact)
            if _can_ask(contracts, each)
        ]
    wanted = facts_asked[0] if len(facts_asked) == 1 else nodes.And(tuple(facts_asked))
    fix = add_requirement(program, wanted)
    if fix is not None:
        old = program.requires
        whole = wanted if old is None else nodes.And((old, wanted), span=old.span)
        words = f"add it to what '{program.name}' requires"
        if isinstance(program.body[unmet.index], nodes.When):
            words += ", or to the condition of its 'when'"
        yield replace(program, requires=whole), fix, words


def _can_ask(contracts: Contracts, unmet: UnmetRequirement) -> bool:
    """Return whether a caller knows all names of the fact."""
    scope = {each.name for each in unmet.program.parameters} | set(contracts.table.constants)
    known = free_names(unmet.fact) <= scope | set(contracts.members)
    return known and not any(each == EVERY for each in walk(unmet.fact))


def add_requirement(program: ProgramDeclaration, fact: Expression) -> Fix | None:
    """Write `and FACT` at the end of what is required, or a clause of its own."""
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
    """Write a line of the contract: below the other one, or above the first statement."""
    other = program.requires or program.achieves
    margin = " " * (program.body[0].span.column - 1) if program.body else "    "
    if other is not None and other.span.line > program.name_span.line:
        return Fix(_end(other.span), f"\n{margin}{clause}")
    if program.body and program.body[0].span.line > program.name_span.line:
        return Fix(_start(program.body[0].span), f"{clause}\n{margin}")
    return None


def _is_open(condition: Expression) -> bool:
    """Return whether what follows would be read as part of a quantifier."""
    if isinstance(condition, nodes.And):
        return _is_open(condition.values[-1])
    if isinstance(condition, nodes.Not):
        return _is_open(condition.value)
    return isinstance(condition, nodes.Quantified)


def _start(span: Span) -> Span:
    return Span(span.path, span.line, span.column, span.line, span.column)


def _end(span: Span) -> Span:
    return Span(span.path, span.end_line, span.end_column, span.end_line, span.end_column)


def likely_promise(contracts: Contracts, program: ProgramDeclaration) -> Expression | None:
    """Return what a program without a promise probably achieves: what its last call does."""
    if not program.body:
        return None
    statement = program.body[-1]
    achieved = contracts.contract(innermost(statement), "achieves")
    names = {each.name for each in program.parameters} | set(contracts.table.constants)
    generators: list[nodes.Generator] = []
    while not isinstance(statement, nodes.Call):
        if isinstance(statement, nodes.When):
            return None
        generators.append(statement.generator)
        statement = statement.body
    names |= {each.variable for each in generators}
    kept = [fact for fact in achieved if free_names(fact) <= names and EVERY not in walk(fact)]
    if not kept:
        return None
    whole = kept[0] if len(kept) == 1 else nodes.And(tuple(kept))
    return nodes.Quantified("all", whole, tuple(generators)) if generators else whole
