"""The public names: what they say of themselves, and that they do what the command line does."""

from __future__ import annotations

import pickle
import re
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import ntp_dsl
from ntp_dsl.authoring import ACHIEVED, skill
from ntp_dsl.cli.app import run as command
from ntp_dsl.common.resources import checkpoints_folder
from ntp_dsl.demonstrations.demonstration import UNKNOWN
from ntp_dsl.traces.decision import Decision
from ntp_dsl.traces.schema import PolicyKind

DOCUMENT = (Path(__file__).parents[2] / "docs" / "api.md").read_text(encoding="utf-8")
NAMES = [name for name in ntp_dsl.__all__ if not name.startswith("_")]
SPINNING = """
library spinning
use tabletop
api spin(item: Movable) by python
program whirl(item: Movable):
    requires present(item) and reachable(item)
    achieves holding(item)
    pick(item)
    spin(item)
"""


@pytest.mark.parametrize("name", NAMES)
def test_a_public_name_is_there_and_documented(name: str) -> None:
    value = getattr(ntp_dsl, name)
    assert value.__doc__ and value.__doc__.strip()
    assert re.search(rf"`(?:[^`]*\W)?{name}\b", DOCUMENT), f"docs/api.md says nothing of {name}"


def test_the_names_are_few_and_dir_lists_them() -> None:
    assert len(NAMES) <= 32 and dir(ntp_dsl) == ntp_dsl.__all__
    with pytest.raises(AttributeError, match="no attribute 'juggle'"):
        _ = ntp_dsl.juggle


def test_the_package_imports_nothing_until_a_name_is_used() -> None:
    program = "import ntp_dsl, sys; dir(ntp_dsl); print([m for m in sys.modules if m.startswith('ntp_dsl.')])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_an_episode_is_the_one_that_the_command_carries_out(tmp_path: Path) -> None:
    words = ["run", "block_stacking", "few_placements", "--world", "kinematic", "--seed", "5"]
    assert command([*words, "--slips", ".3", "--out", str(tmp_path)]) == 0
    theirs = ntp_dsl.read_trace(tmp_path / "episode_00000.trace.jsonl")
    task = ntp_dsl.draw(ntp_dsl.load("block_stacking"), "few_placements", seed=5)
    policy = ntp_dsl.learned_policy(task, ntp_dsl.demonstrate(task))
    episode = ntp_dsl.run(task, policy, disturbances=ntp_dsl.Disturbances(slips=0.3))
    assert episode.success and episode.trace.header.policy is PolicyKind.LEARNED
    assert ntp_dsl.compare(theirs, episode.trace).first is None
    assert episode.trace.motions == theirs.motions


def test_a_library_is_checked_by_its_name_or_its_path(tmp_path: Path) -> None:
    assert ntp_dsl.diagnose("block_stacking").is_sound
    (tmp_path / "mine.ntp").write_text("library mine\nuse nothing_there\n")
    assert not ntp_dsl.diagnose(tmp_path / "mine.ntp").is_sound
    with pytest.raises(ntp_dsl.NtpError, match="there is no library at 'nowhere'"):
        ntp_dsl.diagnose("nowhere")


def test_a_library_of_text_says_what_is_wrong_with_it() -> None:
    report = ntp_dsl.diagnose_text("library mine\nuse tabletop\nprogram p(x: Objekt):\n    pick(x)\n")
    assert not report.is_sound and "Objekt" in repr(report) and "did you mean 'Object'" in repr(report)
    with pytest.raises(ntp_dsl.NtpError, match="Objekt"):
        ntp_dsl.load_text("library mine\nuse tabletop\nprogram p(x: Objekt):\n    pick(x)\n")


def test_a_function_that_was_not_given_is_asked_for() -> None:
    with pytest.raises(ntp_dsl.NtpError, match="no skill 'spin' was given; write @skill above: def spin"):
        ntp_dsl.load_text(SPINNING)

    @skill
    def spin(world: object) -> None: ...

    with pytest.raises(ntp_dsl.NtpError, match=r"'spin' is called as spin\(world, item\)"):
        ntp_dsl.load_text(SPINNING, functions=[spin])


def test_what_is_asked_for_in_vain_is_told_in_a_sentence() -> None:
    registry = ntp_dsl.load("block_stacking")
    with pytest.raises(ntp_dsl.NtpError, match="no task is called 'juggle'"):
        ntp_dsl.draw(registry, "juggle")
    with pytest.raises(ntp_dsl.NtpError, match="no world is called 'moon'"):
        ntp_dsl.make_world("moon", registry)
    with pytest.raises(ntp_dsl.NtpError, match="no camera"):
        ntp_dsl.picture(ntp_dsl.make_world("kinematic", registry))
    task = ntp_dsl.draw(ntp_dsl.load("seating"), "seating")
    baseline = checkpoints_folder() / "baseline" / "block_stacking.safetensors"
    with pytest.raises(ntp_dsl.NtpError, match="has not seen seat"):
        ntp_dsl.learned_policy(task, ntp_dsl.demonstrate(task), baseline)


def spin(world: Any, item: str) -> Any:
    return ACHIEVED


def marked(name: str) -> Any:
    return skill(name)(partial(spin))


def unmarked(world: Any, item: str) -> Any: ...


