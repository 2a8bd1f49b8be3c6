"""Every example's expert arrives, wherever it starts, with and without slips."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from ntp_dsl.common.resources import examples_folder
from ntp_dsl.execution.interpreter import Interpreter, Limits
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.goal_samplers import Goal
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.user_code.loading import load_with_python
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import Disturbances, Failure

STARTS, SOAKED = 10, 1000
EXAMPLES = sorted(path.name for path in examples_folder().iterdir() if path.is_dir())


def starts(objects: int, soak: bool) -> int:
    """Return a number of runs, fewer where a run takes longer."""
    if objects < 30:
        return SOAKED if soak else STARTS
    return (100 if objects < 60 else 10) if soak else int(objects < 60)


@pytest.mark.parametrize("slips", [0.0, 0.25])
@pytest.mark.parametrize("example", EXAMPLES)
def test_an_expert_reaches_the_goal_from_any_perturbed_start(soak: bool, example: str, slips: float) -> None:
    registry = load_with_python(example)
    policy = ScriptedPolicy(Expert(registry))
    world = make_world("kinematic", registry)
    for name in registry.tasks:
        objects = len(draw(registry, find_task(registry, name), np.random.default_rng(0)).objects)
        for seed in range(starts(objects, soak)):
            rng = np.random.default_rng(seed)
            instance = draw(registry, find_task(registry, name), rng)
            world.reset(instance.perturbed_start(rng), seed, Disturbances(slips=slips))
            limits = Limits(primitives=1000)
            interpreter = Interpreter(registry, policy, world, limits=limits)
            run = interpreter.run(instance.program, instance.arguments)
            seen = world.truth()
            state = State(registry, seen)
            lacking = [str(x) for x in instance.literals(registry, seen) if not state.holds(x)]
            assert run.done and not lacking, f"{name}, seed {seed}: {run.reason} {lacking}"


@pytest.mark.parametrize("example", EXAMPLES)
def test_a_drawn_goal_and_scene_hang_on_the_seed_alone(example: str) -> None:
    registry = load_with_python(example)
    for task in registry.tasks.values():
        first, again = (draw(registry, task, np.random.default_rng(7)) for _ in range(2))
        assert first == again
        scenes = [first.nominal_start(np.random.default_rng(8)) for _ in range(2)]
        assert scenes[0] == scenes[1]


def test_what_varies_is_held_to_the_ranges_that_are_given() -> None:
    registry = load_with_python("block_stacking")
    task = find_task(registry, "block_stacking")

    def goals(**ranges: tuple[int, int]) -> set[Goal]:
        varied = {"length": (5, 5), **ranges}
        return {draw(registry, task, np.random.default_rng(n), varied).goal for n in range(60)}

    def shape(goal: Goal) -> tuple[bool, ...]:
        return tuple(row["support"] == before["item"] for before, row in pairwise(goal))

    assert not goals(semantics=(0, 9)) & goals(semantics=(10, 19))
    assert len({shape(goal) for goal in goals(topology=(2, 2))}) == 1
    assert len({shape(goal) for goal in goals()}) > 1
    assert len(goals(semantics=(3, 3), topology=(1, 1))) == 1


@pytest.mark.parametrize("example", ["set_the_table", "table_cleanup"])
def test_a_sampler_in_python_can_be_held_as_well(example: str) -> None:
    registry = load_with_python(example)
    task = find_task(registry, example)

    def goals(**ranges: tuple[int, int]) -> set[Goal]:
        varied = {"length": (2, 2), **ranges}
        return {draw(registry, task, np.random.default_rng((n, 7)), varied).goal for n in range(60)}

    free, held = goals(), goals(semantics=(3, 3), topology=(1, 1))
    assert len(held) <= 6 < len(free)  # a scene of two or three bowls and one to three forks
    assert goals(semantics=(0, 0), topology=(5, 5)) != goals(semantics=(1, 1), topology=(6, 6))


def test_a_sampler_in_python_says_which_parameters_it_has() -> None:
    registry = load_with_python("blueprint")
    task = find_task(registry, "blueprint")
    with pytest.raises(NtpError, match="the sampler '.*' has no 'topology'; its function takes rng"):
        draw(registry, task, np.random.default_rng(0), {"topology": (0, 9)})


def test_a_skill_in_python_is_refused_where_what_its_api_requires_does_not_hold() -> None:
    registry = load_with_python("set_the_table")
    world, rng = make_world("kinematic", registry), np.random.default_rng(0)
    instance = draw(registry, find_task(registry, "set_the_table"), rng)
    world.reset(instance.nominal_start(rng), 0)
    before = world.truth()
    outcome = world.call("move_beside", ("plate_0", "left", 0.11))
    assert outcome.failure is Failure.NOT_READY and outcome.evidence == {"lacks": ["holding(any)"]}
    assert world.truth() == before


def test_a_function_that_is_missing_or_fails_is_named_with_its_line(tmp_path: Path) -> None:
    text = (examples_folder() / "blueprint" / "blueprint.ntp").read_text()
    (tmp_path / "mine.ntp").write_text(text.replace("library blueprint", "library mine"))
    with pytest.raises(NtpError, match=r"'build' is left to Python, and there is no file .*mine.py"):
        load_with_python(tmp_path / "mine.ntp")
    (tmp_path / "mine.py").write_text("def build(world, plan):\n    return None\n")
    with pytest.raises(NtpError, match=r"has no expert 'build'; write @expert above: def build"):
        load_with_python(tmp_path / "mine.ntp")
    (tmp_path / "mine.py").write_text("import nothing_of_that_name\n")
    with pytest.raises(NtpError, match=r"mine.py:1: the file cannot be imported: ModuleNotFoundError"):
        load_with_python(tmp_path / "mine.ntp")
