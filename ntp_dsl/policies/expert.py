"""Experts: pure functions from (program, arguments, state) to the next call, or to a return.

A program returns when its `achieves` holds, or its `requires` does not; else it calls the first due
statement of its body. See "Apis and programs" in `grammar/README.md`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Api, Program, Registry, place_of
from ntp_dsl.language.syntax import nodes
from ntp_dsl.semantics.facts import Bindings, Condition, Fact
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.semantics.parts import Wanted
from ntp_dsl.semantics.state import State
from ntp_dsl.semantics.value_checks import guess, plain, types_of, unfit_call
from ntp_dsl.traces.phrases import format_invocation


@dataclass(frozen=True)
class NextCall:
    """The call that a program makes now, and the statement that makes it."""

    callee: str
    arguments: tuple[Argument, ...]
    span: nodes.Span = field(default=nodes.NOWHERE, compare=False, repr=False)

    def __str__(self) -> str:
        return format_invocation(self.callee, self.arguments)


@dataclass(frozen=True)
class Return:
    """The end of a program: done, or unfinished and to be asked again."""

    done: bool
    reason: str = field(default="", compare=False)


Decision = NextCall | Return
PythonExpert = Callable[..., "NextCall | Iterable[NextCall] | None"]


@dataclass
class Instance:
    """A statement in a state: its call, the facts it provides, and those it lacks."""

    call: NextCall | None
    achieved: bool
    provides: frozenset[Fact]
    lacks: frozenset[Fact]
    names: frozenset[Fact]
    vain: NextCall | None = None  # of a loop: the first call that was passed over as it would return at once
    lacking: tuple[NextCall, frozenset[Fact]] | None = None  # of a loop: the first call that lacks something


class Expert:
    """The scripted policy of a registry: declared bodies, and functions where it leaves them to Python.

    Args:
        functions: experts by program, in place of the registry's; for tests.
    """

    def __init__(self, registry: Registry, functions: Mapping[str, PythonExpert] | None = None):
        self.registry = registry
        self._functions = dict(functions or {})
        self._latest: State | None = None

    def state_of(self, observation: Observation) -> State:
        """Return the state of a moment; while nothing changes it is the same one, and keeps what it knows."""
        if self._latest is None or self._latest.observation != observation:
            self._latest = State(self.registry, observation)
        return self._latest

    def decide(self, program: str, arguments: tuple[Argument, ...], state: State) -> Decision:
        """Return the first due call, or a return. Asking twice gives the same answer.

        A call is not made where it would return at once, however many calls it would make before.
        """
        known = state.memo.get((self, program, arguments))
        if known is not None:
            assert isinstance(known, NextCall | Return)
            return known
        state.memo[self, program, arguments] = NextCall(program, arguments)  # until it is known: no return
        try:
            answer = self._step(self.registry.programs[program], arguments, state)
            if isinstance(answer, NextCall) and (end := self._end_at_once(answer, state)):
                answer = Return(False, f"{answer.callee} would return at once: {end.reason or 'it is done'}")
        except BaseException:
            del state.memo[self, program, arguments]  # the state outlives this question
            raise
        state.memo[self, program, arguments] = answer
        return answer

    def _step(self, row: Program, arguments: tuple[Argument, ...], state: State) -> Decision:
        needed = {fact for fact in state.contract(row.name, arguments).achieves if not state.holds(fact)}
        if not needed:
            return Return(True)
        if lacking := _first_lacking(row, arguments, state):
            return Return(False, f"{lacking} does not hold")
        if row.in_python or row.name in self._functions:
            return self._ask_python(row, arguments, state)
        return self._first_due(row, arguments, needed, state)

    # The body, read from its end ----------------------------------------------------------------

    def _first_due(
        self, row: Program, arguments: tuple[Argument, ...], needed: set[Fact], state: State
    ) -> Decision:
        wanted = frozenset(needed)  # which reading the body extends
        read = [(each, is_due) for _, each, is_due in self.read_body(row, arguments, needed, state) if each]
        due = [each for each, is_due in read if is_due]
        for instance in reversed(due):
            if not instance.lacks and instance.call is not None:
                return instance.call
        return Return(False, self._why_none(due, [each for each, _ in read], wanted, state))

    def _why_none(
        self, due: list[Instance], body: list[Instance], wanted: frozenset[Fact], state: State
    ) -> str:
        """Return why no statement is called although something is wanted."""
        for instance in due:
            if instance.vain is not None and (end := self._end_at_once(instance.vain, state)):
                return f"{instance.vain} would return at once: {end.reason or 'it is done'}"
            if instance.lacks and instance.call is not None:
                lacking = min(map(str, instance.lacks))
                return (
                    f"{instance.call} lacks {lacking}, and no statement before it is due that brings it about"
                )
        for fact in sorted(wanted, key=str):
            is_helped = any(Wanted([fact], state).helped_by(each.provides) for each in body)
            if not is_helped and not any(_provides_any(each.provides, {fact}) for each in body):
                return f"no statement achieves {fact}"
        return "no statement is due"

    def read_body(
        self, row: Program, arguments: tuple[Argument, ...], needed: set[Fact], state: State
    ) -> Iterator[tuple[nodes.Statement, Instance | None, bool]]:
        """Yield each statement from the last, its instance, and whether it is due; extends `needed`."""
        named = set(state.contract(row.name, arguments).achieves)
        scope = row.bind(arguments)
        for index in range(len(row.body) - 1, -1, -1):
            instance = self._instantiate(row.body[index], row.body[:index], scope, state)
            if instance is None:
                yield row.body[index], None, False
                continue
            is_part = bool(Wanted(needed, state).helped_by(instance.provides))
            wanted = is_part or _provides_any(instance.provides, needed)
            loops = isinstance(row.body[index], nodes.For)
            alike = named if loops else [fact for fact in named if isinstance(fact, Condition)]
            is_named = bool(instance.provides & named) or _provides_any(instance.provides, alike)
            is_named = is_named or bool(Wanted(named, state).helped_by(instance.provides))
            is_due = not instance.achieved and (wanted or not is_named)
            if is_due:
                needed |= instance.lacks
            yield row.body[index], instance, is_due
            named |= instance.names

    def _instantiate(
        self,
        statement: nodes.Statement,
        earlier: tuple[nodes.Statement, ...],
        scope: Bindings,
        state: State,
    ) -> Instance | None:
        match statement:
            case nodes.Call():
                return self._call_instance(statement, scope, state)
            case nodes.When(condition=condition, body=body):
                if not state.true(condition, scope):
                    return None
                return self._instantiate(body, earlier, scope, state)
            case nodes.For():
                return self._loop_instance(statement, earlier, scope, state)

    def _call_instance(self, statement: nodes.Call, scope: Bindings, state: State) -> Instance:
        callee = self.registry[statement.callee]
        arguments = tuple(state.value(term, scope) for term in statement.arguments)
        requires, provides = state.contract(callee.name, arguments)
        return Instance(
            NextCall(callee.name, arguments, statement.span),
            callee.achieves is not None and all(state.holds(x) for x in provides),
            frozenset(provides),
            frozenset(x for x in requires if not state.holds(x)),
            frozenset(requires),
        )

    def _loop_instance(
        self,
        loop: nodes.For,
        earlier: tuple[nodes.Statement, ...],
        scope: Bindings,
        state: State,
    ) -> Instance:
        elements = [
            instance
            for inner in state.elements(loop.generator, scope)
            if (instance := self._instantiate(loop.body, earlier, inner, state)) is not None
        ]
        provides = frozenset[Fact]().union(*(e.provides for e in elements))
        names = frozenset[Fact]().union(*(e.names for e in elements))
        pending = [element for element in elements if not element.achieved]
        if not pending:
            return Instance(None, True, provides, frozenset(), names)
        helped = self._provided_by(earlier, scope, state) if earlier else frozenset[Fact]()
        new = [fact for fact in helped if not state.holds(fact)]  # what holds helps no condition
        for element in pending:
            hopeless = any(
                not _provides_any(new if isinstance(lack, Condition) else helped, {lack})
                and not Wanted([lack], state).helped_by(helped)
                for lack in element.lacks
            )
            if not hopeless and (element.lacks or not self._is_empty(element.call, state)):
                return Instance(element.call, False, provides, element.lacks, names)
        vain = next((call for each in pending if not each.lacks and (call := each.call or each.vain)), None)
        lacking = next((found for each in pending if (found := _lacking(each))), None)
        return Instance(None, False, provides, frozenset(), names, vain, lacking)

    def _provided_by(
        self, statements: tuple[nodes.Statement, ...], scope: Bindings, state: State
    ) -> frozenset[Fact]:
        instances = (self._instantiate(s, (), scope, state) for s in statements)
        return frozenset[Fact]().union(*(i.provides for i in instances if i is not None))

    # Calls that would return at once ------------------------------------------------------------

    def _is_empty(self, call: NextCall | None, state: State) -> bool:
        """Return whether the callee's own first step would be a return, or an inner loop has no call."""
        return call is None or self._end_at_once(call, state) is not None

    def _end_at_once(self, call: NextCall, state: State) -> Return | None:
        """Return the callee's own first step, if that is a return."""
        callee = self.registry[call.callee]
        if isinstance(callee, Api):
            lacking = _first_lacking(callee, call.arguments, state)
            return Return(False, f"{lacking} does not hold") if lacking else None
        answer = self.decide(callee.name, call.arguments, state)
        return answer if isinstance(answer, Return) else None

    def _ask_python(self, row: Program, arguments: tuple[Argument, ...], state: State) -> Decision:
        function = self._functions.get(row.name) or self.registry.python.get("expert", row.name)
        answer = function(ExpertContext(self.registry, state), *arguments)
        offers = [answer] if isinstance(answer, NextCall) else list(answer or ())
        types = types_of(self.registry, state.observation) if offers else {}
        for offer in offers:
            if offer.callee not in row.callees:
                declared = f"it declares {', '.join(row.callees) or 'nothing'}"
                raise UndeclaredCall(function, row.name, f"'{offer.callee}'; {declared}")
            if wrong := unfit_call(self.registry, self.registry[offer.callee], offer.arguments, types):
                raise UndeclaredCall(function, row.name, f"{offer.callee}{offer.arguments!r}; {wrong}")
            if not self._is_empty(offer, state):
                return replace(offer, span=row.span)  # the declaration that leaves it to Python
        return Return(False, "the Python expert offers no call")


