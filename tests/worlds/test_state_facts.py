"""Facts that no geometry decides: apis set and clear them, worlds, demonstrations and traces keep them."""

from __future__ import annotations

import json
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
from ntp_dsl.tasks.instances import draw, find_task, from_file
from ntp_dsl.traces.comparison.comparison_rules import overlap
from ntp_dsl.traces.comparison.state_differences import state_differences
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.user_code.loading import load_with_python
from ntp_dsl.worlds.catalogue import equip, make_world
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


@pytest.fixture(params=["kinematic", "bullet", "mujoco"])
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


MARKED = """library marked
use tabletop

type Shelf is Place
record Move(block: Block, shelf: Shelf)
predicate touched(b: Object) by state

api grab(b: Object) by grasp
    requires above(gripper, b) and reachable(b) and clear(b) and empty(gripper)
    achieves holding(b) and touched(b)

program take(b: Block, s: Shelf):
    requires present(b) and reachable(b) and present(s) and reachable(s)
    achieves on(b, s) and touched(b)
    put_down()
    clear(b)
    move_to(b)
    grab(b)
    clear(s)
    place(b, s)

program each(goal: list[Move]):
    achieves all on(m.block, m.shelf) and touched(m.block) for m in goal
    for m in goal:
        take(m.block, m.shelf)

task t:
    scene:
        blocks:  3 Block on table
        shelves: 3 Shelf on table with box(8 cm, 8 cm, 1 cm)
    goal:    permutations(blocks, shelves, length=2) -> list[Move]
    run:     each(goal)
    success: all on(m.block, m.shelf) and touched(m.block) for m in goal
"""


def test_a_skill_that_changes_the_state_as_well_is_one_call(tmp_path: Path) -> None:
    """The hand closes some frames before the fact holds: both belong to the same primitive."""
    (tmp_path / "marked.ntp").write_text(MARKED)
    evaluator = Evaluator(Plan(tmp_path / "marked.ntp", "t", shipped_core(), seed=1))
    instance = evaluator.instance(0)
    recorded, _ = evaluator.demonstration(instance, 0)
    source = evaluator._model.read(recorded.demonstration)
    reading = source.reading(instance.program, instance.arguments, source.scope())
    assert reading.is_whole
    shown = [call.scope for call in reading.call.walk() if call.name == "grab"]
    assert recorded.calls is not None
    own = [call.scope for call in recorded.calls.walk() if call.name == "grab"]
    assert all(overlap(one, other) > 0.8 for one, other in zip(shown, own, strict=True))


def test_a_skill_that_no_world_has_is_not_taken_for_an_act_of_the_state() -> None:
    text = TRUCKS.replace("api drive(t: Truck, d: Depot)", "api drive(t: Truck, d: Depot) by drvie")
    with pytest.raises(NtpError, match="nothing for drive"):
        make_world("kinematic", diagnose_text(text).checked())


def test_check_needs_nothing_that_moves() -> None:
    registry = diagnose_text(TRUCKS.replace("Truck is Movable", "Truck is Place")).checked()
    assert [each for each in check_dynamically(registry) if each.severity == "error"] == []


def test_two_states_differ_by_their_facts(world: World) -> None:
    before = world.truth()
    world.call("drive", ("truck_0", "depot_2"))
    found = state_differences(before, world.truth())
    assert found is not None
    assert found.only_in_a == ("at(truck_0, depot_0)",)
    assert found.only_in_b == ("at(truck_0, depot_2)",)


def test_a_file_of_tasks_has_what_the_task_names(tmp_path: Path) -> None:
    registry = load_with_python(KITCHENETTE)
    objects = [{"name": name, "type": "Thing", "size": [0.03, 0.03, 0.05]} for name in ("thing_0", "thing_1")]
    objects += [{"name": "drawer_7", "type": "Drawer", "size": [0.16, 0.16, 0.05], "shape": "bin"}]
    row = {"thing": "thing_0", "drawer": "drawer_7"}
    path = tmp_path / "tasks.json"
    path.write_text(
        json.dumps(
            {"format": "ntp-tasks", "version": 2, "tasks": [{"id": "one", "objects": objects, "goal": [row]}]}
        )
    )
    with pytest.raises(NtpError, match="lacks drawer_1"):
        from_file(registry, find_task(registry, "kitchenette"), path)
    path.write_text(path.read_text().replace("drawer_7", "drawer_1"))
    [instance] = from_file(registry, find_task(registry, "kitchenette"), path)
    assert instance.facts == {DeclaredFact("open", ("drawer_1",))}


def test_not_of_any_object_is_not_of_all() -> None:
    text = TRUCKS.replace(
        "achieves at(t, d) and all not at(t, other) for other in Depot if other != d",
        "achieves not at(t, any)",
    )
    registry = diagnose_text(text).checked()
    world = make_world("kinematic", registry)
    instance = draw(registry, find_task(registry, "t"), np.random.default_rng(0))
    world.reset(instance.nominal_start(np.random.default_rng(0)), 0)
    assert world.call("drive", ("truck_0", "depot_2")).achieved
    assert world.truth().facts == {at("truck_1", "depot_0")}


def test_a_world_has_the_skills_of_the_last_library_alone(world: World) -> None:
    equip(
        world,
        diagnose_text(
            TRUCKS.replace("achieves at(t, d) and", "requires away(t)\n    achieves at(t, d) and")
        ).checked(),
    )
    assert world.call("drive", ("truck_0", "depot_2")).failure is Failure.NOT_READY
