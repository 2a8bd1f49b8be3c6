"""What a demonstration says, as text that can be edited and run: `ntp read` and `ntp run --goal`."""

from __future__ import annotations

import json
import re
from pathlib import Path
from shutil import copytree

import numpy as np
import pytest

from ntp_dsl.api import demonstrate, draw
from ntp_dsl.cli.app import run
from ntp_dsl.common.resources import checkpoints_folder
from ntp_dsl.demonstrations.demonstration import Recorder
from ntp_dsl.demonstrations.demonstration_files import read_demonstration, write_demonstration
from ntp_dsl.language.loader import load
from ntp_dsl.semantics.observation import Record
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.trace import Trace
from ntp_dsl.worlds.catalogue import make_world

FEW = ["block_stacking", "few_placements"]
KINEMATIC = ["--world", "kinematic"]
TRACE = "episode_00000.trace.jsonl"
BASELINE = checkpoints_folder() / "baseline" / "block_stacking.safetensors"
DOMAINS = Path(__file__).parents[1] / "evaluation" / "domains"
DOUBTFUL = [str(DOMAINS / "lanterns"), "in_doubt"]


def placements(trace: Trace) -> list[tuple[object, ...]]:
    return [each.arguments for each in trace.calls if each.name == "pick_and_place" and each.succeeded]


def test_a_goal_that_somebody_wrote_gets_built(tmp_path: Path) -> None:
    """It is none that was drawn: a tower of three, and one of two."""
    goal = tmp_path / "goal.txt"
    goal.write_text("# two towers\ngoal: (block_5, block_1), (block_0, block_5),\n  (block_2, block_7)\n")
    out = tmp_path / "out"
    assert run(["run", *FEW, *KINEMATIC, "--goal", str(goal), "--out", str(out)]) == 0
    trace = read_trace(out / TRACE)
    assert trace.end is not None and trace.end.success
    assert placements(trace) == [("block_5", "block_1"), ("block_0", "block_5"), ("block_2", "block_7")]
    assert trace.header.demonstration is None


