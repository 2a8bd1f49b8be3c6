"""The report of many episodes: its figures are those of the traces, and its page is safe and complete."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from random import Random

import pytest
from browsing import Page, browser
from test_view import HOSTILE, hostile

from ntp_dsl.cli.app import run
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.report.figures import Report
from ntp_dsl.traces.report.reliability import Reliability
from ntp_dsl.traces.report.report_page import report_page

EVAL = "eval block_stacking few_placements -n 4 --seed 3 --slips .6".split()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record four scripted and four learned episodes, and the report of their comparison."""
    path = tmp_path_factory.mktemp("reported")
    assert run([*EVAL, "--expert", "--out", str(path / "scripted")]) == 0
    assert run([*EVAL, "--noise", ".02", "--demo-noise", ".02", "--out", str(path / "learned")]) == 0
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
    assert (report.succeeded, len(report.episodes)) == (4, 4)
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


def test_json_names_the_page_and_counts(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = folder / "again"
    capsys.readouterr()
    assert run(["trace", "report", str(folder / "learned"), "--out", str(out), "--worst", "0", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said == {"file": str(out / "index.html"), "episodes": 4, "succeeded": 4, "pages": 0}
    assert [each.name for each in out.iterdir()] == ["index.html"]


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
