"""Faults planted in libraries, demonstrations and checkpoints are named by what the commands print."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from debugging_page import ROOT, plant, quoted, sections, together

from ntp_dsl.cli.app import run

FAULTS = sections()
NAMED = {  # by what the commands print, and not by the fault's own text
    "1": ("It reported success, but beside(block_2, mark_0, 0.09) did not hold", "(-0.001, 0.090, 0.023) m"),
    "2": ("move_beside(plate_0, ahead, 0.16)", "set_the_table.ntp:70", "(0.160, 0.000, 0.095) m"),
    "3": ("No object of the scene is a Tray", "line 27 of make_room"),
    "4": ("no statement achieves on(guard_0, bunk_0)", "which achieves `on(r.relieved, r.post)"),
    "5": ("requires room(item, after, gap)", "call make_room(item, after, gap) before it"),
    "5b": (
        "stood right beside what was put down: block_1 (65)",
        "It may be in the way",
    ),
    "6": (
        "ends with block_2 in the hand",
        "never closed",
        "lacks block_0",
        "(block_1, block_4) were read instead",
    ),
    "7": (
        "slips 1.0",
        "most often by slip pipe_1 (3)",
        "2 of the 15 calls were never made good",
        "dropped: pipe_6",
    ),
    "8": ("no inverse kinematics", "seat_2 at (0.860, 0.000, 0.005) m"),
    "8b": ("goal in collision", "place_0, place_1"),
    "9": ("noise 30 mm", "the noise of 30 mm is too much for it", "rest on a fact seen wrongly"),
    "10": ("is a checkpoint of library 'block_stacking'",),
    "10b": (
        "core/core.safetensors",
        "trained with 4 of 9000 scenes",
        "the model or the demonstration does not fit",
        "6 of 62 decisions",
    ),
}
CRASHED = 70  # exit status of a fault of the commands


def number(title: str) -> str:
    return title.partition(".")[0]


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working directory of the commands, from which the package can be named as in a checkout."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ntp_dsl").symlink_to(ROOT / "ntp_dsl")
    return tmp_path


@pytest.mark.parametrize("title", FAULTS, ids=number)
def test_the_commands_name_the_fault_and_print_what_the_page_quotes(
    title: str, place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    printed = ""
    blocks = FAULTS[title]
    for name in ("line_up", "girths"):
        if not any(block.kind == "diff" for block in blocks) and f"eval {name}" in str(blocks):
            plant(f"--- tests/evaluation/domains/{name}/{name}.ntp", place)  # as it is
    for block in blocks:
        if block.kind == "diff":
            plant(block.text, place)
        elif block.kind == "python":
            exec(block.text, {})
        else:
            for each in quoted(block.text):
                _, *words = shlex.split(each.command)
                assert run(words) != CRASHED
                answers, messages = capsys.readouterr()
                out = together(f"{messages}\n{answers}\n{messages}")  # a terminal shows both
                lacking = [part for part in each.parts if part not in out]
                assert lacking == [], f"{each.command} prints:\n{out}"
                printed += out
    assert [words for words in NAMED[number(title)] if words not in printed] == []


def test_every_fault_of_the_page_is_named() -> None:
    assert {number(title) for title in FAULTS} == set(NAMED)
    assert len({name.rstrip("b") for name in NAMED}) == 10
