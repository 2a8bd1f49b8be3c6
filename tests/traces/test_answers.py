"""A trace keeps what was asked and answered: it is shown, and a replay heeds it."""

from __future__ import annotations

from pathlib import Path

import pytest

from ntp_dsl.cli.app import run
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.page.page import page
from ntp_dsl.traces.reader import read_trace

LANTERNS = Path(__file__).parents[1] / "evaluation" / "domains" / "lanterns"
QUESTION = "(lantern_2, post_0, post_2) 50% or (lantern_2, post_1, post_1) 50%"


@pytest.fixture(scope="module")
def answered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run a task of which either of two bays may be lit, and say that it is the other."""
    path = tmp_path_factory.mktemp("answered")
    asked = "--world kinematic --seed 0 --ask-below 0.9 --answer 2 --answer 2".split()
    assert run(["run", str(LANTERNS), "in_doubt", *asked, "--out", str(path)]) == 0
    return path / "episode_00000.trace.jsonl"


def test_question_and_answer_are_shown(answered: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trace", "show", str(answered)]) == 0
    shown = capsys.readouterr().out
    assert f"{QUESTION}; answered (lantern_2, post_1, post_1)" in shown
    assert "confidence 100%" in shown


@pytest.fixture(scope="module")
def advised(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run a task of which it is not seen well whether all is done, and say that it is not."""
    path = tmp_path_factory.mktemp("advised")
    asked = "--world kinematic --seed 10 --noise 0.012 --ask-below 0.8".split()
    answers = [word for answer in "112" for word in ("--answer", answer)]
    assert run(["run", str(LANTERNS), "in_doubt", *asked, *answers, "--out", str(path)]) == 0
    return path / "episode_00000.trace.jsonl"


def test_what_somebody_said_is_to_be_done_is_shown(advised: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trace", "show", str(advised)]) == 0
    shown = capsys.readouterr().out
    assert (
        "pick(lantern_" in shown
        and "light_all([]) might be done" in shown
        and "; answered light(lantern_" in shown
    )
    trace = read_trace(advised)
    assert "somebody was asked" in page(compare(trace, trace), (advised.parent, advised.parent))


def test_a_replay_does_what_somebody_said(advised: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trace", "replay", str(advised), "--library", str(LANTERNS)]) == 0
    assert "the same" in capsys.readouterr().out


def test_the_page_has_them_where_the_program_decides(answered: Path) -> None:
    trace = read_trace(answered)
    text = page(compare(trace, trace), (answered.parent, answered.parent))
    assert "as its caller read it" in text and "as somebody answered" in text


def test_a_replay_is_as_sure_as_the_run_was(tmp_path: Path) -> None:
    shown = "--world kinematic --seed 1 --demo-noise 0.01".split()
    run(["run", str(LANTERNS.parent / "sky"), "sky", *shown, "--out", str(tmp_path)])
    file, replayed = tmp_path / "episode_00000.trace.jsonl", tmp_path / "replayed.jsonl"
    run(["trace", "replay", str(file), "--library", str(LANTERNS.parent / "sky"), "--out", str(replayed)])
    pairs = list(zip(read_trace(file).calls, read_trace(replayed).calls, strict=True))
    assert any((call.decision.probability or 1) < 0.9 for call, _ in pairs)
    assert [call.decision.probability for call, _ in pairs] == [
        each.decision.probability for _, each in pairs
    ]


def test_a_replay_reads_what_was_answered(answered: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trace", "replay", str(answered), "--library", str(LANTERNS)]) == 0
    assert "the same" in capsys.readouterr().out


def test_a_run_by_a_goal_is_replayed_with_its_answers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["read", str(LANTERNS), "in_doubt", "--seed", "3"]) == 0
    (tmp_path / "goal.txt").write_text(capsys.readouterr().out)
    words = "--world kinematic --seed 3 --noise 0.012 --ask-below 1 --ask-calls-below 0.9".split()
    answers = ["--answer", "1"] * 9
    given = ["--goal", str(tmp_path / "goal.txt"), "--out", str(tmp_path)]
    assert run(["run", str(LANTERNS), "in_doubt", *words, *answers, *given]) == 0
    file = tmp_path / "episode_00000.trace.jsonl"
    assert [*read_trace(file).questions()]
    capsys.readouterr()
    assert run(["trace", "replay", str(file), "--library", str(LANTERNS)]) == 0
    assert "the same" in capsys.readouterr().out