@pytest.mark.parametrize(
    "functions, sentence",
    [
        ([unmarked], "expected a function marked with @expert, .*; found <function unmarked"),
        ([3, None], "expected a function marked with @expert, .*; found 3"),
        ("abc", "expected a list of functions: .*; found 'abc'"),
        (marked("spin"), "expected a list of functions: .*; found functools.partial"),
        ([marked("spin"), marked("spin")], "two functions were given for the skill 'spin'"),
        ([marked("spin"), marked("hop")], "the skill 'hop' was given, and library 'spinning' leaves "
         "skill 'spin' to Python"),
    ],
)  # fmt: skip
def test_functions_that_a_library_does_not_ask_for_are_refused(functions: Any, sentence: str) -> None:
    with pytest.raises(ntp_dsl.NtpError, match=sentence):
        ntp_dsl.load_text(SPINNING, functions=functions)


def test_an_object_that_is_called_like_a_function_is_one() -> None:
    registry = ntp_dsl.load_text(SPINNING, functions=[marked("spin")])
    assert registry.python.get("skill", "spin")(None, "cube") is ACHIEVED


@pytest.mark.parametrize("given", [len, 3, partial(spin), skill("named")(spin).__call__])
def test_what_cannot_be_marked_is_told_in_a_sentence(given: Any) -> None:
    with pytest.raises(ntp_dsl.NtpError, match="@skill: expected a function"):
        skill(given)


@pytest.mark.parametrize("seed", [-1, 1.5, None, "3", True, 2**70])
def test_a_seed_is_a_whole_number(seed: Any) -> None:
    registry = ntp_dsl.load("block_stacking")
    with pytest.raises(ntp_dsl.NtpError, match="expected a seed, a whole number from 0"):
        ntp_dsl.draw(registry, "block_stacking", seed=seed)


def test_a_demonstration_of_other_objects_teaches_nothing() -> None:
    task, other = (ntp_dsl.draw(ntp_dsl.load(name), name) for name in ("block_stacking", "object_sorting"))
    with pytest.raises(ntp_dsl.NtpError, match="the demonstration (lacks|also shows) .*; the scene has"):
        ntp_dsl.learned_policy(task, ntp_dsl.demonstrate(other))


def test_a_trace_states_its_world_and_episode_as_the_command_does() -> None:
    registry = ntp_dsl.load("block_stacking")
    task = ntp_dsl.draw(registry, "few_placements", seed=3)
    header = ntp_dsl.run(task, ntp_dsl.expert_policy(task)).trace.header
    assert (header.world, header.episode) == ("kinematic", 0)
    own = ntp_dsl.run(task, ntp_dsl.expert_policy(task), ntp_dsl.make_world("kinematic", registry))
    assert own.trace.header.world is None  # nobody said which


class Deciding:
    """A policy that makes one decision."""

    def __init__(self, choice: Any, kind: str = "custom", scope: Any = None) -> None:
        self.choice, self.kind, self.scope = choice, kind, scope

    def root(self, program: str, arguments: Any) -> ntp_dsl.Frame:
        return ntp_dsl.Frame(program, arguments, self.scope)

    def decide(self, frame: Any, world: Any, barred: Any = frozenset()) -> Any:
        return self.choice


@pytest.mark.parametrize(
    "policy, sentence",
    [
        (Deciding(None, kind="wizard"), "expected a policy's kind to be one of scripted, .*found 'wizard'"),
        (Deciding(None), "expected a Choice from the policy's decide; found None"),
        (Deciding(None, scope=(9, 3)), r"the policy's root, begin first; found \(9, 3\)"),
        (Deciding(ntp_dsl.Choice(None, scope=(9, 3))), r"policy's decide, begin first; found \(9, 3\)"),
        (Deciding(ntp_dsl.Choice(None, scope="ab")), "policy's decide gave a scope that no trace may have"),
        (Deciding(ntp_dsl.Choice(None, decision=Decision(probability=2))), "gave a decision that .*<= 1.0"),
    ],
)  # fmt: skip
def test_a_wrong_decision_is_refused_when_it_is_made(policy: Any, sentence: str) -> None:
    task = ntp_dsl.draw(ntp_dsl.load("block_stacking"), "few_placements")
    with pytest.raises(ntp_dsl.NtpError, match=sentence):
        ntp_dsl.run(task, policy)


def test_public_functions_can_be_sent_to_other_processes() -> None:
    assert pickle.loads(pickle.dumps(ntp_dsl.draw)) is ntp_dsl.draw


def test_a_task_without_a_goal_has_none_to_compare_with() -> None:
    task = ntp_dsl.draw(ntp_dsl.load("block_stacking"), "few_placements", seed=1)
    shown = ntp_dsl.demonstrate(task).demonstration
    bare = replace(shown, origin=UNKNOWN)
    assert task.showing(shown).goal == task.goal and not task.showing(bare).goal
    with pytest.raises(ntp_dsl.NtpError, match="states a goal, and task"):
        task.showing(bare).showing(shown)


def test_a_run_without_a_goal_is_not_judged() -> None:
    task = ntp_dsl.draw(ntp_dsl.load("block_stacking"), "few_placements", seed=1)
    shown = ntp_dsl.demonstrate(task)
    bare = task.showing(replace(shown.demonstration, origin=UNKNOWN))
    episode = ntp_dsl.run(bare, ntp_dsl.learned_policy(bare, shown), "kinematic")
    assert episode.success is None and episode.run.done and "not judged" in repr(episode)


def test_scopes_are_compared_only_where_both_traces_have_some() -> None:
    task = ntp_dsl.draw(ntp_dsl.load("block_stacking"), "few_placements", seed=2)
    shown = ntp_dsl.demonstrate(task)
    scoped = ntp_dsl.run(task, ntp_dsl.expert_policy(task, shown)).trace
    bare = ntp_dsl.run(task, ntp_dsl.expert_policy(task)).trace
    assert any(call.scope for call in scoped.calls) and not any(call.scope for call in bare.calls)
    assert ntp_dsl.compare(scoped, bare).first is None
