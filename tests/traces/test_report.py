"""The report of many episodes: its figures are those of the traces, and its page is safe and complete."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from random import Random
from shutil import copytree

import pytest
from browsing import Page, browser
from test_view import HOSTILE, hostile
from trees import SEEN, headed

from ntp_dsl.cli.app import run
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.decision import NO_DECISION, Decision
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.report.figures import Report
from ntp_dsl.traces.report.reliability import Reliability
from ntp_dsl.traces.report.report_page import report_page
from ntp_dsl.traces.schema import ROOT, Attribution, End, Ending
from ntp_dsl.traces.trace import Trace
from ntp_dsl.traces.writer import TraceWriter

EVAL = "eval block_stacking few_placements -n 4 --seed 3 --slips .6".split()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record four scripted and four learned episodes, and the report of their comparison."""
    path = tmp_path_factory.mktemp("reported")
    assert run([*EVAL, "--expert", "--out", str(path / "scripted")]) == 0
    assert run([*EVAL, "--noise", ".01", "--demo-noise", ".01", "--out", str(path / "learned")]) == 0
    words = ["trace", "report", str(path / "learned"), "--against", str(path / "scripted"), "--worst", "2"]
    assert run([*words, "--out", str(path / "report")]) == 0
    return path


def test_figures_are_those_of_the_traces(folder: Path) -> None:
    report = Report()
    facts: Counter[bool] = Counter()
    for file in sorted((folder / "learned").glob("*.trace.jsonl")):
        trace = read_trace(file)
        report.add(file.stem, trace)
        for call in trace.calls:
            for decision in (call.decision, call.return_decision):
                facts.update(
                    fact.truth for fact in (decision.facts if decision else ()) if fact.truth is not None
                )
    assert (report.succeeded, report.judged, len(report.episodes)) == (4, 4, 4)
    assert sum(each.count for each in report.facts.values()) == facts.total()
    assert sum(each.true for curve in report.facts.values() for each in curve.bins) == facts[True]
    assert report.tasks["few_placements"].interval[1] == 1.0


def test_the_page_names_tasks_lines_and_the_worst_episodes_with_pages_of_their_own(folder: Path) -> None:
    with browser() as chromium:
        found = Page(chromium, folder / "report" / "index.html")
        assert found.text(".lead").startswith("4 of 4 episodes succeeded.")
        assert "few_placements" in found.text("#tasks") and "4 of 4" in found.text("#tasks")
        assert found.page.locator("#episodes tr").count() == 3
        assert found.page.locator("#calibration figure").count() > 3
        source = found.text("#source")
        assert "pick_and_place(p.item, p.support)" in source
        assert found.page.locator("#source tr.never").count() > 0
        assert found.page.locator("#source summary").first.inner_text() == "block_stacking.ntp"
        found.page.locator("#episodes a").first.click()
        found.page.wait_for_selector("#heads")
        assert "B learned: success" in found.text("#heads")
        assert found.messages == []
        found.close()


def made(path: Path, end: End | None, *outcomes: str, source: str = "") -> Trace:
    """Write a trace of primitives that came to these outcomes."""
    with path.open("w", encoding="utf-8") as stream:
        writer = TraceWriter(stream)
        writer.header(headed(task="t", library="made"))
        state = writer.state(SEEN)
        root = writer.call(ROOT, "program", "go", (), None, 0, state, NO_DECISION)
        for number, outcome in enumerate(outcomes):
            call = writer.call(
                root, "api", f"step_{number}", ("block_0",), None, 0, state, Decision(source=source)
            )
            writer.returned(call, outcome, 0)
        if end is not None:
            writer.returned(root, "done", 0, state, NO_DECISION)
            writer.end(end)
    return read_trace(path)


