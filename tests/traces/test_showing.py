"""The call tree in the terminal, of whole traces and of those that were cut off."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from trees import headed

from ntp_dsl.cli.app import run
from ntp_dsl.cli.calls import BAR, scope_bar
from ntp_dsl.cli.commands.trace.show import LINES
from ntp_dsl.semantics.observation import Observation, Record, SceneObject
from ntp_dsl.traces.decision import NO_DECISION, Decision
from ntp_dsl.traces.phrases import format_argument, printable
from ntp_dsl.traces.schema import MAX_DEPTH, ROOT, Call, End, Ending, Execution
from ntp_dsl.traces.writer import TraceWriter

SEEN = Observation((SceneObject("a", "Block", (0.05, 0.05, 0.05)),), {"a": (0.5, 0, 0.025)}, (0, 0, 1), False)
GOAL = tuple(Record("Placement", (("item", "a"), ("support", str(n)))) for n in range(5))


@pytest.fixture
def trace(tmp_path: Path) -> Path:
    path = tmp_path / "a.trace.jsonl"
    with path.open("w", encoding="utf-8") as stream:
        writer = TraceWriter(stream)
        writer.header(headed(library="sample", task="t", policy="learned", seed=3, objects=SEEN.objects))
        state = writer.state(SEEN)
        root = writer.call(ROOT, "program", "build", (GOAL,), (0, 100), 0, state, NO_DECISION)
        sure = Decision(probability=0.97, seconds=0.004)
        pick = writer.call(root, "program", "pick", ("a",), (0, 50), 0, state, sure)
        grasp = writer.call(pick, "api", "grasp", ("a",), (25, 50), 3, state, Decision(probability=0.5))
        writer.returned(grasp, "achieved", 9, execution=Execution(moving=1.5))
        writer.returned(pick, "done", 9, decision=Decision(seconds=0.005))
        move = writer.call(root, "api", "move", ("a",), None, 9, state, NO_DECISION)
        writer.returned(move, "object dropped", 20, execution=Execution(disturbances=("slip a",)))
        writer.returned(root, "unfinished", 20)
        writer.end(End(ending=Ending.UNFINISHED, reason="nothing helps", primitives=2))
    return path


def lines(capsys: pytest.CaptureFixture[str], *words: str) -> list[str]:
    assert run(["trace", "show", *words]) == 0
    return capsys.readouterr().out.splitlines()


def test_a_call_shows_its_arguments_scope_outcome_and_probability(
    capsys: pytest.CaptureFixture[str], trace: Path
) -> None:
    head, root, pick, grasp, move, end = lines(capsys, str(trace))
    assert head == "library sample, task t, policy learned, seed 3"
    assert "build([(a, 0), (a, 1), (a, 2), ... 2 more])  ████████████  unfinished" in root
    assert root.endswith("decide 9 ms move 1.5 s")
    assert "pick(a)  ██████──────  done  p=0.97  decide 9 ms move 1.5 s" in pick
    assert "grasp(a)  ───███──────  achieved  p=0.50" in grasp
    assert "move(a)  ············  object dropped  [slip a]" in move
    assert end == "unfinished: nothing helps (2 primitives)"


def test_depth_counts_the_calls_that_it_hides(capsys: pytest.CaptureFixture[str], trace: Path) -> None:
    assert "... 2 calls" in lines(capsys, str(trace), "--depth", "1")[2]
    assert "... 1 call" in lines(capsys, str(trace), "--depth", "2")[3]


def test_failed_shows_what_failed_and_who_called_it(capsys: pytest.CaptureFixture[str], trace: Path) -> None:
    shown_lines = lines(capsys, str(trace), "--failed")
    assert len(shown_lines) == 4 and "move(a)" in shown_lines[2]


def test_a_cut_off_trace_is_shown_to_its_end(capsys: pytest.CaptureFixture[str], trace: Path) -> None:
    whole = trace.read_bytes()
    trace.write_bytes(whole[: whole.index(b'"return"') + 20])
    *_, grasp, end = lines(capsys, str(trace))
    assert "grasp(a)" in grasp and "cut off" in grasp
    assert end == "cut off: the trace ends here"


def test_another_file_is_refused(capsys: pytest.CaptureFixture[str], trace: Path) -> None:
    trace.write_text("library a\n")
    assert run(["trace", "show", str(trace)]) == 2
    assert "expected a trace" in capsys.readouterr().err


def test_only_shows_one_callee_and_who_called_it(capsys: pytest.CaptureFixture[str], trace: Path) -> None:
    _, root, pick, grasp, _ = lines(capsys, str(trace), "--only", "grasp")
    assert "build(" in root and "pick(" in pick and "grasp(" in grasp
    assert run(["trace", "show", str(trace), "--only", "grsp"]) == 2
    assert "did you mean 'grasp'? (available: build, grasp, move, pick)" in capsys.readouterr().err


def test_json_has_the_same_content(capsys: pytest.CaptureFixture[str], trace: Path) -> None:
    document = json.loads("\n".join(lines(capsys, str(trace), "--json")))
    assert [row["name"] for row in document["calls"]] == ["build", "pick", "grasp", "move"]
    pick = document["calls"][1]
    assert pick["seconds"] == {"deciding": 0.009, "planning": 0.0, "moving": 1.5}
    assert (pick["probability"], pick["scope"]) == (0.97, [0, 50])
    assert (
        document["calls"][3]["attributed_to"] == "disturbance" and document["end"]["ending"] == "unfinished"
    )


def long(path: Path, count: int, deep: bool) -> Path:
    """Write a trace of many calls of which one fails."""
    with path.open("w", encoding="utf-8") as stream:
        writer = TraceWriter(stream)
        writer.header(headed())
        state = writer.state(Observation((), {}, (0, 0, 1), False))
        above = [writer.call(ROOT, "program", "build", (), None, 0, state, NO_DECISION)]
        for number in range(count):
            caller = above[-1]
            above.append(writer.call(caller, "program", f"part_{number}", (), None, 0, state, NO_DECISION))
            if not deep:
                writer.returned(above.pop(), "unfinished" if number == count - 3 else "done", 0)
        for number in reversed(above):
            writer.returned(number, "done", 0)
    return path


def test_a_long_trace_is_folded_around_what_failed(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = str(long(tmp_path / "long.jsonl", 5000, deep=False))
    shown_lines = lines(capsys, path)
    assert LINES <= len(shown_lines) <= LINES + 4
    assert any("part_4997()" in line for line in shown_lines)
    assert any("... 4841 calls" in line for line in shown_lines)
    assert len(lines(capsys, path, "--all")) == 5003


def test_a_deep_trace_is_shown_and_a_deeper_one_than_any_run_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = str(long(tmp_path / "deep.jsonl", MAX_DEPTH - 1, deep=True))
    assert len(lines(capsys, path, "--all")) == MAX_DEPTH + 2
    assert run(["trace", "show", str(long(tmp_path / "deeper.jsonl", 5000, deep=True))]) == 2
    assert f"more than {MAX_DEPTH} nested calls" in capsys.readouterr().err


def test_repeated_calls_are_one_line(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    with path.open("w", encoding="utf-8") as stream:
        writer = TraceWriter(stream)
        writer.header(headed())
        state = writer.state(Observation((), {}, (0, 0, 1), False))
        for _ in range(3):
            writer.returned(writer.call(ROOT, "program", "build", (), None, 0, state, NO_DECISION), "done", 0)
    assert "build()  ············  done  ×3" in lines(capsys, str(path))[1]


def test_names_cannot_command_the_terminal(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    with path.open("w", encoding="utf-8") as stream:
        writer = TraceWriter(stream)
        writer.header(headed(library="\x1b[2J"))
        state = writer.state(Observation((), {}, (0, 0, 1), False))
        call = writer.call(ROOT, "program", "\x1b]0;x\x07", ("a\nb",), None, 0, state, NO_DECISION)
        writer.returned(call, "done", 0, execution=Execution(disturbances=("\r",)))
        writer.end(End(ending=Ending.DONE, reason="\x1b[0m"))
    output = "\n".join(lines(capsys, str(path)))
    assert "\x1b" not in output and "\r" not in output and "\\x1b" in output
    assert printable("café") == "café"


@pytest.mark.parametrize("begin", range(0, 90, 7))
@pytest.mark.parametrize("length", [0, 1, 30, 200])
def test_a_scope_is_always_visible(begin: int, length: int) -> None:
    call = Call(0, ROOT, "api", "go", (), (begin, begin + length), 0, 0)
    bar = scope_bar(call, 90)
    assert len(bar) == BAR and "█" in bar


def test_markup_in_names_is_text() -> None:
    assert format_argument(("[red]",)) == "[[red]]"  # type: ignore[arg-type]


def test_of_a_folder_its_traces_are_listed(trace: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (trace.parent / "b.trace.jsonl").write_text("")
    assert run(["trace", "show", str(trace.parent)]) == 0
    listed = capsys.readouterr().out.splitlines()
    assert listed == ["a.trace.jsonl  4 calls  unfinished", "b.trace.jsonl  0 calls  unreadable"]
    assert run(["trace", "show", str(trace.parent), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[0] == {
        "file": "a.trace.jsonl",
        "calls": 4,
        "ending": "unfinished",
        "success": None,
        "attributed_to": "",
        "verdict": "",
    }


def test_a_page_or_an_export_is_not_written_over_its_trace(
    trace: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = trace.read_bytes()
    for command in ("view", "export"):
        assert run(["trace", command, str(trace), "--out", str(trace)]) == 2
        assert "would be overwritten; give another file" in capsys.readouterr().err
    assert trace.read_bytes() == before
