"""What a run goes round in is named: the call that never succeeds, or the one that undoes another."""

from __future__ import annotations

from pathlib import Path
from re import search
from shutil import copytree

import pytest

from ntp_dsl.cli.app import run
from ntp_dsl.common.resources import examples_folder
from ntp_dsl.traces.circles import circle
from ntp_dsl.traces.reader import read_trace

DOMAINS = Path(__file__).parents[1] / "evaluation" / "domains"


def planted(folder: Path, library: Path, file: str, old: str, new: str) -> Path:
    """Copy a library, with a fault in one of its files."""
    path = folder / library.name
    copytree(library, path)
    text = (path / file).read_text(encoding="utf-8")
    assert text.count(old) == 1
    (path / file).write_text(text.replace(old, new), encoding="utf-8")
    return path


@pytest.fixture
def unprotected(tmp_path: Path) -> Path:
    """Plants are swapped, and what puts one up does not ask for a free stand."""
    old = "requires clear(s) and present(p)"
    return planted(tmp_path, DOMAINS / "trading", "trading.ntp", old, "requires present(p)")


@pytest.fixture
def one_sided(tmp_path: Path) -> Path:
    """Of three sides, two are provided for."""
    library = examples_folder() / "set_the_table"
    return planted(tmp_path, library, "set_the_table.ntp", "when side != ahead", "when side == left")


@pytest.fixture
def misjudged(tmp_path: Path) -> Path:
    """In a predicate in Python the height of another object is taken."""
    old = "by_name[tray].size[2] / 2\n    return"
    return planted(tmp_path, DOMAINS / "kitting", "kitting.py", old, "by_name[part].size[2] / 2\n    return")


@pytest.fixture
def without_a_condition(tmp_path: Path) -> Path:
    """Vases, which are fragile, are provided for by none of two conditions."""
    old, new = "when handling(p) == fragile:", "when handling(p) == heavy:"
    return planted(tmp_path, DOMAINS / "depot", "depot.ntp", old, new)


@pytest.fixture
def left_in_the_boot(tmp_path: Path) -> Path:
    """Nothing takes out the wheel that is to be put on."""
    old = "    when stowed(spare):\n        take_out(spare, c)\n"
    return planted(tmp_path, DOMAINS / "puncture", "puncture.ntp", old, "")


def checked(library: Path, capsys: pytest.CaptureFixture[str]) -> str:
    capsys.readouterr()
    assert run(["check", "--execute", str(library)]) == 1
    return " ".join(capsys.readouterr().out.split())


def explained(library: Path, task: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> tuple[Path, str]:
    """Return the trace of an episode, and what is said of it."""
    run(["eval", str(library), task, "-n", "1", "--out", str(folder)])
    capsys.readouterr()
    trace = folder / "episode_00000.trace.jsonl"
    assert run(["trace", "explain", str(trace)]) == 0
    return trace, " ".join(capsys.readouterr().out.split())


def test_the_statement_that_goes_without_what_it_requires_is_named(
    left_in_the_boot: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = checked(left_in_the_boot, capsys)
    assert "put_on(spare, car) is needed, and lacks at_hand(spare)" in told
    assert "write a statement before 'put_on' that provides at_hand(spare)" in told
    _, told = explained(left_in_the_boot, "puncture", tmp_path / "runs", capsys)
    assert "put_on(spare, car), is needed and lacks at_hand(spare)" in told


def test_of_calls_that_undo_one_another_both_are_named(
    unprotected: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = checked(unprotected, capsys)
    assert "achieves clear(stand_" in told and "ends that again" in told
    assert "let 'put_up' require that, so that 'free' is due only until then" in told
    file, told = explained(unprotected, "swapping", tmp_path / "runs", capsys)
    assert "went round" in told and "ends that again" in told
    found = circle(read_trace(file))
    assert found is not None and {call.name for call in found.calls} == {"free", "put_up"}
    assert found.rounds > 10 and not found.failing


def test_the_statements_that_were_skipped_are_told_with_a_call_that_never_succeeds(
    one_sided: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = checked(one_sided, capsys)
    assert "when side == left: | ------------------ skipped: its condition does not hold" in told
    assert "'bring' ends without what it achieves" in told
    file, told = explained(one_sided, "set_the_table", tmp_path / "runs", capsys)
    found = circle(read_trace(file))
    assert found is not None and [call.name for call in found.failing] == ["bring"]
    assert "When it made its last call, release(): Left out, as its condition does not hold" in told


def test_a_predicate_in_python_is_named_where_a_call_never_succeeds(
    misjudged: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "fitted is told by a function in Python" in checked(misjudged, capsys)
    _, told = explained(misjudged, "kitting", tmp_path / "runs", capsys)
    assert "holds is told by a function in Python" in told


def test_a_run_that_succeeds_goes_round_in_nothing(tmp_path: Path) -> None:
    words = ["eval", "block_stacking", "few_placements", "-n", "1", "--slips", ".5", "--out", str(tmp_path)]
    assert run(words) == 0
    assert circle(read_trace(tmp_path / "episode_00000.trace.jsonl")) is None


def test_elements_that_a_loop_filters_out_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    old, new = "    for r in rules:", "    for r in rules if r.kind == bolt:"
    told = checked(planted(tmp_path, DOMAINS / "zoning", "zoning.ntp", old, new), capsys)
    assert search(r"others are left out, as kind of \(\w+, \w+\) is \w+, not bolt", told)


def test_a_call_that_would_do_nothing_is_opened_and_its_conditions_are_told(
    without_a_condition: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = checked(without_a_condition, capsys)
    assert "load(vase_0, dock_0) has not achieved" in told
    assert "its condition does not hold: handling(vase_0) is fragile, not heavy" in told
    _, told = explained(without_a_condition, "depot", tmp_path / "runs", capsys)
    assert "cushion is left out, as handling(vase_0) is fragile, not heavy;" in told
