"""Checks of a task's success condition against what the program that it runs achieves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, Note
from ntp_dsl.language.logic.facts import facts, implies, substitute
from ntp_dsl.language.logic.preconditions import Contracts
from ntp_dsl.language.repairs.task_repairs import promise_of_call
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.nodes import Atom, Expression, ProgramDeclaration, TaskDeclaration
from ntp_dsl.language.syntax.visitors import conjuncts, free_names, predicates


def check_success(contracts: Contracts, task: TaskDeclaration) -> Iterator[Diagnostic]:
    """Check that a task's success condition is what the program that it runs achieves."""
    program = contracts.table.programs.get(task.run.callee) if task.run else None
    faulty = contracts.has_error(task) or contracts.has_error(program)
    if program is None or task.run is None or task.success is None or faulty:
        return
    shared = [argument for argument in task.run.arguments if free_names(argument) & free_names(task.success)]
    if program.achieves is None or not shared:
        return
    promised = contracts.promised(task.run)
    for part in conjuncts(task.success):
        if not predicates(part) <= set(contracts.table.predicates):
            continue  # no conclusions from an unclear predicate
        about = format_expression(part)
        unpromised = [fact for fact in facts(part) if not _is_promised(fact, promised, contracts)]
        if unpromised:
            message = f"'{program.name}' does not say that it achieves this: {about}"
            note = Note("what it achieves", program.achieves.span)
            yield Diagnostic("N501", message, part.span, (note,))
    yield from _check_quantifier(task, program)
    wanted, given = _elements(task.success), _elements(promise_of_call(program, task.run))
    if wanted is None or given is None or wanted[0] != given[0]:
        return
    for fact in wanted[1]:
        same = [each for each in given[1] if _predicate(each) == _predicate(fact) is not None]
        if same and fact not in same:
            yield _other_fields(task, program)
            return


def _check_quantifier(task: TaskDeclaration, program: ProgramDeclaration) -> Iterator[Diagnostic]:
    """Report `some … for p in goal`, where the program achieves it of all."""
    assert task.success is not None and task.run is not None
    promised = promise_of_call(program, task.run)
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
    """Return the list of `all … for p in goal`, and the facts about an element's fields."""
    match condition:
        case nodes.Quantified("all", body, (nodes.Generator(variable, domain, None),)):
            return domain.id, [substitute(fact, {variable: ELEMENT}) for fact in facts(body)]
    return None


def _predicate(fact: Expression) -> str | None:
    return fact.predicate if isinstance(fact, Atom) else None


def _other_fields(task: TaskDeclaration, program: ProgramDeclaration) -> Diagnostic:
    assert task.success is not None and task.run is not None and program.achieves is not None
    promised = promise_of_call(program, task.run)
    text = format_expression(promised) if promised is not None else ""
    message = f"'{program.name}' achieves the same, but of other fields: {text}"
    note = Note("what it achieves", program.achieves.span)
    fix = Fix(task.success.span, text) if text else None
    return Diagnostic("W503", message, task.success.span, (note,), fix=fix)
