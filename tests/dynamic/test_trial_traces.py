"""A check can be looked at: its notes show the state, and `--out` keeps the traces of failed trials."""

from __future__ import annotations

import json
from pathlib import Path
from re import search

import pytest
from checked_libraries import ALL_ON, BRINGING, PLACING, STACKING, diagnostics, written
from test_dynamic_check import FOUND

from ntp_dsl.cli.app import run
from ntp_dsl.dynamic.check import check_dynamically
from ntp_dsl.dynamic.trial_traces import TrialTraces
from ntp_dsl.language.loader import load
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import Ending

FORGETFUL = FOUND["E603 an expert that forgets half of the goal"][0]
CROWDED = FOUND["E605 two objects that push each other off one pad"][0]
ONLY_CLEAR = (
    BRINGING
    + """    clear(support)
    when clear(item):
        pick(item)
    place(item, support)
"""
    + STACKING.format(run="fill(goal)", success=ALL_ON)
)


def check(capsys: pytest.CaptureFixture[str], *words: str | Path) -> tuple[int, str, str]:
    status = run(["check", *map(str, words)])
    return status, *capsys.readouterr()


def test_a_deadlock_shows_its_state_and_what_each_statement_lacked(tmp_path: Path) -> None:
    (stuck,) = diagnostics(written(tmp_path, ONLY_CLEAR))
    item = search(r"bring\((block_\d)", stuck.message)
    assert stuck.code == "E605" and item is not None
    state, *statements = [note.message for note in stuck.notes]
    assert search(rf"block_\d on {item[1]}\b.*; block_\d in the hand$", state)
    held, guarded, lacking = statements
    assert search(r"^skipped: what it achieves already holds: clear\(block_\d\)$", held)
    assert search(r"^skipped: its condition does not hold: \w+\(.*\) (holds|does not hold)$", guarded)
    assert lacking.endswith(f" lacks holding({item[1]}), and no earlier statement is due that provides it")


def test_a_goal_that_is_not_reached_shows_the_state_and_what_success_lacks(tmp_path: Path) -> None:
    (failed,) = diagnostics(written(tmp_path, FORGETFUL))
    _, ended, state, contract = [note.message for note in failed.notes]
    assert ended.startswith("it ended (done), and on(block_")
    assert state.count(" at (") == 4 and state.endswith("; nothing in the hand")
    assert contract == "fill(...) has achieved its contract, and success asks for more"


def test_the_notes_on_a_large_task_stay_short(tmp_path: Path) -> None:
    many = FORGETFUL.replace("5 Block on table", "20 Block on table with cube(3 cm)")
    many = many.replace("placements=1..2", "placements=9")
    (failed,) = diagnostics(written(tmp_path, many))
    assert max(len(note.message) for note in failed.notes) < 400
    assert [" more" in note.message for note in failed.notes[:3]] == [True, True, True]


def test_the_traces_of_failed_trials_can_be_shown_explained_and_viewed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = written(tmp_path, FORGETFUL), tmp_path / "out"
    status, text, told = check(capsys, path, "--out", out)
    traces = sorted(out.iterdir())
    assert (status, len(traces)) == (1, 32)
    assert traces[0].name == "mine.tower_00000.trace.jsonl" and f"its trace: {traces[0]}" in text
    assert told == f"32 traces of failed trials in {out}; to look at the first: ntp trace show {traces[0]}\n"
    for command in (["show"], ["explain"], ["view", "--out", str(tmp_path / "a.html")]):
        assert run(["trace", command[0], str(traces[-1]), *command[1:]]) == 0
    end = read_trace(traces[0]).end
    assert end is not None and end.success is False and end.verdict.startswith("on(block_")


def test_the_trace_of_a_livelock_ends_in_the_state_that_recurs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    check(capsys, written(tmp_path, CROWDED), "--out", tmp_path / "out")
    (file,) = (tmp_path / "out").iterdir()
    trace = read_trace(file)
    assert trace.end is not None and (trace.end.ending, trace.end.success) == (Ending.CIRCULAR, False)
    assert trace.end.primitives == sum(not call.is_program for call in trace.calls) > 10
    assert trace.header.task == "crowded" and trace.motions and "tabletop.ntp" in trace.header.sources


