"""How often something has failed: what the worlds count of it, and what programs make of that."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ntp_dsl.core.one_core import shipped_core
from ntp_dsl.core.perception.steadied import steadied
from ntp_dsl.datasets.recording import RecordedDemonstration, demonstrate
from ntp_dsl.evaluation.episodes import Plan, run_all
from ntp_dsl.language.loader import load_text
from ntp_dsl.policies.expert import Expert
from ntp_dsl.semantics.attempts import after_attempt, failures, reads_failures, without_attempts
from ntp_dsl.semantics.observation import DeclaredFact, Observation
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.user_code.loading import load_with_python
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import ACHIEVED, Failure, Outcome

JAMMED = Path(__file__).parents[1] / "evaluation" / "domains" / "jammed"
OTHER = DeclaredFact("open", ("a",))
APIS = ["pull", "pry"]
TRIES = st.lists(st.tuples(st.sampled_from("ab"), st.sampled_from(APIS), st.booleans()), max_size=12)


def seen(facts: frozenset[DeclaredFact]) -> Observation:
    return Observation((), {}, (0.4, 0.0, 0.4), False, facts=facts)


@given(TRIES)
def test_failures_in_a_row_are_counted_for_each_object_and_api(tries: list[tuple[str, str, bool]]) -> None:
    facts = frozenset({OTHER})
    counts: dict[tuple[str, str], int] = {}
    for item, api, achieved in tries:
        facts = after_attempt(facts, api, {item}, achieved)
        counts[item, api] = 0 if achieved else counts.get((item, api), 0) + 1
    for item in "ab":
        most = max((count for (name, _), count in counts.items() if name == item), default=0)
        assert failures(seen(facts), item) == most
    assert without_attempts(facts) == {OTHER}


@pytest.mark.parametrize("failure", Failure)
def test_what_was_missing_dropped_or_not_ready_is_no_attempt(failure: Failure) -> None:
    none = {Failure.NOT_READY, Failure.MISSING_OBJECT, Failure.OBJECT_DROPPED}
    assert Outcome(False, failure).is_failed_attempt is (failure not in none)
    assert not ACHIEVED.is_failed_attempt


@pytest.mark.parametrize("world", ["kinematic", "bullet", "mujoco"])
def test_a_world_counts_what_fails_where_a_library_asks(world: str) -> None:
    registry = load_with_python(JAMMED)
    instance = draw(registry, find_task(registry, "jammed"), np.random.default_rng(0))
    there = make_world(world, registry)
    there.reset(instance.nominal_start(np.random.default_rng(0)), 0)
    stuck, free = "drawer_1", "drawer_0"
    for count in (1, 2, 3):
        assert there.call("move_to", (stuck,))
        assert not there.call("pull", (stuck,))
        assert failures(there.truth(), stuck) == count and failures(there.truth(), free) == 0
    assert not there.call("pull", (free,)).is_failed_attempt  # the hand is not there: nothing is counted
    assert failures(there.truth(), free) == 0
    assert there.call("pry", (stuck,)) and failures(there.truth(), stuck) == 3


def shown(seed: int) -> RecordedDemonstration:
    registry = load_with_python(JAMMED)
    instance = draw(registry, find_task(registry, "jammed"), np.random.default_rng(seed))
    found = demonstrate(registry, Expert(registry), make_world("kinematic", registry), instance, seed)
    assert isinstance(found, RecordedDemonstration)
    return found


def test_a_failed_attempt_is_no_act_of_a_demonstration() -> None:
    found = shown(3)
    assert found.calls is not None
    opened = [each for each in found.calls.walk() if each.name in ("pull", "pry") and each.done]
    assert {each.name for each in found.calls.walk()} >= {"pull", "pry"}
    assert len(steadied(found.demonstration).events) == len({each.arguments for each in opened})


@pytest.mark.parametrize("model", [None, shipped_core()])
def test_what_is_stuck_is_tried_twice_and_then_done_otherwise(model: Path | None, tmp_path: Path) -> None:
    plan = Plan(JAMMED, "jammed", model, seed=3, traces=tmp_path)
    assert all(each.success for each in run_all(plan, 4, workers=1))
    for path in sorted(tmp_path.glob("*.jsonl")):
        calls: Mapping[str, list[str]] = {"pull": [], "pry": []}
        for each in read_trace(path).calls:
            if each.name in calls:
                calls[each.name].append(str(each.arguments[0]))
        stuck = {"drawer_1", "drawer_3"}
        assert set(calls["pry"]) <= stuck and all(calls["pull"].count(name) == 2 for name in calls["pry"])
        assert all(calls["pull"].count(name) <= 1 for name in {*calls["pull"]} - stuck)


def test_failures_are_counted_by_whatever_name_and_only_where_they_are_read() -> None:
    head = "library l\nuse tabletop\n"
    assert reads_failures(load_text(head + "predicate tries(o: Object) -> number by failures\n"))
    assert not reads_failures(load_text(head + "predicate failures(o: Object): not clear(o)\n"))
    make_world("kinematic", load_text(head + "predicate tries(o: Object) -> number by failures\n"))
