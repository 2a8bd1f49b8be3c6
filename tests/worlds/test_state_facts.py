"""Facts that no geometry decides: apis set and clear them, worlds, demonstrations and traces keep them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ntp_dsl.core.one_core import shipped_core
from ntp_dsl.demonstrations.demonstration_files import read_demonstration, write_demonstration
from ntp_dsl.dynamic.check import check_dynamically
from ntp_dsl.evaluation.episodes import Evaluator, Plan, run_all
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import diagnose_text, load
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import DeclaredFact
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import Failure, World

KITCHENETTE = Path(__file__).parents[1] / "evaluation" / "domains" / "kitchenette"
TRUCKS = """library trucks
use tabletop

type Truck is Movable
type Depot is Place
predicate at(t: Truck, d: Depot) by state
predicate away(t: Truck): not some at(t, d) for d in Depot

api drive(t: Truck, d: Depot)
    achieves at(t, d) and all not at(t, other) for other in Depot if other != d
api leave(t: Truck)
    requires not away(t)
    achieves away(t)

program bring(t: Truck, d: Depot):
    achieves at(t, d)
    drive(t, d)

task t:
    scene:
        trucks: 2 Truck on table
        depots: 3 Depot on table
    initially: at(trucks, depot_0)
    run: bring(truck_0, depot_2)
    success: at(truck_0, depot_2) and not at(truck_0, depot_0)
"""


def at(*names: str) -> DeclaredFact:
    return DeclaredFact("at", names)


@pytest.fixture(params=["kinematic", "bullet"])
def world(request: pytest.FixtureRequest) -> World:
    registry = trucks()
    found = make_world(request.param, registry)
    instance = draw(registry, find_task(registry, "t"), np.random.default_rng(0))
    found.reset(instance.nominal_start(np.random.default_rng(0)), 0)
    return found


def trucks() -> Registry:
    return diagnose_text(TRUCKS).checked()


def test_a_group_stands_for_each_of_its_objects(world: World) -> None:
    assert world.truth().facts == {at("truck_0", "depot_0"), at("truck_1", "depot_0")}


def test_an_api_sets_and_clears_what_it_achieves(world: World) -> None:
    assert world.call("drive", ("truck_0", "depot_2")).achieved
    assert world.observe().facts == {at("truck_0", "depot_2"), at("truck_1", "depot_0")}


def test_a_predicate_with_a_body_is_taken_apart(world: World) -> None:
    """What `away` says is that none of some facts holds: each is cleared."""
    assert world.call("leave", ("truck_1",)).achieved
    assert world.truth().facts == {at("truck_0", "depot_0")}


def test_an_api_is_refused_where_its_requirements_fail(world: World) -> None:
    world.call("leave", ("truck_1",))
    outcome = world.call("leave", ("truck_1",))
    assert outcome.failure is Failure.NOT_READY
    assert world.truth().facts == {at("truck_0", "depot_0")}


def test_what_geometry_decides_needs_a_skill() -> None:
    text = TRUCKS.replace("achieves away(t)", "achieves away(t) and above(gripper, t)")
    with pytest.raises(NtpError, match="nothing for leave"):
        make_world("kinematic", diagnose_text(text).checked())


def test_check_simulates_a_library_of_state_alone() -> None:
    errors = [each for each in check_dynamically(trucks()) if each.severity == "error"]
    assert errors == []


def test_a_demonstration_keeps_the_facts_of_every_frame(tmp_path: Path) -> None:
    evaluator = Evaluator(Plan(KITCHENETTE, "kitchenette", shipped_core(), seed=3))
    recorded, _ = evaluator.demonstration(evaluator.instance(0), 0)
    shown = recorded.demonstration
    assert shown.facts is not None and len(set(shown.facts)) > 2
    write_demonstration(shown, tmp_path / "one.parquet")
    assert read_demonstration(tmp_path / "one.parquet").facts == shown.facts


def test_traces_keep_them_too(tmp_path: Path) -> None:
    plan = Plan(KITCHENETTE, "cook", None, seed=3, traces=tmp_path)
    [episode] = run_all(plan, 1, workers=1)
    assert episode.success
    trace = read_trace(tmp_path / "episode_00000.trace.jsonl")
    kinds = {state.facts for state in trace.states}
    assert DeclaredFact("lit", ("burner_2",)) in min(kinds, key=len)
    assert len(kinds) > 1


@pytest.mark.parametrize("task", ["kitchenette", "cook"])
def test_the_acts_that_change_them_are_explained(task: str) -> None:
    evaluator = Evaluator(Plan(KITCHENETTE, task, shipped_core(), seed=5))
    for number in range(3):
        instance = evaluator.instance(number)
        recorded, _ = evaluator.demonstration(instance, number)
        source = evaluator._model.read(recorded.demonstration)
        reading = source.reading(instance.program, instance.arguments, source.scope())
        assert reading.is_whole
        assert set(reading.arguments[0]) == set(instance.arguments[0])


def test_the_library_is_sound() -> None:
    assert load(KITCHENETTE).name == "kitchenette"


def test_a_predicate_may_be_called_state_and_be_none() -> None:
    text = TRUCKS.replace(
        "predicate away", "enum Wear: old, fresh\npredicate state(t: Truck) -> Wear\npredicate away"
    )
    text = text.replace("2 Truck on table", "2 Truck on table with state(old, fresh)")
    registry = diagnose_text(text).checked()
    world = make_world("kinematic", registry)
    instance = draw(registry, find_task(registry, "t"), np.random.default_rng(0))
    world.reset(instance.nominal_start(np.random.default_rng(0)), 0)
    state = State(registry, world.truth())
    assert [state.reading("state", (name,)) for name in ("truck_0", "truck_1")] == ["old", "fresh"]
