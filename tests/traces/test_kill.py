"""Traces of a process killed at any moment are read up to their last complete step."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from trees import headed

from ntp_dsl.semantics.observation import Observation
from ntp_dsl.traces.decision import NO_DECISION
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.trace import Trace
from ntp_dsl.traces.writer import TraceWriter

RUN = "run block_stacking tall_towers --slips .4 --pushes .2 --seed 3"
COMMANDS = {
    "run": f"{RUN} --world kinematic",
    "script": f"{RUN} --world kinematic --expert",
    "eval": "eval block_stacking block_stacking --world bullet --episodes 1 --seed 3",
    "record": "record block_stacking block_stacking -n 12 --seed 3",
}
KILLS = {"run": 30, "script": 10, "eval": 10, "record": 50}  # with --soak; else a few


class Forks:
    """Runs commands that can be killed."""

    def __init__(self) -> None:
        words = [sys.executable, str(Path(__file__).with_name("forking.py"))]
        self._server = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def run(self, command: str, after: float | None = None) -> tuple[int, float]:
        """Run a command, killed after a time [s]; return its exit status and duration [s]."""
        assert self._server.stdin and self._server.stdout
        self._server.stdin.write(command + "\n")
        self._server.stdin.flush()
        child = int(self._server.stdout.readline())
        start = time.monotonic()
        if after is not None:
            time.sleep(after)
            try:
                os.kill(child, signal.SIGKILL)
            except ProcessLookupError:
                pass  # it has ended already
        status = int(self._server.stdout.readline())
        return status, time.monotonic() - start

    def close(self) -> None:
        self._server.communicate(timeout=20)


@pytest.fixture(scope="module")
def forks() -> Iterator[Forks]:
    found = Forks()
    yield found
    found.close()


def traces(folder: Path) -> dict[str, Path]:
    """By episode; those that were not whole yet have another name until they are."""
    found = {}
    for path in folder.rglob("*episode_*.trace.jsonl*"):
        name = re.search(r"episode_\d+", path.name)
        assert name is not None
        found[name.group()] = path
    return found


def steps(trace: Trace) -> list[tuple[object, ...]]:
    return [(call.id, call.parent, call.name, call.arguments, call.frame) for call in trace.calls]


@pytest.mark.needs("torch", "pybullet")
@pytest.mark.parametrize("command", COMMANDS)
def test_traces_of_a_killed_process_are_read_up_to_the_last_complete_step(
    forks: Forks, command: str, tmp_path: Path, soak: bool
) -> None:
    whole = tmp_path / "whole"
    status, seconds = forks.run(f"{COMMANDS[command]} --out {whole}")
    assert status in (0, 1)
    known = {name: read_trace(path) for name, path in traces(whole).items()}
    rng = np.random.default_rng(sum(command.encode()))
    killed = read = 0
    for number in range(KILLS[command] if soak else 1):
        folder = tmp_path / str(number)
        status, _ = forks.run(f"{COMMANDS[command]} --out {folder}", float(rng.uniform(0, seconds)))
        killed += status == -signal.SIGKILL
        for name, path in traces(folder).items():
            if b"\n" in path.read_bytes():
                trace = read_trace(path)
                assert steps(trace) == steps(known[name])[: len(trace.calls)]
                read += 1
    assert not soak or (killed > KILLS[command] / 2 and read > KILLS[command] / 4)


def test_every_step_is_flushed_before_the_next(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    with path.open("w", encoding="utf-8") as stream:
        writer = TraceWriter(stream)
        writer.header(headed())
        state = writer.state(Observation((), {}, (0.0, 0.0, 1.0), False))
        running = -1
        for number in range(20):
            running = writer.call(running, "program", f"part_{number}", (), None, 0, state, NO_DECISION)
            assert read_trace(path).calls[-1].name == f"part_{number}"
        writer.returned(running, "done", 0)
        assert read_trace(path).calls[-1].outcome == "done"
