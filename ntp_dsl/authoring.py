"""What a user's Python imports: decorators for the functions that a library leaves to it.

Declarations `by python` in `kitchen.ntp` are implemented in `kitchen.py`, beside it:

    from ntp_dsl.authoring import call, expert, first

    @expert
    def sort(world, goal):
        return first(call("put_in", m["item"], m["bin"]) for m in goal if not world.on(m["item"], m["bin"]))

A decorator may give another name than the function's: `@expert("sort")`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, TypeVar, overload

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.worlds.protocol import ACHIEVED, Failure, Outcome

if TYPE_CHECKING:
    from ntp_dsl.policies.expert import NextCall

__all__ = [
    "ACHIEVED", "Failure", "NextCall", "Outcome", "call", "expert", "first", "predicate", "sampler", "skill",
]  # fmt: skip

MARK = "_ntp_dsl_function"

F = TypeVar("F", bound=Callable[..., Any])


def call(callee: str, *arguments: Argument) -> NextCall:
    """Return the call of an api or program by name; for experts."""
    from ntp_dsl.policies import expert  # which needs numpy: loading a library does not

    return expert.call(callee, *arguments)


def first(calls: Iterable[NextCall]) -> list[NextCall]:
    """Return candidate calls; the first that would not return at once is made. For experts."""
    return list(calls)


def __getattr__(name: str) -> Any:
    """Import `NextCall` when it is first used (PEP 562)."""
    if name != "NextCall":
        raise AttributeError(f"module 'ntp_dsl.authoring' has no attribute '{name}'")
    from ntp_dsl.policies.expert import NextCall

    return NextCall


@overload
def expert(function: F) -> F: ...
@overload
def expert(function: str) -> Callable[[F], F]: ...
def expert(function: Any) -> Any:
    """Mark an expert: `(world, *arguments)` to a call, several in the order of preference, or None.

    `world` has the declared predicates as methods, `objects(type)`, and nothing that could change.
    """
    return _mark("expert", function)


@overload
def predicate(function: F) -> F: ...
@overload
def predicate(function: str) -> Callable[[F], F]: ...
def predicate(function: Any) -> Any:
    """Mark a predicate: `(observation, *arguments)` to True or False, a reading to a number or member."""
    return _mark("predicate", function)


@overload
def skill(function: F) -> F: ...
@overload
def skill(function: str) -> Callable[[F], F]: ...
def skill(function: Any) -> Any:
    """Mark a skill: `(world, *arguments)` to an `Outcome`; `world.call(...)` makes the world's own."""
    return _mark("skill", function)


@overload
def sampler(function: F) -> F: ...
@overload
def sampler(function: str) -> Callable[[F], F]: ...
def sampler(function: Any) -> Any:
    """Mark a sampler: `(rng, *groups, **parameters)` to rows of names, one for each element of the goal.

    Parameters are numbers, but for `topology` and `semantics`: where the function takes these, each is a
    generator, for how objects are related and for which objects take part; `starts` is a mapping from each
    object to what it starts on. Fewer elements than `length` are an error: figures for goals of ten would be
    about shorter ones.
    """
    return _mark("sampler", function)


def _mark(kind: str, given: Any) -> Any:
    if isinstance(given, str):
        return lambda function: _marked(kind, given, function)
    if not hasattr(given, "__name__"):
        raise NtpError(f'@{kind}: expected a function or a name, found {given!r}; write @{kind}("its_name")')
    return _marked(kind, given.__name__, given)


def _marked(kind: str, name: str, function: F) -> F:
    if not callable(function):
        raise NtpError(f"@{kind}: expected a function, found {function!r}; write @{kind} above a `def`")
    try:
        setattr(function, MARK, (kind, name))
    except (AttributeError, TypeError) as error:  # of what is built in, and of methods of an object
        raise NtpError(
            f"@{kind}: expected a function written in Python, found {function!r}; write a `def` that calls it"
        ) from error
    return function
