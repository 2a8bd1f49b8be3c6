"""A run is stopped before decisions, at breakpoints, and with outcomes that are forced on it."""

from __future__ import annotations

import io
import re
from pathlib import Path

import pytest

import ntp_dsl
from ntp_dsl.cli.app import run
from ntp_dsl.cli.live_runs.stepping import Breakpoint
from ntp_dsl.execution.supervision import OUTCOMES, CallPattern, Injection
from ntp_dsl.traces.failure_attribution import attribute_call
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import Attribution
from ntp_dsl.traces.trace import Trace

WORDS = "run block_stacking few_placements --world kinematic --seed 3".split()


@pytest.fixture
def typed(monkeypatch: pytest.MonkeyPatch) -> io.StringIO:
    """Return what is typed at the terminal."""
    lines = io.StringIO()
    monkeypatch.setattr("sys.stdin", lines)
    return lines


def stops(typed: io.StringIO, lines: str, capsys: pytest.CaptureFixture[str], *words: str) -> list[str]:
    """Run with lines typed, and return the decisions that it stopped before."""
    typed.write(lines)
    typed.seek(0)
    capsys.readouterr()
    assert run([*WORDS, *words]) == 0
    said = capsys.readouterr().err
    return re.findall(r"^(?:step> )?(\w+\(.*(?: calls | returns).*)$", said, re.MULTILINE)


def traced(folder: Path, *words: str) -> Trace:
    assert run([*WORDS, *words, "--out", str(folder)]) == 0
    return read_trace(folder / "episode_00000.trace.jsonl")


def test_every_decision_is_stopped_before_and_the_run_is_the_same(
    tmp_path: Path, typed: io.StringIO, capsys: pytest.CaptureFixture[str]
) -> None:
    plain = traced(tmp_path / "plain", "--expert")
    decisions = sum(1 + call.is_program for call in plain.calls) - len(plain.children(-1))
    found = stops(typed, "\n" * 200, capsys, "--expert", "--step", "--out", str(tmp_path / "stepped"))
    assert len(found) == decisions
    stepped = read_trace(tmp_path / "stepped" / "episode_00000.trace.jsonl")
    assert ntp_dsl.compare(plain, stepped).first is None


def test_over_goes_past_the_calls_below(typed: io.StringIO, capsys: pytest.CaptureFixture[str]) -> None:
    found = stops(typed, "\no\no\nc\n", capsys, "--step")
    assert [each.partition("(")[0] for each in found] == [
        "stack",
        "pick_and_place",
        "pick_and_place",
        "pick_and_place",
    ]
    assert [re.search(r" calls (\w+)|( returns)", each)[0] for each in found[1:]] == [
        " calls pick",
        " calls place",
        " returns",
    ]


def test_the_end_of_the_input_goes_on_to_the_end(
    typed: io.StringIO, capsys: pytest.CaptureFixture[str]
) -> None:
    assert len(stops(typed, "\n", capsys, "--step")) == 2


def test_at_the_end_of_the_input_breakpoints_do_not_stop(
    typed: io.StringIO, capsys: pytest.CaptureFixture[str]
) -> None:
    assert len(stops(typed, "c\n", capsys, "--break", "grasp", "--break", "grasp(table)")) == 2
    assert run([*WORDS, "--break", "grasp(table)"]) == 0
    assert "breakpoint grasp(table) was never met" in capsys.readouterr().err


def test_it_says_why_and_which_words_there_are(
    typed: io.StringIO, capsys: pytest.CaptureFixture[str]
) -> None:
    typed.write("what\nw\nc\n")
    typed.seek(0)
    assert run([*WORDS, "--step"]) == 0
    said = capsys.readouterr().err
    assert "Enter: to the next decision" in said and "It was seen that on(block_" in said


def test_quitting_is_an_interruption(typed: io.StringIO) -> None:
    typed.write("q\n")
    typed.seek(0)
    assert run([*WORDS, "--step"]) == 130


@pytest.mark.parametrize(
    ("where", "pattern"),
    [
        ("grasp", r" calls grasp\("),
        ("tabletop.ntp:75", r" calls grasp\(.*tabletop\.ntp:75"),
        ("75", r"tabletop\.ntp:75"),
        ("place", r" calls place\("),
    ],
)
def test_a_breakpoint_stops_at_calls_and_lines(
    where: str, pattern: str, typed: io.StringIO, capsys: pytest.CaptureFixture[str]
) -> None:
    found = stops(typed, "c\n" * 50, capsys, "--break", where, "--expert")
    assert len(found) == 3 and all(re.search(pattern, each) for each in found)


def test_a_breakpoint_stops_when_a_fact_comes_about(
    tmp_path: Path, typed: io.StringIO, capsys: pytest.CaptureFixture[str]
) -> None:
    placement = traced(tmp_path, "--expert").header.goal[0]
    item, support = (value for _, value in placement.fields)
    on = f"on({item}, {support})"
    assert len(stops(typed, "c\n" * 50, capsys, "--break", on, "--expert")) == 1
    typed.seek(0)
    typed.truncate()
    found = stops(typed, "c\n" * 50, capsys, "--break", f"not {on}", "--expert")
    assert len(found) == 1 and found[0].startswith("stack(")