class UndeclaredCall(NtpError):
    """A Python expert makes a call that its program does not declare, or not as declared.

    `name` is the program's.
    """

    def __init__(self, function: PythonExpert, name: str, called: str) -> None:
        self.name = name
        super().__init__(f"{place_of(function)}: the expert of '{name}' calls {called}")


class ExpertContext:
    """The read-only state for a Python expert: declared predicates as methods, objects by type."""

    def __init__(self, registry: Registry, state: State) -> None:
        self._registry, self._state = registry, state

    def objects(self, type_name: str) -> list[str]:
        """Return the names of the objects of a type. Raises `NtpError` for an unknown type."""
        if type_name not in self._registry.parents:
            raise NtpError(f"no type is called '{type_name}'{guess(type_name, self._registry.parents)}")
        return self._state.objects(type_name)

    def __getattr__(self, predicate: str) -> Callable[..., Any]:
        declared = self._registry.predicates.get(predicate)
        if declared is None:
            known = self._registry.predicates
            raise AttributeError(f"no predicate is called '{predicate}'{guess(predicate, known)}")
        count = len(declared.parameters)

        def ask(*arguments: Any) -> Any:
            if len(arguments) != count:
                raise TypeError(f"{predicate} takes {count} arguments, here are {len(arguments)}")
            return self._state.reading(predicate, tuple(arguments))

        return ask


def call(callee: str, *arguments: Argument) -> NextCall:
    """Return the call of an api or program by name; for Python experts."""
    return NextCall(callee, plain(arguments))


def first(calls: Iterable[NextCall]) -> list[NextCall]:
    """Return candidate calls; the first that would not return at once is made. For Python experts."""
    return list(calls)


def _lacking(element: Instance) -> tuple[NextCall, frozenset[Fact]] | None:
    """Return the call that an element of a loop stands for, and what it lacks; or None."""
    return (element.call, element.lacks) if element.call and element.lacks else element.lacking


def _first_lacking(row: Program | Api, arguments: tuple[Argument, ...], state: State) -> Fact | None:
    """Return the first requirement that does not hold, or None."""
    return next(
        (fact for fact in state.contract(row.name, arguments).requires if not state.holds(fact)), None
    )


def _provides_any(provided: Iterable[Fact], wanted: Iterable[Fact]) -> bool:
    wanted = list(wanted)
    return any(literal.provides(other) for literal in provided for other in wanted)
