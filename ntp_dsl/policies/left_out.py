"""Why a statement of a body leads to no call: its condition, its elements, or what its calls would find."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from msgspec.structs import replace as with_fields

from ntp_dsl.language.registry import Api, Program
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.visitors import innermost
from ntp_dsl.policies.evidence import BodyStatement, body_statements, evidence
from ntp_dsl.policies.expert import Expert, NextCall, Return
from ntp_dsl.semantics.facts import Bindings, Fact
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.shortfalls import some_of, why_empty, why_false, why_not
from ntp_dsl.semantics.state import State
from ntp_dsl.traces.decision import StatementStatus, Status
from ntp_dsl.traces.phrases import format_invocation

DEPTH = 4  # of calls below one another that are opened


def told_evidence(
    expert: Expert, row: Program, arguments: tuple[Argument, ...], state: State, is_unfinished: bool
) -> tuple[tuple[Fact, ...], tuple[StatementStatus, ...]]:
    """Return what a decision rests on; where a program returns unfinished, with why nothing is called."""
    grounds, statements = evidence(expert, row, arguments, state)
    if is_unfinished:
        scope, body = row.bind(arguments), body_statements(expert, row, arguments, state)
        statements = tuple(
            with_fields(each.record, why=why_left_out(expert, each, scope, state)) for each in body
        )
    return grounds, statements


def why_left_out(expert: Expert, each: BodyStatement, scope: Bindings, state: State, depth: int = 0) -> str:
    """Return why a statement leads to no call, in words; empty where its status says all.

    Args:
        scope: of the program's parameters.
        depth: of programs that were opened on the way here.
    """
    match each.status:
        case Status.ABSENT:
            return some_of(dict.fromkeys(_absent(each.statement, scope, state)))
        case Status.ACHIEVED:
            filtered = some_of(dict.fromkeys(_filtered(each.statement, scope, state)))
            return f"others are left out, as {filtered}" if filtered else ""
        case Status.VAIN if each.call is not None:
            return _in_vain(expert, each.call, state, depth)
        case Status.DUE if does_nothing(expert, each, state):
            assert each.call is not None
            return _in_vain(expert, each.call, state, depth)
        case Status.VAIN if each.instance is not None and each.instance.lacking is not None:
            call, lacks = each.instance.lacking
            told = some_of(why_not(fact, state) for fact in sorted(lacks, key=str))
            return f"for {format_invocation(call.callee, call.arguments)}, {told}"
    return ""


def does_nothing(expert: Expert, each: BodyStatement, state: State) -> bool:
    """Return whether a statement that is due calls a program that would return at once."""
    if each.call is None or each.lacks or each.call.callee not in expert.registry.programs:
        return False
    answer = expert.decide(each.call.callee, each.call.arguments, state)
    return isinstance(answer, Return) and not answer.done


def _filtered(statement: nodes.Statement, scope: Bindings, state: State) -> Iterator[str]:
    """Yield why a loop calls nothing for some elements of a list that it goes through."""
    match statement:
        case nodes.When(condition=condition, body=body):
            yield from why_false(condition, scope, state)
            yield from _filtered(body, scope, state)
        case nodes.For(generator=generator, body=body) if generator.iterable.id in scope:
            for inner in state.elements(replace(generator, condition=None), scope):
                if generator.condition is not None:
                    yield from why_false(generator.condition, inner, state)
                yield from _filtered(body, inner, state)


def _absent(statement: nodes.Statement, scope: Bindings, state: State) -> Iterator[str]:
    match statement:
        case nodes.When(condition=condition, body=body):
            if state.true(condition, scope):
                yield from _absent(body, scope, state)
            else:
                yield from why_false(condition, scope, state)
        case nodes.For(generator=generator, body=body):
            elements = [*state.elements(generator, scope)]
            if not elements:
                yield from why_empty(generator, scope, state)
            for inner in elements:
                yield from _absent(body, inner, state)


def _in_vain(expert: Expert, call: NextCall, state: State, depth: int) -> str:
    """Return why a call would return at once: what it lacks, or why each of its statements leads to none."""
    callee = expert.registry[call.callee]
    scope = callee.bind(call.arguments)
    lacks = [fact for fact in state.contract(callee.name, call.arguments).requires if not state.holds(fact)]
    if lacks:
        return some_of(why_not(fact, state) for fact in lacks)
    if isinstance(callee, Api):
        return ""
    if callee.in_python:
        return f"the expert of '{callee.name}' in Python offers no call"
    if depth == DEPTH:
        return ""
    told = []
    is_opened = False  # of several calls in vain the first is opened: there may be many below one another
    for each in body_statements(expert, callee, call.arguments, state):
        is_due = each.status is Status.DUE
        is_vain = each.status is Status.VAIN or (is_due and does_nothing(expert, each, state))
        reason = "" if is_vain and is_opened else why_left_out(expert, each, scope, state, depth + 1)
        is_opened |= is_vain
        called = innermost(each.statement).callee
        invoked = format_invocation(each.call.callee, each.call.arguments) if each.call else called
        if each.status is Status.ABSENT:
            told.append(f"{_place(each)} {invoked} is left out, as {reason}")
        elif is_vain:
            told.append(f"{_place(each)} {invoked} would do nothing" + f" ({reason})" * bool(reason))
        elif each.status is Status.DUE and each.lacks:
            told.append(f"{_place(each)} {invoked} lacks {', '.join(each.lacks)}")
    return "; ".join(told)


def _place(each: BodyStatement) -> str:
    path = each.statement.span.path
    return f"{path.name}:{each.span.line}" if path is not None else f"line {each.span.line}"
