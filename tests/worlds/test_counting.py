"""So many of some objects, and the opposite of a condition: what `exactly`, `at least` and `else` mean."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ntp_dsl.core.one_core import shipped_core
from ntp_dsl.core.perception.perceived import Believed
from ntp_dsl.evaluation.episodes import Evaluator, Plan
from ntp_dsl.language.formatting.canonical import format_library
from ntp_dsl.language.loader import diagnose_text, load_text
from ntp_dsl.language.parsing.parser import parse
from ntp_dsl.semantics.facts import Literal
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.semantics.state import State

NAMES = tuple(f"cup_{number}" for number in range(5))
COUNTS = range(7)
LIBRARY = """library counted
use tabletop

type Cup is Movable
""" + "\n".join(
    f"predicate least_{n}(s: Place): at least {n} on(c, s) for c in Cup\n"
    f"predicate exact_{n}(s: Place): exactly {n} on(c, s) for c in Cup"
    for n in COUNTS
)
PROGRAM = """library counted
use tabletop

type Cup is Movable
program p(a: Cup, b: Cup):
    requires present(a) and reachable(a) and present(b) and reachable(b)
    achieves holding(a) or holding(b)
{statements}
"""


def seen(standing: int) -> Observation:
    """Return a moment in which so many cups stand on the table, and the others hang in the air."""
    places = {
        name: (0.3 + 0.1 * number, 0.0, 0.03 if number < standing else 0.5)
        for number, name in enumerate(NAMES)
    }
    cups = tuple(SceneObject(name, "Cup", (0.05, 0.05, 0.06)) for name in NAMES)
    table = SceneObject("table", "Table", (1.5, 1.5, 0.04))
    return Observation((*cups, table), {**places, "table": (0.5, 0.0, -0.02)}, (0.4, 0.3, 0.4), False)


@pytest.mark.parametrize("standing", range(6))
def test_as_many_hold_as_are_counted(standing: int) -> None:
    state = State(load_text(LIBRARY), seen(standing))
    for count in COUNTS:
        assert state.holds(Literal(f"least_{count}", ("table",))) is (standing >= count)
        assert state.holds(Literal(f"exact_{count}", ("table",))) is (standing == count)


CHANCES = st.lists(st.floats(0, 1), min_size=5, max_size=5)


def believed(chances: list[float]) -> Believed:
    of = dict(zip(NAMES, chances, strict=True))
    return Believed(load_text(LIBRARY), seen(0), {"on": lambda _, item, below: of[item]})


@settings(max_examples=40, deadline=None)
@given(CHANCES)
def test_counts_of_perceived_facts_agree_with_all_and_some(chances: list[float]) -> None:
    state = believed(chances)

    def likely(name: str) -> float:
        return float(state.probability(Literal(name, ("table",))))

    least = [likely(f"least_{count}") for count in COUNTS]
    assert least == sorted(least, reverse=True)
    assert (least[0], least[1], least[5], least[6]) == (1, max(chances), min(chances), 0)
    for count in COUNTS[:-1]:
        assert likely(f"exact_{count}") == min(least[count], 1 - least[count + 1])


@settings(max_examples=40, deadline=None)
@given(CHANCES.filter(lambda some: all(chance != 0.5 for chance in some)))
def test_a_count_holds_where_as_many_facts_are_more_probable_than_not(chances: list[float]) -> None:
    state, count = believed(chances), sum(chance > 0.5 for chance in chances)
    for number in COUNTS:
        assert (state.probability(Literal(f"least_{number}", ("table",))) > 0.5) is (count >= number)
        assert (state.probability(Literal(f"exact_{number}", ("table",))) > 0.5) is (count == number)


FILLING = """library filling
use containers

type Egg is Movable
type Bunny is Movable
program fill(b: Place):
    requires present(b) and reachable(b) and hollow(b)
    achieves ({count} in(e, b) for e in Egg) and some in(y, b) for y in Bunny
    for e in Egg: put_in(e, b)
    for y in Bunny: put_in(y, b)
task filling:
    scene:
        box: Place on table with bin(18 cm, 18 cm, 6 cm), at(38 cm, 30 cm)
        eggs: 4 Egg on table with cylinder(4 cm, 5 cm), y(-0.25 .. 0.1 m)
        bunnies: 2 Bunny on table with box(5 cm, 5 cm, 7 cm), y(-0.25 .. 0.1 m)
    run: fill(box)
    success: ({count} in(e, box) for e in Egg) and some in(y, box) for y in Bunny
