"""`ntp check --fix` writes what is certain and nothing else; `--diff` shows just that."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ntp_dsl.cli.app import run
from ntp_dsl.language.diagnostics.spelling import is_misspelt
from ntp_dsl.language.syntax.foreign_units import in_our_units

SOUND = """library towers
use tabletop
program build(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        pick_and_place(p.item, p.support)
task tall:
    scene: blocks: 8 Block on table with cube(5 cm)
    goal: towers(blocks, placements=1..6, height=2..4)
    run: build(goal)
    success: all on(p.item, p.support) for p in goal
"""
OFFERED = SOUND.replace("    success: all on(p.item, p.support) for p in goal\n", "")


@pytest.fixture
def library(tmp_path: Path) -> Path:
    return tmp_path / "towers.ntp"


def fixed(library: Path, text: str, *words: str) -> str:
    """Return what `ntp check --fix` leaves of a library."""
    library.write_text(text)
    run(["check", str(library), "--fix", *words])
    return library.read_text()


def test_an_offer_is_shown_and_never_applied(capsys: pytest.CaptureFixture[str], library: Path) -> None:
    assert fixed(library, OFFERED) == OFFERED
    out = capsys.readouterr().out
    assert "offer: perhaps this is meant" in out and "fixable with --fix" not in out


def test_json_and_sarif_say_whether_a_fix_is_certain(
    capsys: pytest.CaptureFixture[str], library: Path
) -> None:
    library.write_text(OFFERED.replace("cube(5 cm)", "cube(50 mms)"))
    run(["check", str(library), "--format", "json"])
    rows = json.loads(capsys.readouterr().out)["diagnostics"]
    assert {row["code"]: row["fix"]["certain"] for row in rows} == {"E501": False, "E107": True}
    run(["check", str(library), "--format", "sarif"])
    results = json.loads(capsys.readouterr().out)["runs"][0]["results"]
    words = {each["ruleId"]: each["fixes"][0]["description"]["text"] for each in results}
    assert words["E107"] == "This is meant." and "leaves it to you" in words["E501"]


def test_diff_shows_all_rounds_of_what_fix_writes(capsys: pytest.CaptureFixture[str], library: Path) -> None:
    flawed = SOUND.replace("for p in goal:\n", "for p in goal\n").replace("pick_and_place", "pick_an_place")
    library.write_text(flawed)
    run(["check", str(library), "--diff"])
    shown = capsys.readouterr().out
    assert library.read_text() == flawed
    assert fixed(library, flawed) == SOUND
    written = capsys.readouterr().out
    changes = [line for line in written.split("\n") if line.lstrip(" 0123456789").startswith(("+ ", "- "))]
    assert len(changes) == 4 and shown.startswith("\n".join(written.split("\n")[:5]))


def test_a_fix_with_which_the_simulation_fails_is_taken_back(
    capsys: pytest.CaptureFixture[str], library: Path
) -> None:
    flawed = SOUND.replace("cube(5 cm)", "cube(20 inch)")
    assert fixed(library, flawed, "--static") == SOUND.replace("cube(5 cm)", "cube(50.8 cm)")
    capsys.readouterr()
    assert fixed(library, flawed) == flawed
    out = capsys.readouterr().out
    assert "a fix was taken back at" in out and "no scene of 'tall' can be made" in out


def test_a_fix_with_which_the_text_is_worse_is_taken_back(
    capsys: pytest.CaptureFixture[str], library: Path
) -> None:
    flawed = "library towers\ntype Place\ntype Cup is Movable\n"  # `use tabletop` would declare Place again
    assert fixed(library, flawed) == flawed
    out = capsys.readouterr().out
    assert "a fix was taken back at" in out and "type 'Place' is also declared by library 'tabletop'" in out


def test_what_changes_the_order_of_calls_is_an_offer(library: Path) -> None:
    text = SOUND + "api beep()\nprogram ring():\n    requires holding(any)\n    achieves empty(gripper)\n"
    text += "    beep()\n    release()\n"
    assert fixed(library, text, "--static") == text


@pytest.mark.parametrize(
    "value, unit, meant",
    [
        (500, "g", (0.5, "kg")), (2, "dm", (0.2, "m")), (2, "km", (2000, "m")), (3, "um", (0.003, "mm")),
        (85, "gon", (76.5, "deg")), (2, "inch", (5.08, "cm")), (3, "min", (180, "s")), (5, "CM", (5, "cm")),
        (2, "kgs", (2, "kg")), (2, "t", (2000, "kg")), (0.1, "ft", (0.03048, "m")),
        (3, "Hours", (10800, "s")),
    ],
)  # fmt: skip
def test_a_foreign_unit_is_converted_exactly(value: float, unit: str, meant: tuple[float, str]) -> None:
    number = in_our_units(value, unit)
    assert number is not None and (number.value, number.unit) == meant


@pytest.mark.parametrize("unit", ["Nm", "cmm", "G", "Grad", "M", "mmm", "x", "5"])
def test_what_is_no_unit_is_not_guessed(unit: str) -> None:
    assert in_our_units(3, unit) is None


@pytest.mark.parametrize(
    "name, meant, others, certain",
    [
        ("tabel", "table", (), True), ("pik", "pick", (), True), ("Movabel", "Movable", (), True),
        ("pickAndPlace", "pick_and_place", (), True), ("pick_and_plcae", "pick_and_place", (), True),
        ("plate", "place", (), False), ("lock", "block", (), False), ("bin_3", "bin_1", ("bin_2",), False),
        ("bin_3", "bin_1", (), False), ("unstack", "stack", (), False), ("cap", "cup", (), False),
        ("boxs", "box", ("boxes",), False), ("x", "y", (), False), ("left_pin", "left_bin", (), False),
    ],
)  # fmt: skip
def test_only_a_typing_error_is_certainly_one(
    name: str, meant: str, others: tuple[str, ...], certain: bool
) -> None:
    assert is_misspelt(name, meant, [meant, *others]) is certain
