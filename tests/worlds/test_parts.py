"""Which facts go towards others that are said in other words: those that do not hold, where it helps."""

from __future__ import annotations

from functools import cache

import pytest

from ntp_dsl.language.registry import Registry
from ntp_dsl.libraries import load_text
from ntp_dsl.semantics.facts import Literal
from ntp_dsl.semantics.observation import DeclaredFact, Observation, SceneObject
from ntp_dsl.semantics.parts import Wanted, parts
from ntp_dsl.semantics.state import State

TEXT = """library parts
use tabletop
type Lamp is Movable
predicate wired(l: Lamp) by state
predicate lit(l: Lamp) by state
predicate dusty(l: Lamp) by state
predicate tidy(l: Lamp): lit(l) and not dusty(l)
predicate ready(l: Lamp): wired(l) and tidy(l)
predicate either(l: Lamp): wired(l) or lit(l)
predicate all_lit(): all lit(l) for l in Lamp
predicate one_lit(): (exactly 1 lit(l) for l in Lamp) and some wired(l) for l in Lamp
predicate two_lit(): at least 2 lit(l) for l in Lamp
predicate depth(l: Lamp) -> length
predicate deep(l: Lamp): lit(l) and depth(l) > 5 cm
predicate gripped(l: Lamp): holding(l) and lit(l)
api wire(l: Lamp)
    achieves wired(l)
api light(l: Lamp)
    achieves lit(l)
api dirty(l: Lamp)
    achieves dusty(l)
program install(l: Lamp):
    achieves ready(l)
    wire(l)
    light(l)
"""
LAMPS = ("a", "b", "c")


@cache
def library() -> Registry:
    return load_text(TEXT)


def state(*facts: tuple[str, str]) -> State:
    objects = tuple(SceneObject(name, "Lamp", (0.05, 0.05, 0.05)) for name in LAMPS)
    places = {name: (0.4 + 0.1 * number, 0.0, 0.02) for number, name in enumerate(LAMPS)}
    declared = frozenset(DeclaredFact(predicate, (name,)) for predicate, name in facts)
    return State(library(), Observation(objects, places, (0.5, 0.0, 0.4), False, facts=declared))


def fact(text: str) -> Literal:
    name, _, arguments = text.removeprefix("not ").removesuffix(")").partition("(")
    return Literal(name, tuple(filter(None, arguments.split(", "))), not text.startswith("not "))


@pytest.mark.parametrize(
    ("holding", "wanted", "expected"),
    [
        ([], "ready(a)", "ready(a), tidy(a), wired(a), lit(a)"),
        ([("wired", "a")], "ready(a)", "ready(a), tidy(a), lit(a)"),
        ([("lit", "a"), ("dusty", "a")], "tidy(a)", "tidy(a), not dusty(a)"),
        ([("lit", "a")], "tidy(a)", ""),
        ([("lit", "a")], "not tidy(a)", "not tidy(a), not lit(a), dusty(a)"),
        ([], "deep(a)", "deep(a), lit(a)"),  # what is written after it has no meaning yet
        ([], "either(a)", "either(a), wired(a), lit(a)"),
        ([("wired", "a")], "not either(a)", "not either(a), not wired(a)"),
        ([("lit", "a")], "all_lit()", "all_lit(), lit(b), lit(c)"),
        ([("lit", "a")], "one_lit()", "one_lit(), wired(a), wired(b), wired(c)"),
        ([("lit", "a"), ("lit", "b"), ("wired", "a")], "one_lit()", "one_lit(), not lit(a), not lit(b)"),
        ([("lit", "a")], "two_lit()", "two_lit(), lit(b), lit(c)"),
        ([("lit", "a"), ("lit", "b")], "not two_lit()", "not two_lit(), not lit(a), not lit(b)"),
    ],
)  # fmt: skip
def test_the_parts_of_a_fact_are_what_is_lacking_of_it(
    holding: list[tuple[str, str]], wanted: str, expected: str
) -> None:
    found = {str(each) for each in parts(fact(wanted), state(*holding))}
    assert found == set(filter(None, expected.replace("), ", ")\n").split("\n")))


@pytest.mark.parametrize(
    ("provided", "wanted"),
    [
        ("lit(a)", "ready(a)"),
        ("tidy(a)", "ready(a)"),
        ("tidy(a)", "lit(a)"),
        ("either(a)", "tidy(a)"),
        ("gripped(a)", "holding(any)"),
        ("all_lit()", "ready(b)"),
    ],
)
def test_what_shares_a_part_goes_towards_it(provided: str, wanted: str) -> None:
    assert Wanted([fact(wanted)], state()).helped_by([fact(provided)]) == {fact(wanted)}


@pytest.mark.parametrize(
    ("holding", "provided", "wanted"),
    [
        ([], "lit(b)", "ready(a)"),
        ([], "dusty(a)", "tidy(a)"),
        ([], "lit(a)", "lit(a)"),  # `provides` tells that
        ([("lit", "a")], "tidy(a)", "ready(a)"),  # it holds
        ([("lit", "a")], "gripped(a)", "ready(a)"),  # what they share holds
        ([("lit", "a")], "lit(b)", "one_lit()"),  # it would break it
    ],
)
def test_nothing_else_goes_towards_it(holding: list[tuple[str, str]], provided: str, wanted: str) -> None:
    assert Wanted([fact(wanted)], state(*holding)).helped_by([fact(provided)]) == set()
