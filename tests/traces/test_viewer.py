"""A run is sent to a rerun viewer as it happens."""

from __future__ import annotations

import re
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from reading_rerun import read_by_rerun

from ntp_dsl.cli.app import run
from ntp_dsl.traces.reader import read_trace

RUN = "run block_stacking few_placements --world kinematic --seed 3".split()
SOON = 60  # [s] that a test waits for another process, at most


def free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port: int = free.getsockname()[1]
    return port


@contextmanager
def viewer(file: Path) -> Iterator[int]:
    """Start what stands for a viewer, and writes all that it is sent to a file; give its port."""
    pytest.importorskip("rerun", reason="rerun is not here: pip install 'ntp_dsl[viz]'")
    port = free_port()
    words = [sys.executable, "-m", "rerun", "--port", str(port), "--save", str(file)]
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        for _ in range(10 * SOON):
            with socket.socket() as tried:
                if tried.connect_ex(("127.0.0.1", port)) == 0:
                    break
            time.sleep(0.1)
        yield port
    finally:
        process.terminate()
        process.wait(timeout=SOON)


@pytest.mark.filterwarnings("ignore:RRD file has no footer")  # it was cut off
def test_a_viewer_has_every_call_once_and_where_objects_end(tmp_path: Path) -> None:
    file = tmp_path / "seen.rrd"
    with viewer(file) as port:
        assert run([*RUN, "--out", str(tmp_path), "--viewer", str(port)]) == 0
    entities = read_by_rerun(file)
    trace = read_trace(tmp_path / "episode_00000.trace.jsonl")
    texts = [text for row in entities["/A/calls"]["TextLog:text"] for text in row]
    assert [text.strip().split("(")[0] for text in texts] == [call.name for call in trace.calls]
    last = trace.motions[-1].positions | trace.states[len(trace.states) - 1].positions
    for obj in trace.header.objects:
        places = [place for place in entities[f"/A/scene/{obj.name}"]["Transform3D:translation"] if place]
        assert places[-1][0] == pytest.approx(last[obj.name], abs=1e-3)


def test_where_no_viewer_answers_nothing_is_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("rerun", reason="rerun is not here: pip install 'ntp_dsl[viz]'")
    assert run([*RUN, "--out", str(tmp_path), "--viewer", str(free_port())]) == 2
    assert re.search("no rerun viewer answers at .*: start one with", capsys.readouterr().err)
    assert not [*tmp_path.glob("*.jsonl")]


def test_what_is_no_address_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*RUN, "--viewer", "here"]) == 2
    assert "--viewer: expected a port, such as 9876, or an address" in capsys.readouterr().err