def test_a_sound_library_leaves_no_trace_and_a_program_that_fails_does(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    sound = written(tmp_path, PLACING + STACKING.format(run="fill(goal)", success=ALL_ON))
    told = check(capsys, sound, "--out", out)[2]
    assert told == f"no trial failed: no trace was written to {out}\n"
    path = written(
        tmp_path,
        "program vanish(item: Movable):\n    requires present(item) and reachable(item)\n"
        "    achieves not present(item)\n    pick(item)\n",
    )
    assert check(capsys, path, "--out", out)[0] == 0  # a warning
    assert sorted(file.name for file in out.iterdir()) == [
        f"mine.vanish_{number:05d}.trace.jsonl" for number in range(6)
    ]


def test_earlier_traces_are_replaced_and_other_files_never(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = written(tmp_path, CROWDED), tmp_path / "out"
    out.mkdir()
    mine = out / "mine.crowded_00000.trace.jsonl"
    mine.write_text("my notes\n")
    status, _, told = check(capsys, path, "--out", out)
    assert status == 2 and f"{mine} is no trace of 'mine'" in told and mine.read_text() == "my notes\n"
    mine.unlink()
    (out / "notes.txt").write_text("kept")
    for _ in range(2):
        assert check(capsys, path, "--out", out)[0] == 1
    assert sorted(file.name for file in out.iterdir()) == [mine.name, "notes.txt"]


def test_another_seed_draws_other_trials_and_the_default_is_zero(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, FORGETFUL)
    texts = [check(capsys, path, *words)[1] for words in ([], ["--seed", "0"], ["--seed", "7"])]
    assert texts[0] == texts[1] != texts[2]
    assert all("E603" in text for text in texts)


def test_documents_for_machines_have_the_state_and_the_trace(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = written(tmp_path, FORGETFUL), tmp_path / "out"
    log = json.loads(check(capsys, path, "--out", out, "--format", "sarif")[1])
    (text,) = [each["message"]["text"] for each in log["runs"][0]["results"] if each["ruleId"] == "E603"]
    assert "at that moment: block_" in text and "its trace: " in text
    document = json.loads(check(capsys, path, "--out", out, "--format", "json")[1])
    (error,) = [each for each in document["diagnostics"] if each["code"] == "E603"]
    assert any(note["message"].startswith("its trace: ") for note in error["notes"])
    assert check(capsys, path, "--static", "--out", out)[0] == 2


def test_a_check_with_traces_finds_what_one_without_finds(tmp_path: Path) -> None:
    path = written(tmp_path, CROWDED)
    traced = check_dynamically(load(path), path, traces=TrialTraces(tmp_path / "out"))
    assert [each.message for each in traced] == [each.message for each in diagnostics(path)]


LETTING_GO = """library mine

use tabletop

api drop(item: Movable) by python
    requires holding(item)
    achieves empty(gripper)

program lift(item: Movable):
    requires present(item) and reachable(item)
    achieves holding(item)
    pick(item)
"""
FORGETFUL_SKILL = """from ntp_dsl.authoring import ACHIEVED, skill


@skill
def drop(world, item):
    return ACHIEVED
"""


def test_a_call_that_breaks_its_contract_leaves_a_trace_that_tells_what_it_lacked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = tmp_path / "mine.ntp", tmp_path / "out"
    path.write_text(LETTING_GO)
    path.with_suffix(".py").write_text(FORGETFUL_SKILL)
    status, text, _ = check(capsys, "--execute", path, "--out", out)
    traces = sorted(out.iterdir())
    assert status == 1 and "E601" in text and f"its trace: {traces[0]}" in text
    assert [file.name for file in traces] == [f"mine.drop_{n:05d}.trace.jsonl" for n in range(3)]
    (call,) = read_trace(traces[0]).calls
    assert (call.name, len(call.execution.unmet)) == ("drop", 1)
    assert run(["trace", "explain", str(traces[0])]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "drop reported success 1 time, and what it is to achieve did not hold" in told
    assert "was tried by itself" in told
