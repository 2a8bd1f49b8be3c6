"""What functions in Python may answer, by their kind."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Set
from typing import Any

from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax.nodes import PredicateDeclaration
from ntp_dsl.policies.expert import NextCall
from ntp_dsl.worlds.protocol import Outcome

Test = Callable[[Any], str]  # what was expected instead of an answer, or nothing

OUTCOME = "an Outcome: return what world.call(...) or world.move_over(...) says, or ACHIEVED"
TRUTH = "True or False: compare a number, and return False where nothing is to be said"
CALLS = "call(...), several of them in a list, or None"


def answer_test(registry: Registry, kind: str, name: str) -> Test:
    """The test of what a function answers that is declared under such a name."""
    if kind == "predicate":
        return _reading(registry, registry.predicates[name])
    return {"skill": _outcome, "expert": _calls, "sampler": _rows}[kind]


def _outcome(answer: Any) -> str:
    return "" if isinstance(answer, Outcome) else OUTCOME


def _calls(answer: Any) -> str:
    if answer is None or isinstance(answer, NextCall):
        return ""
    if isinstance(answer, tuple) and answer and isinstance(answer[0], str):
        return f"{CALLS}; write: call({', '.join(map(repr, answer))})"
    if isinstance(answer, str | Mapping | Set) or not isinstance(answer, Iterable):
        return CALLS
    strangers = [each for each in answer if not isinstance(each, NextCall)]
    if not strangers:
        return ""
    stranger = strangers[0]
    if isinstance(stranger, tuple):
        return f"{CALLS}; write: call({', '.join(map(repr, stranger))})"
    return f"{CALLS}; not {stranger!r} among them"


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
