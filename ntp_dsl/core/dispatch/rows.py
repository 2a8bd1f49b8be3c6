"""A program's row (M_prog): its declaration unrolled in the present.

A node for each call that its body may stand for, and one for each ground fact that contracts name; an edge
where a call provides a fact or requires it. No name enters, and no size hangs on a library.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ntp_dsl.core.perception.perceived import Believed
from ntp_dsl.language.registry import Program
from ntp_dsl.language.syntax import nodes
from ntp_dsl.policies.expert import NextCall
from ntp_dsl.semantics.facts import Bindings, Condition, Fact
from ntp_dsl.semantics.observation import Argument, Record
from ntp_dsl.semantics.parts import Wanted
from ntp_dsl.semantics.predicates import ANY

POSSIBLE = 0.02  # a guard that holds less probably than this makes no call

Edge = tuple[int, int]  # a call and a fact
Named = tuple[Any, ...]  # arguments without numbers
Key = tuple[int, str, Named, int]  # of a call: its statement, callee and arguments, and which of like ones


@dataclass(frozen=True)
class Row:
    """A program in the present."""

    calls: tuple[NextCall, ...]  # in the order of the body, and of the elements of its loops
    statements: tuple[int, ...]  # of each call
    guards: tuple[Any, ...]  # how probably the conditions around each call hold
    facts: tuple[Fact, ...]
    probabilities: tuple[Any, ...]  # of the facts
    achieved: tuple[int, ...]  # facts that the program achieves
    required: tuple[int, ...]  # and that it requires
    provides: tuple[Edge, ...]
    requires: tuple[Edge, ...]

    @cached_property
    def keys(self) -> list[Key]:
        """Return what tells calls apart: not their numbers, which depend on where objects are."""
        counts: Counter[tuple[int, str, Named]] = Counter()
        keys: list[Key] = []
        for statement, call in zip(self.statements, self.calls, strict=True):
            like = statement, call.callee, named(call.arguments)
            keys.append((*like, counts[like]))
            counts[like] += 1
        return keys

    @property
    def achievement(self) -> float:
        """How probably all holds that the program achieves."""
        return min((float(self.probabilities[at]) for at in self.achieved), default=1.0)


def named(arguments: Sequence[Argument]) -> Named:
    """Return the objects and members among arguments, and in their lists and records."""
    return tuple(
        named([value for _, value in each.fields])
        if isinstance(each, Record)
        else named(each)
        if isinstance(each, tuple)
        else each
        for each in arguments
        if not isinstance(each, float)
    )


def unrolled(program: Program, arguments: tuple[Argument, ...], state: Believed) -> Row:
    """Return a running program's row."""
    scope = program.bind(arguments)
    facts: dict[Fact, int] = {}

    def number(fact: Fact) -> int:
        return facts.setdefault(fact, len(facts))

    contract = state.contract(program.name, arguments)
    achieved, required = tuple(map(number, contract.achieves)), tuple(map(number, contract.requires))
    calls: list[NextCall] = []
    statements: list[int] = []
    guards: list[Any] = []
    provided: list[tuple[Fact, ...]] = []
    requires: list[Edge] = []
    for index, statement in enumerate(program.body):
        for call, inner, guard in _calls(statement, scope, 1.0, state):
            given = tuple([state.value(term, inner) for term in call.arguments])
            own = state.contract(call.callee, given)
            requires += [(len(calls), number(fact)) for fact in own.requires]
            provided.append(own.achieves)
            calls.append(NextCall(call.callee, given, call.span))
            statements.append(index)
            guards.append(guard)
    for each in provided:
        for fact in each:
            number(fact)
    vague = [(fact, at) for fact, at in facts.items() if isinstance(fact, Condition) or ANY in fact.arguments]
    wanted = Wanted(facts, state)
    provides = [
        (call, at)
        for call, given_facts in enumerate(provided)
        for at in sorted(
            {facts[each] for each in (*given_facts, *wanted.helped_by(given_facts))}
            | _implied(given_facts, vague, state)
        )
    ]
    return Row(
        tuple(calls),
        tuple(statements),
        tuple(guards),
        tuple(facts),
        tuple(state.probability(fact) for fact in facts),
        achieved,
        required,
        tuple(provides),
        tuple(requires),
    )


def _implied(given: Sequence[Fact], vague: Sequence[tuple[Fact, int]], state: Believed) -> set[int]:
    """Return the facts of any object that facts of one imply, and the conditions that they help.

    What holds already helps no more: a call is done where its own facts hold, though a condition does not.
    """
    is_done = all(state.probability(each) > 0.5 for each in given)
    return {
        at
        for fact, at in vague
        if not (is_done and isinstance(fact, Condition)) and any(each.provides(fact) for each in given)
    }


def _calls(
    statement: nodes.Statement, scope: Bindings, guard: Any, state: Believed
) -> Iterator[tuple[nodes.Call, Bindings, Any]]:
    """Yield the calls that a statement may stand for, with their bindings, and how probably it does."""
    if guard < POSSIBLE:
        return
    match statement:
        case nodes.Call():
            yield statement, scope, guard
        case nodes.When(condition=condition, body=body):
            yield from _calls(body, scope, min(guard, state.likely(condition, scope)), state)
        case nodes.For(generator=generator, body=body):
            iterable = generator.iterable.id
            source = scope[iterable] if iterable in scope else state.domain(iterable)
            assert isinstance(source, tuple)
            for element in source:
                inner: Bindings = {**scope, generator.variable: element}
                likely = min(guard, state.likely(generator.condition, inner))
                yield from _calls(body, inner, likely, state)
