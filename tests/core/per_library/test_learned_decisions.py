"""What a learned decision may depend on, and what it may not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from core_samples import queries, renamed, reordered, shown_task

from ntp_dsl.core.per_library.checkpoint import Checkpoint
from ntp_dsl.core.per_library.policy import LearnedPolicy
from ntp_dsl.demonstrations.demonstration import UNKNOWN
from ntp_dsl.demonstrations.queries import Answer, Query
from ntp_dsl.execution.interpreter import Interpreter
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.starts import nominal_start

SEEDS = range(8)


def ask(checkpoint: Checkpoint, query: Query) -> Answer:
    return LearnedPolicy(checkpoint.core, query.demonstration).answer(query)[0]


@pytest.mark.parametrize("seed", SEEDS)
def test_names_of_objects_do_not_matter(stacking: Registry, shipped: Checkpoint, seed: int) -> None:
    for query in queries(stacking, seed):
        names = {t.name: f"object {n}" for n, t in enumerate(query.observation.objects)}
        plain, other = ask(shipped, query), ask(shipped, renamed(query, names))
        assert other == replace(plain, arguments=tuple(names[str(name)] for name in plain.arguments))


@pytest.mark.parametrize("seed", SEEDS)
def test_the_order_of_objects_does_not_matter(stacking: Registry, shipped: Checkpoint, seed: int) -> None:
    for query in queries(stacking, seed):
        assert ask(shipped, reordered(query, seed)) == ask(shipped, query)


@pytest.mark.parametrize("seed", SEEDS)
def test_one_more_object_out_of_the_way_does_not_matter(
    stacking: Registry, shipped: Checkpoint, seed: int
) -> None:
    extra = SceneObject("extra", "Block", (0.05, 0.05, 0.05))
    for query in queries(stacking, seed):
        seen, shown = query.observation, query.demonstration
        table = shown.positions[:, shown.names.index("table")]
        far = table + np.subtract((0.95, 0.45, 0.025), seen.positions["table"])
        wider = replace(
            query,
            observation=replace(
                seen,
                objects=(*seen.objects, extra),
                positions={**seen.positions, "extra": (0.95, 0.45, 0.025)},
            ),
            demonstration=replace(
                shown,
                objects=(*shown.objects, extra),
                positions=np.concatenate([shown.positions, far[:, None]], 1),
            ),
        )
        assert ask(shipped, wider) == ask(shipped, query)


class OnlyObserved(KinematicWorld):
    """A world that keeps to itself all that a learned program is not given."""

    def __init__(self) -> None:
        super().__init__()
        self.sealed = False

    def truth(self) -> Observation:
        assert not self.sealed, "a learned program asked for the truth"
        return super().truth()

    def supported(self, item: str, support: str) -> bool:
        raise AssertionError("a learned program asked for contacts")


@pytest.mark.parametrize("seed", SEEDS)
def test_the_scene_is_declared_for_one_goal_the_demonstration_shows_another_and_that_is_built(
    stacking: Registry, shipped: Checkpoint, seed: int
) -> None:
    declared = draw(stacking, find_task(stacking, "block_stacking"), np.random.default_rng(1000 + seed))
    demonstrated, shown = shown_task(stacking, seed)
    assert declared.goal != demonstrated.goal
    world = KinematicWorld()
    world.reset(nominal_start(declared.objects, np.random.default_rng(seed)), seed)
    policy = LearnedPolicy(shipped.core, replace(shown.demonstration, origin=UNKNOWN))
    Interpreter(stacking, policy, world).run(declared.program, declared.arguments)
    state = State(stacking, world.truth())
    assert all(state.holds(x) for x in demonstrated.literals(stacking, world.truth()))


@pytest.mark.parametrize("seed", SEEDS)
def test_a_learned_program_calls_only_what_its_declaration_names_on_objects_of_the_declared_types(
    stacking: Registry, shipped: Checkpoint, seed: int
) -> None:
    for query in queries(stacking, seed):
        answer = ask(shipped, query)
        if answer.callee is None:
            continue
        assert answer.callee in stacking.programs[query.program].callees
        types = {obj.name: obj.type for obj in query.observation.objects}
        parameters = [p for p in stacking[answer.callee].parameters if not p.is_list]
        for name, parameter in zip(answer.arguments, parameters, strict=True):
            assert stacking.is_a(types[name], parameter.type)


def test_the_query_of_a_learned_program_has_no_room_for_a_goal() -> None:
    given = set(Query.__dataclass_fields__)
    assert given == {"program", "arguments", "scope", "observation", "demonstration"}


def test_a_demonstration_that_lacks_a_object_of_the_scene_is_refused(
    stacking: Registry, shipped: Checkpoint
) -> None:
    query = next(query for query in queries(stacking, 0) if query.scope is not None)
    shown = query.demonstration
    lacking = replace(shown, objects=shown.objects[1:], positions=shown.positions[:, 1:])
    with pytest.raises(NtpError, match="lacks block_0"):
        ask(shipped, replace(query, demonstration=lacking))


def test_the_core_agrees_with_the_expert_in_perturbed_starts(stacking: Registry, shipped: Checkpoint) -> None:
    expert, right, asked = Expert(stacking), 0, 0
    for seed in range(40):
        for query in queries(stacking, 100 + seed):
            if query.scope is not None:
                continue  # what its list says only the demonstration shows
            state = State(stacking, query.observation)
            wanted = expert.decide(query.program, query.arguments, state)
            answer = ask(shipped, query)
            expected = getattr(wanted, "callee", None), getattr(wanted, "arguments", ())
            right += (answer.callee, answer.arguments) == expected
            asked += 1
    assert right / asked > 0.97, f"{right} of {asked}"