"""


@pytest.mark.parametrize("learned", [False, True])
@pytest.mark.parametrize("count", ["exactly 2", "at least 2", "at least 1"])
def test_a_count_is_served_until_it_holds_whatever_else_is_to_be_done(
    count: str, learned: bool, tmp_path: Path
) -> None:
    path = tmp_path / "filling.ntp"
    path.write_text(FILLING.format(count=count))
    evaluator = Evaluator(Plan(path, "filling", shipped_core() if learned else None, seed=1))
    recorded = evaluator.demonstration(evaluator.instance(0), 0)[0] if learned else None
    assert evaluator.episode(0, recorded).success
    state = State(evaluator.registry, evaluator.world.truth())
    inside = [each for each in state.observation.positions if state.holds(Literal("in", (each, "box")))]
    assert sorted(each.rpartition("_")[0] for each in inside) == ["bunny"] + ["egg"] * int(count[-1])


def with_statements(*lines: str) -> str:
    return PROGRAM.format(statements="\n".join(f"    {line}" for line in lines))


def test_an_else_is_a_when_of_the_opposite() -> None:
    one = load_text(with_statements("when clear(a): pick(a)", "else: pick(b)"))
    two = load_text(with_statements("when clear(a): pick(a)", "when not clear(a): pick(b)"))
    assert [each.condition for each in one["p"].body] == [each.condition for each in two["p"].body]
    text = format_library(parse(with_statements("when clear(a): pick(a)", "else: pick(b)")))
    assert "\n    else:\n        pick(b)\n" in text and format_library(parse(text)) == text


@pytest.mark.parametrize(
    "lines",
    [
        ("else: pick(b)",),
        ("pick(a)", "else: pick(b)"),
        ("for c in Cup: pick(c)", "else: pick(b)"),
        ("when clear(a): pick(a)", "else: pick(b)", "else: pick(a)"),
        ("for c in Cup:", "    else: pick(c)"),
    ],
)
def test_an_else_without_a_when_is_explained(lines: tuple[str, ...]) -> None:
    found = diagnose_text(with_statements(*lines)).diagnostics
    assert ["an 'else' comes right after a 'when'" in each.message for each in found] == [True]


@pytest.mark.parametrize("count, told", [("1.5", "a whole number belongs here"), ("-1", "expected a number")])
def test_a_count_that_is_none_is_explained(count: str, told: str) -> None:
    found = diagnose_text(
        f"library l\nuse tabletop\npredicate p(): exactly {count} clear(o) for o in Object\n"
    )
    assert told in found.diagnostics[0].message


def test_at_and_least_are_no_words_of_their_own() -> None:
    text = "library l\nuse tabletop\npredicate at(a: Object, least: Object): on(a, least)\n"
    registry = load_text(f"{text}predicate p(o: Object): at least 2 at(o, least) for least in Object\n")
    assert set(registry.predicates) >= {"at", "p"}


@pytest.mark.parametrize("task", ["portions", "too_many"])
def test_a_scene_is_brought_to_a_count(task: str) -> None:
    library = Path(__file__).parents[1] / "evaluation" / "domains" / "portions"
    for seed in range(3):
        episode = Evaluator(Plan(library, task, None, seed=seed)).episode(0)
        assert episode.success, episode.reason


def test_what_is_wrong_with_a_condition_is_told_once_where_an_else_follows() -> None:
    text = with_statements("when claer(a): pick(a)", "else: pick(b)")
    found = diagnose_text(text).diagnostics
    assert [each.code for each in found].count("E102") == 1
    always = diagnose_text(with_statements("when present(a): pick(a)", "else: pick(b)")).diagnostics
    assert [(each.code, each.fix) for each in always if each.code == "W402"] == [("W402", None)]


def test_a_count_of_facts_of_the_state_needs_no_api_that_ends_them() -> None:
    text = """library l
use tabletop
type Drawer is Place
predicate open(d: Drawer) by state
api pull(d: Drawer)
    achieves open(d)
program p():
    achieves at least 2 open(d) for d in Drawer
    for d in Drawer: pull(d)
task t:
    scene: drawers: 3 Drawer on table
    run: p()
    success: at least 2 open(d) for d in Drawer
"""
    assert [str(each) for each in diagnose_text(text).diagnostics] == []