@pytest.mark.parametrize("seed", [0, 3])
@pytest.mark.parametrize(
    "library, task",
    [("block_stacking", "block_stacking"), ("seating", "seating"), ("serving", "serving")],
)
def test_what_is_read_runs_as_what_is_shown(
    library: str, task: str, seed: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [library, task, "--seed", str(seed)]
    assert run(["read", *words]) == 0
    goal = tmp_path / "goal.txt"
    goal.write_text(capsys.readouterr().out)
    assert run(["run", *words, *KINEMATIC, "--goal", str(goal), "--out", str(tmp_path / "told")]) == 0
    assert run(["run", *words, *KINEMATIC, "--out", str(tmp_path / "shown")]) == 0
    told, shown = (read_trace(tmp_path / each / TRACE) for each in ("told", "shown"))
    assert calls(told) == calls(shown)
    assert told.header.goal == shown.header.goal


def calls(trace: Trace) -> list[tuple[object, ...]]:
    return [
        (each.name, tuple(value for value in each.arguments if not isinstance(value, tuple)), each.outcome)
        for each in trace.calls
    ]


def test_lists_of_objects_run_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = [str(DOMAINS / "kitchen_pass"), "kitchen_pass"]
    assert run(["read", *words]) == 0
    goal = tmp_path / "goal.txt"
    goal.write_text(capsys.readouterr().out)
    assert run(["run", *words, *KINEMATIC, "--goal", str(goal)]) == 0


def test_what_is_read_is_the_goal_that_was_drawn(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["read", *FEW, "--seed", "7", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    goal = draw(load("block_stacking"), FEW[1], 7).goal
    assert document["lists"] == {"goal": [dict(row.fields) for row in goal]}
    assert document["explained"] == document["acts"] == 2 * len(goal)


def test_what_is_read_begins_with_how_much_is_explained(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["read", *FEW, "--seed", "7"]) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith("# 6 of 6 acts of the hand explained, by stack\ngoal: (block_")
    assert "the expert demonstrates the task once, from seed 7" in captured.err


@pytest.fixture(scope="module")
def foreign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a demonstration in which two blocks are moved about on the table, and nothing else."""
    task = draw(load("block_stacking"), FEW[1], 1)
    world = make_world("kinematic", task.registry)
    world.reset(task.scene(), 0)
    recorder = Recorder(world)
    for name in ("block_0", "block_3"):
        for api, arguments in (
            ("move_to", (name,)),
            ("grasp", (name,)),
            ("move_to", ("table",)),
            ("release", ()),
        ):
            world.call(api, arguments)  # type: ignore[arg-type]
    path = tmp_path_factory.mktemp("foreign") / "foreign.demo.parquet"
    write_demonstration(recorder.demonstration(), path)
    return path


def test_acts_that_are_not_explained_are_an_exit_status(
    foreign: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["read", *FEW, "--seed", "1", "--demo", str(foreign)]) == 1
    first, *rows = capsys.readouterr().out.splitlines()
    explained, acts = int(first.split()[1]), int(first.split()[3])
    assert explained < acts == 4
    told = [row for row in rows if row.startswith("# not explained: the hand ")]
    assert len(told) == acts - explained and all(" at block_" in row for row in told)


def test_a_demonstration_file_is_read_alike_without_its_origin(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shown = demonstrate(draw(load("block_stacking"), FEW[1], 2))
    path = tmp_path / "shown.demo.parquet"
    write_demonstration(shown.demonstration, path)
    assert run(["read", *FEW, "--seed", "2", "--demo", str(path)]) == 0
    from_a_file = capsys.readouterr().out
    assert run(["read", *FEW, "--seed", "2"]) == 0
    assert capsys.readouterr().out == from_a_file


@pytest.mark.parametrize(
    "text, sentence",
    [
        (
            "goal: (block_0, block_9)",
            r":1: expected the name of an object .* 'block_8'|:1: expected the name",
        ),
        ("goal: (block_0)", r":1: expected ',', found '\)'"),
        ("towers: (block_0, block_1)", r":1: expected a list of 'stack' \(goal\)"),
        ("", r": expected 'goal: …', a list that 'stack' takes"),
    ],
)
def test_a_flawed_goal_is_misuse_and_one_sentence(
    text: str, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    goal = tmp_path / "goal.txt"
    goal.write_text(text)
    assert run(["run", *FEW, *KINEMATIC, "--goal", str(goal)]) == 2
    said = capsys.readouterr().err.strip()
    assert said.startswith(str(goal)) and "\n" not in said and "Traceback" not in said
    assert re.search(sentence, said)


def test_a_goal_and_a_demonstration_are_one_too_many(
    foreign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    goal = tmp_path / "goal.txt"
    goal.write_text("goal: (block_0, block_1)")
    assert run(["run", *FEW, *KINEMATIC, "--goal", str(goal), "--demo", str(foreign)]) == 2
    assert "choose one" in capsys.readouterr().err


def test_a_baseline_neither_reads_nor_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    goal = tmp_path / "goal.txt"
    goal.write_text("goal: (block_0, block_1)")
    assert run(["read", *FEW, "--model", str(BASELINE)]) == 2
    assert "leave out --model" in capsys.readouterr().err
    assert run(["run", *FEW, *KINEMATIC, "--goal", str(goal), "--model", str(BASELINE)]) == 2
    assert "needs a demonstration" in capsys.readouterr().err


def test_the_expert_builds_a_goal_that_is_told(tmp_path: Path) -> None:
    goal = tmp_path / "goal.txt"
    goal.write_text("goal: (block_3, block_4)")
    assert run(["run", *FEW, *KINEMATIC, "--expert", "--goal", str(goal)]) == 0


def test_a_demonstration_may_be_noisy(tmp_path: Path) -> None:
    words = ["run", *FEW, *KINEMATIC, "--seed", "4", "--demo-noise", "0.003", "--out", str(tmp_path)]
    assert run(words) == 0
    shown = read_demonstration(tmp_path / "episode_00000.demo.parquet")
    assert shown.deviations is not None and np.allclose(shown.deviations, 0.003)


@pytest.mark.parametrize("value", ["-0.001", "nan", "inf"])
def test_noise_that_is_none_is_misuse(value: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["run", *FEW, *KINEMATIC, f"--demo-noise={value}"]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_a_person_may_demonstrate(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["read", *FEW, "--seed", "4"]) == 0
    text = capsys.readouterr().out
    assert run(["read", *FEW, "--seed", "4", "--demo-by", "false-starts", "--demo-rate", "100"]) == 0
    assert capsys.readouterr().out == text


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--demo-rate", "30"], "--demo-rate goes with --demo-by"),
        (["--demo-by", "nobody"], "is not one of 'steady'"),
        (["--demo-by", "anybody", "--demo-rate", "nan"], "nan"),
        (["--demo-by", "anybody", "--demo", "a.parquet"], "--demo is a demonstration"),
    ],
)
def test_a_person_that_cannot_demonstrate_is_misuse(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["read", *FEW, *words]) == 2
    assert message in capsys.readouterr().err


def test_what_a_demonstration_leaves_open_is_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["run", *DOUBTFUL, *KINEMATIC, "--seed", "3", "--ask-below", "0.9"]
    assert run(words) == 2  # nobody can be asked
    asked = capsys.readouterr().err
    assert asked.count("may be") == asked.count("--answer N") > 0
    assert run([*words, "--out", str(tmp_path / "asked")]) == 2
    assert len([*(tmp_path / "asked").glob("question_*.svg")]) == asked.count("may be")
    answers = ["--answer", "2"] * asked.count("may be")
    assert run([*words, *answers, "--out", str(tmp_path)]) == 0
    read = next(call.decision.read for call in read_trace(tmp_path / TRACE).calls if call.decision.read)
    assert [each.answer for each in read.doubts] == [each.others[0].element for each in read.doubts]
    assert [*read.lists[0].elements] == [each.answer for each in read.doubts]


def test_an_answer_is_heeded_by_the_programs_that_a_list_is_passed_on_to(tmp_path: Path) -> None:
    folder = tmp_path / "lanterns"
    copytree(DOMAINS / "lanterns", folder)
    text = (folder / "lanterns.ntp").read_text().replace("run:     light_all", "run:     outer")
    wrapper = """program outer(bays: list[Bay]):
    achieves all lights(b.lantern, b.one, b.other) for b in bays
    light_all(bays)

"""
    (folder / "lanterns.ntp").write_text(text.replace("program light_all", f"{wrapper}program light_all"))
    out = tmp_path / "out"
    words = ["run", str(folder), "in_doubt", *KINEMATIC, "--seed", "3", "--ask-below", "0.9"]
    assert run([*words, "--answer", "2", "--answer", "2", "--out", str(out)]) == 0
    calls = read_trace(out / TRACE).calls
    read = next(call.decision.read for call in calls if call.decision.read)
    answers = [each.answer.fields for each in read.doubts if isinstance(each.answer, Record)]
    lit = [call.arguments for call in calls if call.name == "light"]
    assert lit == [tuple(value for _, value in each) for each in answers] and len(lit) == 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--ask-below", "0.9", "--answer", "3", "--answer", "1"], "expected an answer from 1 to 2"),
        (["--answer", "1"], "--answer goes with --ask-below"),
        (["--ask-below", "2"], "--ask-below"),
        (["--ask-below", "0.9", "--expert"], "leaves open"),
        (["--ask-calls-below", "0.9"], "goes with --ask-below"),
        (["--ask-below", "0.9", "--ask-calls-below", "0.9", "--dispatch", "rule"], "weighs no alternatives"),
    ],
)
def test_answers_that_do_not_fit_are_misuse(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["run", *DOUBTFUL, *KINEMATIC, "--seed", "3", *words]) == 2
    assert message in capsys.readouterr().err


def test_answers_that_nothing_was_asked_for_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["run", *DOUBTFUL, *KINEMATIC, "--seed", "3", "--ask-below", "0.9", *["--answer", "1"] * 9]
    assert run(words) == 0
    assert "7 answers were not used" in capsys.readouterr().err


def test_nothing_is_asked_where_nothing_is_open(tmp_path: Path) -> None:
    assert run(["run", *FEW, *KINEMATIC, "--ask-below", "0.95"]) == 0


def test_a_demonstration_of_other_objects_is_refused_before_it_is_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["run", "seating", "seating", *KINEMATIC, "--out", str(tmp_path)]) == 0
    capsys.readouterr()
    shown = tmp_path / "episode_00000.demo.parquet"
    for more in ([], ["--ask-below", "0.9"]):
        assert run(["run", *FEW, *KINEMATIC, "--demo", str(shown), *more]) == 2
        error = capsys.readouterr().err
        assert error.startswith("the demonstration lacks block_0") and "acts of the hand" not in error
