"""Every decision of many traces is counted at its line."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from shutil import copy, copytree

import pytest

from ntp_dsl.cli.app import run
from ntp_dsl.common.resources import examples_folder
from ntp_dsl.language.registry import Registry
from ntp_dsl.traces.coverage import Coverage
from ntp_dsl.traces.failure_attribution import attribute_all
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import ROOT, Call, CallKind, CallOutcome
from ntp_dsl.traces.trace import Trace

EVAL = "eval block_stacking few_placements --episodes 4 --slips .6 --seed 3".split()


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Record learned and scripted episodes of the same seeds, with slips."""
    path = tmp_path_factory.mktemp("covered")
    assert run([*EVAL, "--out", str(path / "learned"), "--json"]) == 0
    assert run([*EVAL, "--expert", "--out", str(path / "scripted"), "--json"]) == 0
    return path / "learned", path / "scripted"


def lines(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, dict[str, object]]:
    capsys.readouterr()
    assert run(["trace", "coverage", "block_stacking", *words, "--json"]) == 0
    found: dict[str, dict[str, object]] = json.loads(capsys.readouterr().out)["lines"]
    return found


def test_every_call_and_return_is_counted_once(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str], stacking: Registry
) -> None:
    traces = [read_trace(file) for file in sorted(folders[1].glob("*.jsonl"))]
    figures = lines(capsys, str(folders[1]))
    calls = [call for trace in traces for call in trace.calls]
    of_statements = [call for call in calls if call.parent != ROOT]
    returned = [call for call in calls if call.is_program and call.outcome in ("done", "unfinished")]
    assert sum(int(str(row["calls"])) for row in figures.values()) == len(of_statements) + len(returned)
    picked = next(each.span for each in stacking.programs["place"].statements())
    place = figures[f"tabletop.ntp:{picked.line}"]
    below = [c for t in traces for c in t.calls if c.name == "move_to" and _caller(t, c) == "place"]
    assert (place["calls"], place["succeeded"]) == (len(below), sum(call.succeeded for call in below))
    slipped = len(below) - sum(call.succeeded for call in below)
    assert place["attributed_to"] == {"disturbance": slipped} and slipped > 0
    assert place["probability"] is None


def _caller(trace: Trace, call: Call) -> str:
    return "" if call.parent == ROOT else trace.calls[call.parent].name


