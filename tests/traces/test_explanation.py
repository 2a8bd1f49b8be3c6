"""A call is explained by what its trace says: what was seen and true, what was due, and what came of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from ntp_dsl.cli.app import run
from ntp_dsl.traces.decision import Decision, Status
from ntp_dsl.traces.explanation import brief, explanation, interesting
from ntp_dsl.traces.phrases import format_call
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import ROOT
from ntp_dsl.traces.trace import Trace

DOMAINS = Path(__file__).parents[1] / "evaluation" / "domains"
TRACE = "episode_00000.trace.jsonl"


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run a learned program that sees badly, and from whose hand objects slip."""
    path = tmp_path_factory.mktemp("seen_badly")
    words = "--world kinematic --seed 2 --noise 0.012 --slips 0.5".split()
    assert run(["run", str(DOMAINS / "line_up"), "line_up", *words, "--out", str(path)]) == 0
    return path / TRACE


@pytest.fixture(scope="module")
def scripted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scripted")
    words = ["run", "block_stacking", "few_placements", "--world", "kinematic", "--expert"]
    assert run([*words, "--out", str(path)]) == 0
    return path / TRACE


def decisions(trace: Trace) -> list[Decision]:
    made = [call.decision for call in trace.calls if call.parent != ROOT]
    return [*made, *(each.return_decision for each in trace.calls if each.return_decision is not None)]


def test_each_fact_of_a_learned_decision_has_its_truth(file: Path) -> None:
    found = decisions(read_trace(file))
    assert found and all(each.truth is not None for decision in found for each in decision.facts)
    assert any(each.mistaken for each in found)


def test_a_script_rests_on_what_is_true(scripted: Path) -> None:
    for each in decisions(read_trace(scripted)):
        assert each.facts and not each.mistaken
        assert all(fact.probability == float(bool(fact.truth)) for fact in each.facts)


def test_of_a_script_the_statement_that_is_followed_was_due(scripted: Path) -> None:
    trace = read_trace(scripted)
    for call in trace.calls:
        if call.parent != ROOT:
            due = [each for each in call.decision.statements if each.status is Status.DUE]
            assert (call.name, call.arguments) in [(each.callee, each.arguments) for each in due]


def test_the_sentences_that_told_a_program_its_lists_are_told(tmp_path: Path) -> None:
    said = ["block 1 goes on block 2", "put block 3 on that one"]
    words = ["run", "block_stacking", "block_stacking", "--world", "kinematic", "--out", str(tmp_path)]
    assert run([*words, "--say", said[0], "--say", said[1]]) == 0
    trace = read_trace(tmp_path / TRACE)
    text = " ".join(explanation(trace, trace.calls[0]))
    assert (
        f"It was told '{said[0]}' and '{said[1]}', which was understood with a probability of 100%." in text
    )


def test_what_was_seen_wrongly_is_told(file: Path) -> None:
    trace = read_trace(file)
    wrong = [call for call in trace.calls if call.parent != ROOT and call.decision.mistaken]
    call = wrong[0]
    fact = call.decision.mistaken[0]
    text = " ".join(explanation(trace, call))
    assert f"That was wrong: {fact.fact} {'held' if fact.truth else 'did not hold'} in truth." in text
    assert f"wrong about {fact.fact}" in brief(call)


def test_by_default_the_episode_and_its_first_failure_are_explained(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    trace = read_trace(file)
    failed = interesting(trace)
    assert failed is not None and not failed.succeeded
    assert run(["trace", "explain", str(file)]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert told.startswith("The episode by the learned policy")
    assert "slips 0.5, noise 12 mm) succeeded." in told and f" call {failed.id}, " in told
    assert "returned: object dropped, which is attributed to disturbance" in told


def test_a_call_is_chosen_by_number_by_name_and_as_it_is_shown(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    call = next(each for each in read_trace(file).calls if each.name == "make_room")
    shown = format_call(call)
    told = []
    for wanted in (str(call.id), "make_room", shown):
        assert run(["trace", "explain", str(file), wanted]) == 0
        told.append(capsys.readouterr().out)
    assert told[0] == told[1] == told[2] and told[0].startswith(f"call {call.id}, make_room(")


@pytest.mark.parametrize(
    ("wanted", "message"),
    [("make_rome", "did you mean 'make_room'?"), ("99999", "the trace has no call 99999"), ("-1", "-1")],
)
def test_a_call_that_is_not_there_is_misuse(
    file: Path, wanted: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["trace", "explain", str(file), wanted]) == 2
    assert message in capsys.readouterr().err


def test_every_call_can_be_explained(file: Path, scripted: Path) -> None:
    for path in (file, scripted):
        trace = read_trace(path)
        for call in trace.calls:
            paragraphs = explanation(trace, call)
            assert (
                paragraphs[0].startswith(f"call {call.id}, {call.name}(") and "returned: " in paragraphs[-1]
            )


def test_numbers_and_reasons_are_shown(scripted: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trace", "show", str(scripted), "--why"]) == 0
    shown = capsys.readouterr().out
    for call in read_trace(scripted).calls:
        assert f"call {call.id}" in shown
    assert "did not hold" in shown
