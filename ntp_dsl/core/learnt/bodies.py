"""The body that the calls of a function in Python show: of each callee, where its arguments come from."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import count

from msgspec import Struct

from ntp_dsl.core.learnt.examples import Example
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Parameter, Program, Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_statement
from ntp_dsl.semantics.observation import Argument, Record

MOST_LOOPS = 2  # over the scene, for one call


class Source(Struct, frozen=True, omit_defaults=True):
    """Where an argument comes from: a parameter or a field of its elements, a constant, or all of a type."""

    name: str = ""  # of a parameter or a constant
    field: str = ""  # of the elements of that parameter, a list
    type: str = ""  # of objects or members, each of which may be meant


class ShownCall(Struct, frozen=True):
    """A call that a program makes, and where each argument comes from."""

    callee: str
    sources: tuple[Source, ...]


def shown_calls(registry: Registry, program: Program, examples: Sequence[Example]) -> tuple[ShownCall, ...]:
    """Return the calls that a program makes, in the order of its declaration.

    Raises `NtpError` where an argument comes from nowhere: a number that is computed, or a list of its own.
    """
    found = []
    for name in program.callees:
        made = [each for each in examples if each.callee == name]
        if made:
            found.append(_shown_call(registry, program, name, made))
    return tuple(found)


def _shown_call(registry: Registry, program: Program, callee: str, made: Sequence[Example]) -> ShownCall:
    sources = []
    for at, parameter in enumerate(registry[callee].parameters):
        options = _sources(registry, program, parameter)
        fitting = (source for source, gives in options if all(each.given[at] in gives(each) for each in made))
        source = next(fitting, None)
        if source is None:
            raise NtpError(
                f"'{program.name}' cannot be learnt from traces: the argument '{parameter.name}' of "
                f"{callee}, such as {made[0].given[at]}, is no parameter of the program, no field of its "
                "lists, and no object of the scene; declare a body, or keep the function"
            )
        sources.append(source)
    _check_one_element(registry, program, callee, sources, made)
    if sum(bool(each.type) for each in sources) > MOST_LOOPS:
        raise NtpError(
            f"'{program.name}' cannot be learnt from traces: {callee} takes more than {MOST_LOOPS} objects "
            "that any object of the scene could be"
        )
    return ShownCall(callee, tuple(sources))


Gives = Callable[[Example], Sequence[Argument]]


def _sources(registry: Registry, program: Program, wanted: Parameter) -> Iterator[tuple[Source, Gives]]:
    """Yield where an argument may come from, the narrowest first, with what that gives in an example."""
    for at, own in enumerate(program.parameters):
        if own.is_list == wanted.is_list and registry.takes(wanted, own):
            yield Source(own.name), partial(_own, at)
    if wanted.is_list:
        return
    for at, own in enumerate(program.parameters):
        if own.is_list:
            for field in registry.records.get(own.type, ()):
                if not registry.takes(wanted, field):
                    continue
                yield Source(own.name, field.name), partial(_field, at, field.name)
    for name, kind in registry.constants.items():
        if wanted.type in registry.parents and registry.is_a(kind, wanted.type):
            yield Source(name), partial(_constant, name)
    if wanted.type in registry.parents:
        for kind in sorted(_kinds(registry, wanted.type), key=lambda each: -len([*registry.ancestors(each)])):
            yield Source(type=kind), partial(_any_object, registry, kind)
    elif wanted.type in registry.enums:
        yield Source(type=wanted.type), partial(_any_of, registry.enums[wanted.type])


def fits(registry: Registry, program: Program, calls: Sequence[ShownCall]) -> bool:
    """Return whether a program can make calls: they are declared, and every argument comes from somewhere."""
    for call in calls:
        if call.callee not in program.callees:
            return False
        wanted = registry[call.callee].parameters
        if len(wanted) != len(call.sources):
            return False
        for parameter, source in zip(wanted, call.sources, strict=True):
            if source not in [each for each, _ in _sources(registry, program, parameter)]:
                return False
    return True


def _check_one_element(
    registry: Registry, program: Program, callee: str, sources: Sequence[Source], made: Sequence[Example]
) -> None:
    """Raise `NtpError` where the fields that a call takes of a list are of different elements."""
    for number, own in enumerate(program.parameters):
        fields = [(at, each.field) for at, each in enumerate(sources) if each.field and each.name == own.name]
        for example in made if len(fields) > 1 else ():
            elements = example.arguments[number]
            assert isinstance(elements, tuple)
            if not any(_agree(each, fields, example) for each in elements):
                raise NtpError(
                    f"'{program.name}' cannot be learnt from traces: {callee}{example.given!r} takes fields "
                    f"of different elements of '{own.name}'"
                )


def _agree(element: Argument, fields: Sequence[tuple[int, str]], example: Example) -> bool:
    return isinstance(element, Record) and all(element[name] == example.given[at] for at, name in fields)


def _own(at: int, example: Example) -> Sequence[Argument]:
    return (example.arguments[at],)


def _field(at: int, field: str, example: Example) -> Sequence[Argument]:
    elements = example.arguments[at]
    assert isinstance(elements, tuple)
    return [each[field] for each in elements if isinstance(each, Record)]


def _constant(name: str, example: Example) -> Sequence[Argument]:
    return (name,)


def _kinds(registry: Registry, wanted: str) -> list[str]:
    """Return a type and all below it."""
    return [each for each in registry.parents if registry.is_a(each, wanted)]


def _any_object(registry: Registry, kind: str, example: Example) -> Sequence[Argument]:
    return [each.name for each in example.seen.objects if registry.is_a(each.type, kind)]


def _any_of(members: Sequence[str], example: Example) -> Sequence[Argument]:
    return members


# The statements -------------------------------------------------------------------------------------


def with_calls(registry: Registry, program: Program, calls: Sequence[ShownCall]) -> Program:
    """Return a program with the body that shown calls make."""
    body = tuple(_statement(registry, program, each) for each in calls)
    return replace(program, body=body, in_python=False)


def _statement(registry: Registry, program: Program, call: ShownCall) -> nodes.Statement:
    """Return a call within the loops that its arguments need: one for each list, and for each type."""
    used = {*registry.constants, *(parameter.name for parameter in program.parameters)}
    lists: dict[str, str] = {}  # the variable of each list
    loops: list[nodes.Generator] = []
    terms: list[nodes.Expression] = []

    def loop(over: str, wanted: str) -> str:
        name = next(each for number in count() if (each := wanted + str(number or "")) not in used)
        used.add(name)
        loops.append(nodes.Generator(name, nodes.Name(over)))
        return name

    for source in call.sources:
        if source.type:
            terms.append(nodes.Name(loop(source.type, source.type.lower())))
        elif source.field:
            if source.name not in lists:
                lists[source.name] = loop(source.name, "each")
            terms.append(nodes.Field(nodes.Name(lists[source.name]), source.field))
        else:
            terms.append(nodes.Name(source.name))
    statement: nodes.Statement = nodes.Call(call.callee, tuple(terms), span=program.span)
    for generator in reversed(loops):
        statement = nodes.For(generator, statement, span=program.span)
    return statement


def lines_of(registry: Registry, program: Program, calls: Sequence[ShownCall]) -> list[str]:
    """Return the statements that shown calls make, as text."""
    body = with_calls(registry, program, calls).body
    return [line for statement in body for line in format_statement(statement)]
