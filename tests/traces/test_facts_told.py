"""What holds of a scene's state is told with a call, as where the objects are."""

from __future__ import annotations

from pathlib import Path

import pytest

from ntp_dsl.cli.app import run
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.page.page import page_document
from ntp_dsl.traces.reader import read_trace

RUN = "run libero butter_in_drawer --expert --world kinematic --seed 1".split()


def test_a_page_has_the_state_that_a_call_was_made_in_and_what_it_changed(tmp_path: Path) -> None:
    assert run([*RUN, "--out", str(tmp_path)]) == 0
    trace = read_trace(next(tmp_path.glob("*.jsonl")))
    document = page_document(compare(trace, trace), (tmp_path,))
    changes = {call.name: call.became for call in document.traces[0].calls}
    assert changes["push"] == changes["shut"] == ["not open(top_drawer)"] and changes["grasp"] == []
    held = [[document.texts[each] for each in call.holds] for call in document.traces[0].calls]
    assert held[0] == ["open(top_drawer)"] and held[-1] == []


def test_what_holds_of_an_object_is_told_after_a_call_that_failed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run([*RUN, "--inject", "push=no_path", "--out", str(tmp_path)])
    capsys.readouterr()
    trace = next(tmp_path.glob("*.jsonl"))
    failed = next(call for call in read_trace(trace).calls if call.outcome == "no path")
    assert run(["trace", "explain", str(trace), str(failed.id)]) == 0
    assert "; open(top_drawer)" in " ".join(capsys.readouterr().out.split())
