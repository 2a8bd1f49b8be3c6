"""Facts with probabilities: thresholded they are the exact ones, and gradients run through composed ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any

import pytest
import torch
from films import AWAY, cube
from hypothesis import given, settings
from hypothesis import strategies as st
from one_core_samples import library, the_core

from ntp_dsl.api import draw, expert_policy, run
from ntp_dsl.core.perception.perceived import Believed, Perceived
from ntp_dsl.language.loader import load_text
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.policies.protocol import Barred, Choice, Frame, Policy
from ntp_dsl.semantics.facts import Literal
from ntp_dsl.semantics.observation import Observation
from ntp_dsl.semantics.predicates import ANY
from ntp_dsl.semantics.state import State

AGREE, OF_EACH = 0.995, 0.99
HAIR = 0.0002  # [m]
TEXT = """
library facts
use tabletop
predicate apart(a: Object, b: Object): not (on(a, b) or on(b, a))
predicate stacked(a: Object, b: Object, c: Object): on(a, b) and on(b, c)
predicate lonely(a: Object): all apart(a, b) for b in Object if b != a
predicate loaded(a: Object): some on(b, a) for b in Object
predicate tidy(a: Object, b: Object, c: Object): (stacked(a, b, c) or apart(a, c)) and not holding(b)
"""


class Watched:
    """A policy, of which every state is kept that it decided in."""

    def __init__(self, policy: Policy) -> None:
        self._policy, self.seen = policy, []  # type: ignore[var-annotated]

    def root(self, program: str, arguments: Any) -> Frame:
        return self._policy.root(program, arguments)

    def decide(self, frame: Frame, world: Any, barred: Barred = frozenset()) -> Choice:
        self.seen.append(world.truth())
        return self._policy.decide(frame, world, barred)


def all_facts(registry: Registry, state: State) -> Iterator[Literal]:
    """Yield every literal over objects, constants and members of the predicates that are no readings."""
    for declared in registry.predicates.values():
        if declared.result is not None:
            continue
        options = [state.values(parameter.type.name) for parameter in declared.parameters]
        if all(options):
            yield from (Literal(declared.name, values) for values in product(*options))


def lifted(seen: Observation, by: float) -> Observation:
    x, y, z = seen.gripper
    return replace(seen, gripper=(x, y, z + by))


@pytest.mark.parametrize(
    "name", ["block_stacking", "seating", "table_cleanup", "object_sorting", "set_the_table"]
)
def test_on_true_observations_facts_are_the_exact_ones(name: str) -> None:
    facts: dict[str, list[bool]] = {}
    true: dict[str, int] = {}
    for seed in range(2):
        task = draw(library(name), name, seed)
        watched = Watched(expert_policy(task))
        run(task, watched)
        moments = list({id(each): each for each in watched.seen}.values())
        for seen in moments[:: max(1, len(moments) // 10)]:
            exact = State(task.registry, seen)
            believed = Perceived(task.registry, seen, the_core().grounding)
            shifted = [State(task.registry, lifted(seen, by)) for by in (-HAIR, HAIR)]
            for fact in all_facts(task.registry, exact):
                holds = exact.holds(fact)
                if any(each.holds(fact) is not holds for each in shifted):
                    continue  # a hand over a tower is just as high over its third block as counts as above
                facts.setdefault(fact.predicate, []).append(believed.holds(fact) is holds)
                true[fact.predicate] = true.get(fact.predicate, 0) + holds
    shares = {name: sum(agree) / len(agree) for name, agree in facts.items()}
    assert {name: share for name, share in shares.items() if share < OF_EACH} == {}
    every = [each for agree in facts.values() for each in agree]
    assert sum(every) / len(every) >= AGREE
    assert {"on", "clear", "holding", "above", "empty"} <= {name for name, count in true.items() if count}


def test_a_fact_holds_where_it_is_more_probable_than_not() -> None:
    task = draw(library("table_cleanup"), "table_cleanup", 0)
    watched = Watched(expert_policy(task))
    run(task, watched)
    for seen in watched.seen[::9]:
        believed = Perceived(task.registry, seen, the_core().grounding)
        for fact in all_facts(task.registry, believed):
            assert believed.holds(fact) is (float(believed.probability(fact)) > 0.5), fact


def test_what_does_not_hold_is_as_probable_as_its_complement() -> None:
    believed = tensors_of([0.3, 0.9, 0.2, 0.6, 0.1])[0]
    for fact in all_facts(believed.registry, believed):
        opposite = Literal(fact.predicate, fact.arguments, positive=False)
        assert number(believed.probability(fact)) + number(believed.probability(opposite)) == pytest.approx(1)


def test_a_fact_of_any_holds_where_it_holds_of_something() -> None:
    task = draw(library("table_cleanup"), "table_cleanup", 0)
    watched = Watched(expert_policy(task))
    run(task, watched)
    true: dict[str, int] = {}
    for seen in watched.seen[::9]:
        exact = State(task.registry, seen)
        believed = Perceived(task.registry, seen, the_core().grounding)
        for predicate, below in product(("on", "in", "stowed", "covers"), exact.objects("Place")):
            of_any = Literal(predicate, (ANY, below))
            each = [Literal(predicate, (item, below)) for item in exact.objects("Object")]
            assert exact.holds(of_any) is any(map(exact.holds, each))
            assert believed.probability(of_any) == max(map(believed.probability, each))
            assert believed.holds(of_any) is any(map(believed.holds, each))
            true[predicate] = true.get(predicate, 0) + exact.holds(of_any)
    assert all(true.values())


def test_what_a_fact_provides_holds_where_it_does() -> None:
    """Of any object and of one, negated and not."""
    task = draw(library("table_cleanup"), "table_cleanup", 0)
    watched = Watched(expert_policy(task))
    run(task, watched)
    provided = 0
    for seen in watched.seen[::20]:
        state = State(task.registry, seen)
        below = state.objects("Tray")[0]
        some = [
            Literal("in", (item, below), way)
            for item in [ANY, *state.objects("Fork")]
            for way in (True, False)
        ]
        for one, other in product(some, some):
            if one.provides(other):
                provided += one != other
                assert state.holds(other) or not state.holds(one), (one, other)
    assert provided


# Gradients

OBJECTS = ("a", "b", "c")
PAIRS = [(x, y) for x in OBJECTS for y in OBJECTS if x != y]


def tensors_of(values: list[float]) -> tuple[Believed, dict[tuple[str, ...], torch.Tensor]]:
    """Return a state of three cubes, and the tensors that its facts are as probable as."""
    keys: list[tuple[str, ...]] = [*PAIRS, *((each,) for each in OBJECTS)]
    chances = {
        key: torch.tensor(values[index % len(values)], dtype=torch.float64, requires_grad=True)
        for index, key in enumerate(keys)
    }
    zero = torch.zeros((), dtype=torch.float64)
    seen = Observation(
        tuple(map(cube, OBJECTS)), {name: (0.5, 0.1 * i, 0.02) for i, name in enumerate(OBJECTS)}, AWAY, False
    )
    of_facts = {
        "on": lambda _, *pair: chances.get(pair, zero),
        "holding": lambda _, item: chances.get((item,), zero),
        **{name: lambda *_: zero for name in ("covers", "clear", "empty", "above", "present", "reachable")},
    }
    return Believed(load_text(TEXT), seen, of_facts), chances


def number(probability: Any) -> float:
    return float(probability.detach() if isinstance(probability, torch.Tensor) else probability)


DISTINCT = st.lists(
    st.floats(0.01, 0.99), min_size=9, max_size=9, unique_by=lambda p: round(min(p, 1 - p), 6)
)


@settings(max_examples=40, deadline=None)
@given(DISTINCT)
def test_composed_probabilities_are_minima_maxima_and_complements(values: list[float]) -> None:
    believed, chances = tensors_of(values)
    p = {key: float(value.detach()) for key, value in chances.items()}

    def of(name: str, *arguments: str) -> float:
        return number(believed.probability(Literal(name, arguments)))

    apart = {pair: 1 - max(p[pair], p[pair[::-1]]) for pair in PAIRS}
    stacked = min(p["a", "b"], p["b", "c"])
    assert of("apart", "a", "b") == pytest.approx(apart["a", "b"])
    assert of("stacked", "a", "b", "c") == pytest.approx(stacked)
    assert of("lonely", "a") == pytest.approx(min(apart["a", "b"], apart["a", "c"]))
    assert of("loaded", "c") == pytest.approx(max(p["a", "c"], p["b", "c"]))
    assert of("tidy", "a", "b", "c") == pytest.approx(min(max(stacked, apart["a", "c"]), 1 - p["b",]))


@settings(max_examples=40, deadline=None)
@given(DISTINCT, st.sampled_from(["apart a b", "stacked a b c", "lonely a", "loaded c", "tidy a b c"]))
def test_gradients_run_to_the_one_fact_that_decides(values: list[float], text: str) -> None:
    """Of minima, maxima and complements the gradient is 1 or -1 at one fact, and 0 at all others."""
    name, *arguments = text.split()
    believed, chances = tensors_of(values)
    probability = believed.probability(Literal(name, tuple(arguments)))
    assert isinstance(probability, torch.Tensor) and probability.requires_grad
    probability.backward()  # type: ignore[no-untyped-call]
    slopes = {
        key: float(each.grad) for key, each in chances.items() if each.grad is not None and float(each.grad)
    }
    assert len(slopes) == 1
    ((deciding, slope),) = slopes.items()
    expected = number(chances[deciding]) if slope > 0 else 1 - number(chances[deciding])
    assert abs(slope) == 1 and number(probability) == pytest.approx(expected)


def test_gradients_run_through_conditions_too() -> None:
    believed, chances = tensors_of([0.2, 0.7, 0.4, 0.6, 0.55])
    condition = nodes.And(
        (
            nodes.Atom("on", (nodes.Name("a"), nodes.Name("b"))),
            nodes.Not(nodes.Atom("holding", (nodes.Name("c"),))),
        )
    )
    believed.likely(condition, {}).backward()
    assert [key for key, each in chances.items() if each.grad] == [("a", "b")]


def test_what_is_declared_in_python_is_certain() -> None:
    task = draw(library("set_the_table"), "set_the_table", 0)
    watched = Watched(expert_policy(task))
    run(task, watched)
    believed = Perceived(task.registry, watched.seen[-1], the_core().grounding)
    for fact in all_facts(task.registry, believed):
        if fact.predicate in ("beside", "near", "over"):
            assert believed.probability(fact) in (0.0, 1.0)


def test_functions_in_python_are_as_sure_as_objects_are_seen() -> None:
    task = draw(library("line_up"), "line_up", 0)
    watched = Watched(expert_policy(task))
    run(task, watched)
    seen = watched.seen[-1]
    program = task.registry.programs[task.instance.program]

    def certainty(deviation: float) -> float:
        deviations = dict.fromkeys(seen.positions, deviation) if deviation else {}
        state = Perceived(task.registry, replace(seen, deviations=deviations), the_core().grounding)
        facts = state.literals(program.achieves, program.bind(task.instance.arguments))
        return sum(weight for weight, each in state.variants(facts) if all(map(each.holds, facts)))

    found = [certainty(deviation) for deviation in (0.0, 0.001, 0.006, 0.02)]
    assert found[0] == 1 and found == sorted(found, reverse=True)
    assert found[1] > 0.9 and found[-1] < 0.5
