"""The call tree in the terminal, of whole traces and of those that were cut off."""

from __future__ import annotations

from pathlib import Path

import pytest

from ntp_dsl.cli.app import run
from ntp_dsl.cli.trace_show import BAR, scope_bar, shown
from ntp_dsl.traces import ROOT, Call, TraceWriter
from ntp_dsl.world import Observation, Record, Thing

SEEN = Observation((Thing("a", "Block", (0.05, 0.05, 0.05)),), {"a": (0.5, 0, 0.025)}, (0, 0, 1), False)
GOAL = tuple(Record("Placement", (("item", "a"), ("support", str(n)))) for n in range(5))


@pytest.fixture
def trace(tmp_path: Path) -> Path:
    path = tmp_path / "a.trace.jsonl"
    with path.open("w", encoding="utf-8") as stream:
        writer = TraceWriter(stream)
        thing = {"name": "a", "type": "Block", "size": (0.05, 0.05, 0.05)}
        writer.header(library="sample", task="t", policy="learned", seed=3, things=[thing])
        state = writer.state(SEEN)
        root = writer.call(ROOT, "program", "build", (GOAL,), (0, 100), 0, state, {})
        pick = writer.call(root, "program", "pick", ("a",), (0, 50), 0, state, {"probability": 0.97})
        grasp = writer.call(pick, "api", "grasp", ("a",), (25, 50), 3, state, {"probability": 0.5})
        writer.returned(grasp, "achieved", 9)
        writer.returned(pick, "done", 9)
        move = writer.call(root, "api", "move", ("a",), None, 9, state, {})
        writer.returned(move, "object dropped", 20, disturbances=["slip a"])
        writer.returned(root, "unfinished", 20)
        writer.end(done=False, reason="nothing helps", primitives=2)
    return path


def lines(capsys: pytest.CaptureFixture[str], *words: str) -> list[str]:
    assert run(["trace", "show", *words]) == 0
    return capsys.readouterr().out.splitlines()


def test_a_call_shows_its_arguments_scope_outcome_and_certainty(
    capsys: pytest.CaptureFixture[str], trace: Path
) -> None:
    head, root, pick, grasp, move, end = lines(capsys, str(trace))
    assert head == "library sample, task t, policy learned, seed 3"
    assert "build([(a, 0), (a, 1), (a, 2), ... 2 more])  ████████████  unfinished" in root
    assert "pick(a)  ██████──────  done  p=0.97" in pick
    assert "grasp(a)  ───███──────  achieved  p=0.50" in grasp
    assert "move(a)  ············  object dropped  [slip a]" in move
    assert end == "nothing helps (2 primitives)"


def test_depth_says_how_much_it_leaves_out(
    capsys: pytest.CaptureFixture[str], trace: Path
) -> None:
    assert "... 2 calls" in lines(capsys, str(trace), "--depth", "1")[2]
    assert "... 1 call" in lines(capsys, str(trace), "--depth", "2")[3]


def test_failed_shows_what_failed_and_who_called_it(
    capsys: pytest.CaptureFixture[str], trace: Path
) -> None:
    shown_lines = lines(capsys, str(trace), "--failed")
    assert len(shown_lines) == 4 and "move(a)" in shown_lines[2]


def test_a_trace_that_was_cut_off_is_shown_as_far_as_it_goes(
    capsys: pytest.CaptureFixture[str], trace: Path
) -> None:
    whole = trace.read_bytes()
    trace.write_bytes(whole[: whole.index(b'"return"') + 20])
    *_, grasp, end = lines(capsys, str(trace))
    assert "grasp(a)" in grasp and "cut off" in grasp
    assert end == "cut off: the trace ends here"


def test_a_trace_that_is_none_is_told_so(capsys: pytest.CaptureFixture[str], trace: Path) -> None:
    trace.write_text("library a\n")
    assert run(["trace", "show", str(trace)]) == 2
    assert "expected a line of JSON" in capsys.readouterr().err


@pytest.mark.parametrize("begin", range(0, 90, 7))
@pytest.mark.parametrize("length", [0, 1, 30, 200])
def test_a_scope_is_always_seen(begin: int, length: int) -> None:
    call = Call(0, ROOT, "api", "go", (), (begin, begin + length), 0, 0)
    bar = scope_bar(call, 90)
    assert len(bar) == BAR and "█" in bar


def test_markup_in_names_is_text() -> None:
    assert shown(("[red]",)) == "[[red]]"  # type: ignore[arg-type]
