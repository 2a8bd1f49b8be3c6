"""Whether a task is judged by what the program that it runs achieves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, Note
from ntp_dsl.language.logic.facts import facts, implies, substitute
from ntp_dsl.language.logic.preconditions import Contracts
from ntp_dsl.language.repairs.task_repairs import said_of
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.nodes import Atom, Expression, ProgramDeclaration, TaskDeclaration
from ntp_dsl.language.syntax.visitors import conjuncts, mentions, predicates


def check_success(contracts: Contracts, task: TaskDeclaration) -> Iterator[Diagnostic]:
    """Check that a task's success condition is what the program that it runs achieves."""
    program = contracts.table.programs.get(task.run.callee) if task.run else None
    faulty = contracts.is_faulty(task) or contracts.is_faulty(program)
    if program is None or task.run is None or task.success is None or faulty:
        return
    told = [argument for argument in task.run.arguments if mentions(argument) & mentions(task.success)]
    if program.achieves is None or not told:
        return
    promised = contracts.promised(task.run)
    for part in conjuncts(task.success):
        if not predicates(part) <= set(contracts.table.predicates):
            continue  # of what is wrong itself nothing is concluded
        about = format_expression(part)
        lacking = [fact for fact in facts(part) if not _is_promised(fact, promised, contracts)]
        if lacking:
            message = f"'{program.name}' does not say that it achieves this: {about}"
            note = Note("what it achieves", program.achieves.span)
            yield Diagnostic("N501", message, part.span, (note,))
    yield from _check_quantifier(task, program)
    asked, given = _elements(task.success), _elements(said_of(program, task.run))
    if asked is None or given is None or asked[0] != given[0]:
        return
    for fact in asked[1]:
        same = [each for each in given[1] if _predicate(each) == _predicate(fact) is not None]
        if same and fact not in same:
            yield _turned_round(task, program)
            return


def _check_quantifier(task: TaskDeclaration, program: ProgramDeclaration) -> Iterator[Diagnostic]:
    """`some … for p in goal`, where the program achieves it of all."""
    assert task.success is not None and task.run is not None
    promised = said_of(program, task.run)
    if isinstance(task.success, nodes.Quantified) and task.success.quantifier == "some":
        if promised is not None and replace(task.success, quantifier="all") == promised:
            message = f"one element of the goal would be enough, and '{program.name}' achieves all"
            text = format_expression(promised)
            yield Diagnostic("W503", message, task.success.span, fix=Fix(task.success.span, text))


def _is_promised(fact: Expression, promised: Sequence[Expression], contracts: Contracts) -> bool:
    if any(implies(have, fact, contracts.members) for have in promised):
        return True
    parts = contracts.parts(fact)
    return bool(parts) and all(_is_promised(part, promised, contracts) for part in parts)


ELEMENT = nodes.Name("element")


def _elements(condition: Expression | None) -> tuple[str, list[Expression]] | None:
    """Of `all … for p in goal`: the list, and what is said of an element by its fields."""
    match condition:
        case nodes.Quantified("all", body, (nodes.Generator(variable, domain, None),)):
            return domain.id, [substitute(fact, {variable: ELEMENT}) for fact in facts(body)]
    return None


def _predicate(fact: Expression) -> str | None:
    return fact.predicate if isinstance(fact, Atom) else None


def _turned_round(task: TaskDeclaration, program: ProgramDeclaration) -> Diagnostic:
    assert task.success is not None and task.run is not None and program.achieves is not None
    promised = said_of(program, task.run)
    text = format_expression(promised) if promised is not None else ""
    message = f"'{program.name}' achieves the like, but of other fields: {text}"
    note = Note("what it achieves", program.achieves.span)
    fix = Fix(task.success.span, text) if text else None
    return Diagnostic("W503", message, task.success.span, (note,), fix=fix)