def test_failures_are_counted_by_cause_and_listed_first(tmp_path: Path) -> None:
    lost = End(
        ending=Ending.DONE,
        success=False,
        attributed_to=Attribution.PHYSICS,
        verdict="on(block_3, block_1) does not hold",
        confidence=0.9,
    )
    well = End(ending=Ending.DONE, success=True, confidence=0.8, least=0.4)
    gave_up = End(
        ending=Ending.UNFINISHED, success=False, attributed_to=Attribution.PLANNER, verdict="7 tries"
    )
    report = Report()
    report.add("well", made(tmp_path / "a", well, "achieved"))
    report.add("lost", made(tmp_path / "b", lost, "achieved"))
    report.add("gave up", made(tmp_path / "c", gave_up, "achieved", "no path"))
    report.add("cut off", made(tmp_path / "d", None, "achieved"))
    report.add("nothing", made(tmp_path / "e", gave_up))
    report.add("shown", made(tmp_path / "f", End(ending=Ending.DONE, confidence=0.1), "achieved"))
    assert (report.succeeded, report.judged, report.tasks["t"].unjudged) == (1, 5, 1)
    assert report.confidence.count == 2  # of what was judged
    assert report.tasks["t"].causes == {"physics": 1, "planner": 2, "unknown": 1}
    assert report.failures == {"on(…, …) does not hold": 1, "… tries": 2, "cut off": 1}
    assert [each.name for each in report.worst(9)] == [
        "cut off",
        "gave up",
        "nothing",
        "lost",
        "shown",
        "well",
    ]
    asked = {each.name: each.worth_asking for each in report.episodes}
    assert asked["gave up"] == "step_1(block_0)" and asked["lost"] == "go()" and asked["well"] == ""
    page = report_page(report, "a report", 2, {"cut off": "episodes/001.html"})
    assert page.count("✗") == 2 and 'href="episodes/001.html"' in page


def test_first_divergences_are_counted_at_their_lines(tmp_path: Path) -> None:
    report = Report()
    end = End(ending=Ending.DONE, success=True)
    right = made(tmp_path / "a", end, "achieved", "achieved", source="made.ntp:3")
    for name, other in (
        ("same", ("achieved", "achieved")),
        ("one", ("achieved", "no path")),
        ("two", ("no path",)),
    ):
        report.compare(name, compare(right, made(tmp_path / name, end, *other)))
    assert report.compared == 3 and set(report.divergences) == {"made.ntp:3"}
    assert report.divergences["made.ntp:3"].kinds == {"outcome": 2}
    assert report.divergences["made.ntp:3"].episodes == ["one", "two"]
    assert report.coverage.lines["made.ntp:3"].divergences == {"outcome": 2}


def test_what_cannot_be_read_is_left_out_and_said(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copytree(folder / "learned", tmp_path / "learned")
    (tmp_path / "learned" / "index.trace.jsonl").write_text("no trace\n")
    (tmp_path / "against").mkdir()
    words = ["trace", "report", str(tmp_path / "learned"), "--out", str(tmp_path / "out"), "--worst", "1"]
    assert run([*words, "--against", str(tmp_path / "against")]) == 0
    said = capsys.readouterr()
    assert "skipped" in said.err and "is not compared" in said.err and "4 of 4 episodes" in said.out
    assert run([*words, "--against", str(tmp_path / "nowhere")]) == 2
    assert "is no folder" in capsys.readouterr().err


def test_a_report_replaces_its_like_and_nothing_else(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["trace", "report", str(folder / "learned"), "--worst", "1", "--out"]
    for _ in range(2):
        assert run([*words, str(tmp_path / "again")]) == 0
    notes = tmp_path / "mine" / "index.html"
    notes.parent.mkdir()
    notes.write_text("my own page")
    assert run([*words, str(notes.parent)]) == 2
    assert "of no earlier report" in capsys.readouterr().err and notes.read_text() == "my own page"


def test_json_names_the_page_and_counts(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = folder / "again"
    capsys.readouterr()
    assert run(["trace", "report", str(folder / "learned"), "--out", str(out), "--worst", "0", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said == {"file": str(out / "index.html"), "episodes": 4, "succeeded": 4, "pages": 0}
    assert sorted(each.name for each in out.iterdir()) == ["episodes", "index.html"]
    assert not [*(out / "episodes").iterdir()]


def test_two_folders_of_one_name_are_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    learned = str(folder / "learned")
    assert run(["trace", "report", learned, learned, "--out", str(folder / "twice")]) == 2
    assert "same name" in capsys.readouterr().err


def test_nothing_of_a_hostile_trace_is_markup(tmp_path: Path) -> None:
    report = Report()
    report.add(HOSTILE, hostile(tmp_path / "a.jsonl"))
    text = report_page(report, HOSTILE, 5, {HOSTILE: "page.html"})
    assert "<script" not in text and "<img" not in text and "onerror=alert(1)&gt;" in text


def test_probabilities_that_come_true_as_often_as_they_say_have_no_error() -> None:
    random, right, wrong = Random(1), Reliability(), Reliability()
    for _ in range(20_000):
        chance = random.random()
        right.add(chance, random.random() < chance)
        wrong.add(chance, random.random() < chance**3)
    assert right.error < 0.02 < 0.2 < wrong.error
    assert right.count == 20_000
