"""What follows from an element of a list: calls that a program may make, and facts that it achieves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ntp_dsl.language.registry import Program, Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.visitors import predicates
from ntp_dsl.semantics.facts import Bindings, Condition, Fact, Literal, bind
from ntp_dsl.semantics.observation import Argument, without_lists
from ntp_dsl.semantics.state import State

DEEPEST = 4  # programs below the root


class Said(NamedTuple):
    """A ground call, or a ground fact; None stands for an argument that nobody named."""

    name: str
    arguments: tuple[Argument | None, ...]
    is_fact: bool

    @property
    def named(self) -> int:
        """How many of its arguments somebody named."""
        return sum(each is not None for each in self.arguments)

    def covers(self, other: Said) -> bool:
        """Return whether another is this one, but for what nobody named."""
        if (self.name, self.is_fact) != (other.name, other.is_fact):
            return False
        return all(a is None or _same(a, b) for a, b in zip(self.arguments, other.arguments, strict=True))


def _same(one: Argument | None, other: Argument | None) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return abs(one - other) < 1e-6
    return one == other


def element_said(parameter: str, values: Sequence[Argument | None]) -> Said:
    """Return that a list is to have an element: what is said where someone names its fields."""
    return Said(f"{parameter}[]", tuple(values), False)


def consequences(state: State, program: Program, arguments: tuple[Argument, ...]) -> set[Said]:
    """Return what may be said of a program's call: all that it calls, whatever holds now, and achieves.

    Conditions on what cannot change (kinds, traits) are heeded; others may come to hold.
    """
    found: set[Said] = set()
    seen: set[tuple[str, tuple[Argument, ...]]] = set()

    def follow(row: Program, given: tuple[Argument, ...], depth: int) -> None:
        if (row.name, given) in seen or depth > DEEPEST:
            return
        seen.add((row.name, given))
        scope = row.bind(given)
        if depth == 0:
            found.update(_facts(state, state.literals(row.achieves, scope)))
        for statement in row.body:
            for call, inner in _calls(state, statement, scope):
                try:
                    values = tuple(state.value(term, inner) for term in call.arguments)
                except (TypeError, KeyError):  # a reading that nothing has yet
                    continue
                callee = state.registry[call.callee]
                if not any(isinstance(each, tuple) for each in values):
                    found.add(Said(call.callee, without_lists(values), False))
                if depth == 0:  # what calls below achieve is on the way, and nobody's aim
                    found.update(_facts(state, state.literals(callee.achieves, callee.bind(values))))
                if isinstance(callee, Program):
                    follow(callee, values, depth + 1)

    if not program.takes_list:
        found.add(Said(program.name, without_lists(arguments), False))
    follow(program, arguments, 0)
    return found


def _calls(
    state: State, statement: nodes.Statement, scope: Bindings
) -> Iterator[tuple[nodes.Call, Bindings]]:
    match statement:
        case nodes.Call():
            yield statement, scope
        case nodes.When(condition=condition, body=body):
            if not _is_lasting(state.registry, condition) or state.true(condition, scope):
                yield from _calls(state, body, scope)
        case nodes.For(generator=generator, body=body):
            lasting = _is_lasting(state.registry, generator.condition)
            if generator.iterable.id not in scope and not lasting:
                return  # what is in the way
            if lasting:
                for inner in state.elements(generator, scope):
                    yield from _calls(state, body, inner)
                return
            source = scope[generator.iterable.id]
            assert isinstance(source, tuple)
            for element in source:
                yield from _calls(state, body, {**scope, generator.variable: element})


def _is_lasting(registry: Registry, condition: nodes.Expression | None) -> bool:
    """Return whether a condition is about traits alone, which never change."""
    if condition is None:
        return True
    declared = (registry.predicates[name] for name in predicates(condition))
    return all(each.result is not None and each.by is None and each.body is None for each in declared)


def _facts(state: State, facts: list[Fact]) -> Iterator[Said]:
    """Yield facts, and those that they consist of or that may bring them about."""
    for fact in facts:
        if isinstance(fact, Condition):
            literals = [*fact.helping()]
        else:
            literals = [fact]
        for literal in literals:
            if literal.positive:
                yield from _unfolded(state, literal, 0)


def _unfolded(state: State, literal: Literal, depth: int) -> Iterator[Said]:
    if not any(isinstance(each, tuple) for each in literal.arguments):
        yield Said(literal.predicate, without_lists(literal.arguments), True)
    declared = state.registry.predicates[literal.predicate]
    if declared.body is None or depth >= DEEPEST:
        return
    for inner in state.helping(declared.body, bind(declared, literal.arguments)):
        if inner.positive:
            yield from _unfolded(state, inner, depth + 1)