@pytest.mark.parametrize(
    ("where", "said"),
    [
        ("gasp", "did you mean 'grasp'?"),
        ("holding", "a fact such as holding(block_3)"),
        ("hold(block_1)", "--break: expected a program"),
        ("not grasp", "--break: expected a program"),
        ("grasp(block_99)", "--break: 'block_99' in 'grasp(block_99)' is no object of the scene"),
        ("on(block_2)", "--break: 'on(block_2)': on takes (item, support), found 1 argument"),
        ("nofile.ntp:75", "--break: expected a program"),
        ("9999", "--break: expected a program"),
        ("grasp(block_3", "--break: expected a program"),
        ("grasp(block_3, block_1)", "grasp takes (target), found 2 arguments"),
    ],
)
def test_a_breakpoint_that_means_nothing_is_misuse(
    where: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*WORDS, "--break", where]) == 2
    assert said in capsys.readouterr().err


def test_an_outcome_is_forced_once_and_made_good(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first = next(call for call in traced(tmp_path / "plain").calls if call.name == "grasp")
    whole = f"grasp({first.arguments[0]})=object_dropped"
    trace = traced(tmp_path / "forced", "--inject", whole, "--inject", "release=no_path")
    forced = [call for call in trace.calls if call.execution.disturbances]
    assert [(call.name, str(call.outcome)) for call in forced] == [
        ("grasp", "object dropped"),
        ("release", "no path"),
    ]
    assert {attribute_call(call) for call in forced} == {Attribution.DISTURBANCE}
    assert trace.end is not None and trace.end.success
    assert "nothing was forced" not in capsys.readouterr().err


def test_an_injection_that_fits_no_call_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*WORDS, "--inject", "grasp(table)=no_ik"]) == 0
    assert "no primitive was grasp(table): nothing was forced on it" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("grasp", "expected CALL=OUTCOME"),
        ("grasp=no_pth", "did you mean 'no_path'?"),
        ("gasp=no_path", "did you mean 'grasp'?"),
        ("grasp(block_3=no_path", "is no call of an api"),
        ("pick=no_path", "is no call of an api"),
        ("claer(block_3)=true", "did you mean 'clear'?"),
        ("clear(block_3, block_1)=true", "clear takes (item), found 2 arguments"),
        ("clear(blck_3)=false", "is no object of the scene; did you mean 'block_3'?"),
        ("grasp(block_99)=no_ik", "'block_99' in 'grasp(block_99)' is no object of the scene"),
        ("clear(block-3)=false", "'block-3' in 'clear(block-3)=false' is no object of the scene"),
        ("grasp: clear(block_3)=false", "'grasp' is no call of a program"),
        ("pikc: clear(block_3)=false", "did you mean 'pick'?"),
    ],
)
def test_an_injection_that_means_nothing_is_misuse(
    text: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*WORDS, "--inject", text]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--expert"], []])
def test_a_fact_is_seen_as_it_is_forced_by_the_program_that_is_named(
    tmp_path: Path, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    item = next(call for call in traced(tmp_path / "plain", *words).calls if call.name == "pick").arguments[0]
    holds = f"pick({item}): holding({item})=true"
    run([*WORDS, *words, "--inject", holds, "--out", str(tmp_path / "forced")])
    trace = read_trace(next((tmp_path / "forced").glob("*.jsonl")))
    if words:  # the core may find another way
        assert trace.end is not None and not trace.end.success
        assert not any(call.name == "grasp" and call.arguments == (item,) for call in trace.calls)
    seen = [
        (each.probability, each.truth)
        for call in trace.calls
        for decision in (call.decision, call.return_decision)
        for each in (decision.facts if decision is not None else ())
        if each.fact == f"holding({item})"
    ]
    assert (1.0, False) in seen
    assert "nothing was forced" not in capsys.readouterr().err


@pytest.mark.parametrize("policy", [["--expert"], []])
def test_a_fact_that_is_forced_and_that_nobody_asks_about_is_told(
    policy: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*WORDS, *policy, "--inject", "on(block_0, gripper)=true"]) == 0
    assert "on(block_0, gripper)=true changed nothing: no decision asked" in capsys.readouterr().err


def test_a_fact_that_is_forced_on_a_program_that_never_runs_is_told(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run([*WORDS, "--inject", "pick(gripper): clear(block_1)=true"]) == 0
    assert "no decision was made by pick(gripper): nothing was forced on it" in capsys.readouterr().err


def test_every_outcome_can_be_forced_by_its_name() -> None:
    registry = ntp_dsl.load("block_stacking")
    for name, outcome in OUTCOMES.items():
        assert Injection.parse(f"grasp( block_1 ) = {name}", registry) == Injection(
            CallPattern("grasp", ("block_1",)), outcome
        )
    assert (
        Breakpoint.parse("not on(block_1,  block_2)", registry, ["block_1", "block_2"]).fact
        == "not on(block_1,block_2)"
    )
