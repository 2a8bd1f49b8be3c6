"""A state answers contracts: truth, and the literals that they are made of."""

from __future__ import annotations

import pytest

from ntp_dsl.common.resources import library_folder
from ntp_dsl.language.checker import check
from ntp_dsl.language.parsing.parser import parse
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.facts import Literal
from ntp_dsl.semantics.observation import Observation, Record, SceneObject
from ntp_dsl.semantics.state import State

CUBE = (0.05, 0.05, 0.05)
TOWER = Observation(
    (*(SceneObject(name, "Block", CUBE) for name in "abc"), SceneObject("table", "Table", (1.5, 1.5, 0.04))),
    {"a": (0.5, 0, 0.075), "b": (0.5, 0, 0.025), "c": (0.3, 0, 0.025), "table": (0.5, 0, -0.02)},
    (0.4, 0.2, 0.4),
    False,
)
LIBRARY = """library sample
use tabletop
predicate free(x: Object): on(x, table) and clear(x)
predicate low(x: Object): not some on(x, o) for o in Object
program tidy(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal if free(p.item)
    for p in goal:
        pick_and_place(p.item, p.support)
predicate asked(x: Object, y: Object): CONDITION
"""


def registry(condition: str) -> Registry:
    tabletop = parse((library_folder() / "tabletop.ntp").read_text())
    return check(parse(LIBRARY.replace("CONDITION", condition)), tabletop)


@pytest.mark.parametrize(
    "condition, holds",
    [
        ("on(x, y)", True),
        ("on(y, x)", False),
        ("not on(y, x)", True),
        ("clear(x) and not clear(y)", True),
        ("free(x)", False),
        ("low(y)", True),
        ("low(x)", False),
        ("all present(o) for o in Object", True),
        ("all clear(o) for o in Object", False),
        ("all clear(o) for o in Object if not on(x, o)", True),
        ("all clear(o) for o in Object if holding(o)", True),
    ],
)
def test_a_condition_is_true_or_not(condition: str, holds: bool) -> None:
    state = State(registry(condition), TOWER)
    assert state.holds(Literal("asked", ("a", "b"))) is holds
    assert state.holds(Literal("asked", ("a", "b"), positive=False)) is not holds


def test_a_contract_over_a_list_is_spelt_out() -> None:
    checked = registry("on(x, y)")
    pairs = [("a", "c"), ("c", "b")]
    goal = tuple(Record("Placement", (("item", i), ("support", s))) for i, s in pairs)
    literals = State(checked, TOWER).literals(checked["tidy"].achieves, {"goal": goal})
    assert literals == [Literal("on", ("c", "b"))]  # only c is free


def test_holding_something_provides_holding_anything() -> None:
    something, anything = Literal("holding", ("a",)), Literal("holding", ("any",))
    assert something.provides(anything) and something.provides(something)
    assert not anything.provides(something)
    assert not Literal("holding", ("a",), positive=False).provides(anything)
    assert str(Literal("on", ("a", "b"), positive=False)) == "not on(a, b)"


def test_objects_are_listed_by_type_and_its_ancestors() -> None:
    state = State(registry("on(x, y)"), TOWER)
    assert state.objects("Block") == state.objects("Movable") == ["a", "b", "c"]
    assert state.objects("Place") == ["a", "b", "c", "table"]
