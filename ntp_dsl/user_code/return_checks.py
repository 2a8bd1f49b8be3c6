"""What functions in Python may return, by their kind."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Set
from typing import Any

from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax.nodes import PredicateDeclaration
from ntp_dsl.worlds.protocol import Outcome

Test = Callable[[Any], str]  # what was expected instead of an answer, or nothing

OUTCOME = "an Outcome: return that of world.call(...) or world.move_over(...), or ACHIEVED"
TRUTH = "True or False: compare a number, and return False where it has no answer"
CALLS = "call(...), several of them in a list, or None"


def answer_test(registry: Registry, kind: str, name: str) -> Test:
    """Return the test of a declared function's return values."""
    if kind == "predicate":
        return _reading(registry, registry.predicates[name])
    return {"skill": _outcome, "expert": _calls, "sampler": _rows}[kind]


def _outcome(answer: Any) -> str:
    return "" if isinstance(answer, Outcome) else OUTCOME


def _calls(answer: Any) -> str:
    from ntp_dsl.policies.expert import NextCall  # which needs numpy: loading a library does not

    if answer is None or isinstance(answer, NextCall):
        return ""
    if isinstance(answer, tuple) and answer and isinstance(answer[0], str):
        return f"{CALLS}; write: call({', '.join(map(repr, answer))})"
    if isinstance(answer, str | Mapping | Set) or not isinstance(answer, Iterable):
        return CALLS
    others = [each for each in answer if not isinstance(each, NextCall)]
    if not others:
        return ""
    other = others[0]
    if isinstance(other, tuple):
        return f"{CALLS}; write: call({', '.join(map(repr, other))})"
    return f"{CALLS}; not {other!r} among them"


def _rows(answer: Any) -> str:
    is_rows = isinstance(answer, Iterable) and not isinstance(answer, str | Mapping | Set)
    return "" if is_rows else "a list of rows, one for each element of the goal"


def _reading(registry: Registry, declared: PredicateDeclaration) -> Test:
    if declared.result is None:
        return _truth
    members = registry.enums.get(declared.result.name)
    if members is not None:
        return lambda answer: "" if isinstance(answer, str) and answer in members else " or ".join(members)
    if declared.result.name in registry.parents:
        return lambda answer: "" if isinstance(answer, str) else "the name of an object"
    return _number


def _truth(answer: Any) -> str:
    return "" if isinstance(answer, bool) else TRUTH


def _number(answer: Any) -> str:
    return "" if isinstance(answer, int | float) else "a number"