def test_a_learned_programs_lines_come_with_their_mean_probability(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    figures = lines(capsys, str(folders[0]))
    assert all(0.5 < float(str(row["probability"])) <= 1 for row in figures.values())


def test_divergences_are_counted_at_the_line_that_the_expert_followed(
    folders: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (folders[1] / "episode_00000.trace.jsonl").read_text()
    for name in ("episode_00000.trace.jsonl", "episode_00001.trace.jsonl"):
        (tmp_path / name).write_text(text.replace('"name":"grasp"', '"name":"grab"'))
        (tmp_path / "right").mkdir(exist_ok=True)
        (tmp_path / "right" / name).write_text(text)
    figures = lines(capsys, str(tmp_path), "--against", str(tmp_path / "right"))
    counted: Counter[str] = Counter()
    for row in figures.values():
        counted.update(row["divergences"])  # type: ignore[arg-type]
    assert counted == {"program": 2}


def test_the_source_is_shown_beside_its_counts(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert run(["trace", "coverage", "block_stacking", *map(str, sorted(folders[0].glob("*.jsonl")))]) == 0
    output = capsys.readouterr().out
    assert "block_stacking.ntp\n" in output and "tabletop.ntp\n" in output and "4 traces" in output
    (row,) = [line for line in output.splitlines() if line.endswith("  pick_and_place(p.item, p.support)")]
    assert "100%" in row
    (never,) = [line for line in output.splitlines() if line.endswith(" program put_down():")]
    assert "never" in never or "%" in never


def test_the_users_own_library_comes_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    text = (examples_folder() / "block_stacking" / "block_stacking.ntp").read_text(encoding="utf-8")
    Path("zoo.ntp").write_text(text.replace("library block_stacking", "library zoo"), encoding="utf-8")
    assert run(["eval", "zoo.ntp", "few_placements", "--expert", "-n", "1", "--out", "runs"]) == 0
    capsys.readouterr()
    assert run(["trace", "coverage", "zoo.ntp", "runs"]) == 0
    shown = capsys.readouterr().out
    assert 0 < shown.index("zoo.ntp\n") < shown.index("tabletop.ntp\n")


@pytest.mark.parametrize(
    "words, message",
    [
        (["nowhere", "x"], "nowhere"),
        (["block_stacking", "none.jsonl"], "none.jsonl: cannot be read"),
        (["block_stacking", "."], "contains no traces"),
    ],
)
def test_misuse_is_one_sentence(
    words: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["trace", "coverage", *words]) == 2
    assert message in capsys.readouterr().err


def test_an_unfinished_program_has_the_attribution_of_the_failure_below() -> None:
    calls = [
        Call(0, ROOT, CallKind.PROGRAM, "build", (), None, 0, 0, outcome=CallOutcome("unfinished")),
        Call(1, 0, CallKind.API, "grasp", (), None, 0, 0, outcome=CallOutcome("grasp failed")),
        Call(2, 0, CallKind.API, "move", (), None, 0, 0, outcome=CallOutcome("no path")),
        Call(3, ROOT, CallKind.PROGRAM, "build", (), None, 0, 0, outcome=CallOutcome("unfinished")),
        Call(4, ROOT, CallKind.PROGRAM, "build", (), None, 0, 0, outcome=CallOutcome("done")),
    ]
    assert attribute_all(calls) == ["planner", "grasp", "planner", "decision", None]
    assert Coverage().lines == {}


def test_a_trace_that_was_killed_before_its_first_line_is_named_and_skipped(
    folders: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = next(folders[1].glob("*.trace.jsonl"))
    (tmp_path / "episode_00000.trace.jsonl").write_bytes(whole.read_bytes())
    (tmp_path / "episode_00001.trace.jsonl").write_text('{"event":')
    capsys.readouterr()
    assert run(["trace", "coverage", "block_stacking", str(tmp_path)]) == 0
    told = capsys.readouterr()
    assert "skipped" in told.err and "episode_00001.trace.jsonl" in told.err and "1 trace" in told.out
    (tmp_path / "episode_00000.trace.jsonl").unlink()
    assert run(["trace", "coverage", "block_stacking", str(tmp_path)]) == 2
    assert "found none; run the episodes again" in capsys.readouterr().err


def test_a_line_says_first_what_there_is_to_see(
    folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    traces = [read_trace(file) for file in sorted(folders[0].glob("*.jsonl"))]
    assert run(["trace", "coverage", "block_stacking", str(folders[0])]) == 0
    first = capsys.readouterr().out.splitlines()[0]
    succeeded = sum(bool(trace.end and trace.end.success) for trace in traces)
    assert (
        first.startswith(f"4 traces: {succeeded} succeeded; ")
        and "most failed calls at tabletop.ntp:" in first
    )


def test_traces_without_a_counterpart_are_named_and_counted(
    folders: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy(folders[1] / "episode_00000.trace.jsonl", tmp_path)
    words = ["trace", "coverage", "block_stacking", str(folders[0]), "--against", str(tmp_path)]
    assert run(words) == 0
    shown = capsys.readouterr()
    assert shown.err.count("is not compared") == 3 and shown.out.startswith("4 traces")


def test_lines_are_shown_as_the_traces_have_them(
    folders: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    library = tmp_path / "block_stacking"
    copytree(examples_folder() / "block_stacking", library)
    file = library / "block_stacking.ntp"
    file.write_text("# edited since\n" + file.read_text())
    assert run(["trace", "coverage", str(library), str(folders[0])]) == 0
    shown = capsys.readouterr()
    assert "block_stacking.ntp has changed since" in shown.err and "edited since" not in shown.out


TWICE = """library twice
use tabletop

program bring(item: Movable, support: Place):
    requires present(item) and reachable(item) and present(support) and reachable(support)
    achieves on(item, support)
    when not clear(support):
        pick_and_place(item, support)
    when clear(support):
        pick_and_place(item, support)

program build(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        bring(p.item, p.support)

task twice:
    scene:   blocks: 6 Block on table
    goal:    towers(blocks, placements=2..2, height=3)
    run:     build(goal)
    success: all on(p.item, p.support) for p in goal
"""


def test_of_two_statements_that_are_alike_the_one_that_was_due_is_counted(tmp_path: Path) -> None:
    library = tmp_path / "twice.ntp"
    library.write_text(TWICE, encoding="utf-8")
    assert run(["eval", str(library), "twice", "-n", "2", "--out", str(tmp_path), "--json"]) == 0
    for number in range(2):
        calls = read_trace(tmp_path / f"episode_{number:05}.trace.jsonl").calls
        made = [call.decision.source for call in calls if call.name == "pick_and_place"]
        assert made and set(made) == {"twice.ntp:10"}  # all supports are clear
