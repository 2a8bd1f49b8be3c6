"""`ntp check`: text, JSON and SARIF output; fixes are applied, and nothing else is changed."""

from __future__ import annotations

import json
import os
import pty
import subprocess
import sys
from pathlib import Path
from typing import Any

import fastjsonschema
import pytest

from ntp_dsl.cli.app import run
from ntp_dsl.common.resources import library_folder
from ntp_dsl.language.loader import load

# The schema is the one that @microsoft/sarif-multitool 5.7.0 ships with (MIT).
SCHEMA = json.loads((Path(__file__).parent / "sarif-2.1.0.json").read_text())
validate = fastjsonschema.compile(SCHEMA, use_default=False)
FLAWED = """library a
use tabletop
type Cup is Movabel
type Lid is Movable # é
program go(x: Objct)
    requires present(x) and reachable(x)
    achieves holding(x)
    pik(x)
"""
FIXED = FLAWED.replace("Movabel", "Movable").replace("Objct)", "Object):").replace("pik", "pick")


@pytest.fixture
def flawed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "my lib" / "a.ntp"
    path.parent.mkdir()
    path.write_text(FLAWED, newline="")
    return path


def sarif(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    run(["check", "--static", *words, "--format", "sarif"])
    document: dict[str, Any] = json.loads(capsys.readouterr().out)
    validate(document)
    return document


def test_sarif_fits_its_schema_with_locations_and_fixes(
    capsys: pytest.CaptureFixture[str], flawed: Path
) -> None:
    flawed.write_text("library a\nuse tabletop\ntype Cup is Movabel\ntype Cup\n")
    (log,) = sarif(capsys, str(flawed))["runs"]
    rules = log["tool"]["driver"]["rules"]
    first, second = log["results"]
    for result in (first, second):
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"]
    place = first["locations"][0]["physicalLocation"]
    assert place["artifactLocation"]["uri"] == "my%20lib/a.ntp"
    assert place["region"] == {"startLine": 3, "startColumn": 13, "endLine": 3, "endColumn": 20}
    (change,) = first["fixes"][0]["artifactChanges"]
    assert change["replacements"][0]["insertedContent"]["text"] == "Movable"
    assert second["relatedLocations"][0]["physicalLocation"]["region"]["startLine"] == 3
    assert "fixes" not in second and second["level"] == "error"


def test_sarif_of_a_sound_library_is_a_document_without_results(
    capsys: pytest.CaptureFixture[str],
) -> None:
    (log,) = sarif(capsys, "block_stacking")["runs"]
    assert (log["results"], log["tool"]["driver"]["rules"]) == ([], [])


def test_the_schema_refuses_invalid_sarif(capsys: pytest.CaptureFixture[str]) -> None:
    document = sarif(capsys, "block_stacking")
    document["runs"][0]["tool"]["driver"].pop("name")
    with pytest.raises(fastjsonschema.JsonSchemaValueException):
        validate(document)


def test_fix_repeats_until_nothing_is_left(capsys: pytest.CaptureFixture[str], flawed: Path) -> None:
    assert run(["check", "--static", str(flawed), "--fix"]) == 0
    out = capsys.readouterr().out
    assert flawed.read_text() == FIXED
    assert "- type Cup is Movabel" in out and "+     pick(x)" in out and "sound: " in out


def test_fix_keeps_line_endings_permissions_and_links(tmp_path: Path) -> None:
    path, link = tmp_path / "a.ntp", tmp_path / "b.ntp"
    path.write_bytes(FLAWED.replace("\n", "\r\n").encode())
    path.chmod(0o640)
    link.symlink_to(path)
    assert run(["check", "--static", str(link), "--fix"]) == 0
    assert path.read_bytes() == FIXED.replace("\n", "\r\n").encode()
    assert link.is_symlink() and path.stat().st_mode & 0o777 == 0o640
    assert sorted(tmp_path.iterdir()) == [path, link]


def test_diff_shows_changes_and_writes_nothing(capsys: pytest.CaptureFixture[str], flawed: Path) -> None:
    assert run(["check", "--static", str(flawed), "--diff"]) == 1
    assert "+ program go(x: Object):" in capsys.readouterr().out
    assert flawed.read_text() == FLAWED


def test_fix_leaves_what_it_cannot_fix(capsys: pytest.CaptureFixture[str], flawed: Path) -> None:
    text = "library a\nuse tabletop\ntype Cup is Movable\ntype Cup\n"
    flawed.write_text(text)
    assert run(["check", "--static", str(flawed), "--fix"]) == 1
    assert flawed.read_text() == text and "1 error found\n" in capsys.readouterr().out


def test_fix_changes_used_libraries_but_never_the_standard_one(flawed: Path) -> None:
    before = {path: path.read_bytes() for path in library_folder().iterdir()}
    other = flawed.parent / "other.ntp"
    other.write_text("library other\nuse a\n")
    assert run(["check", "--static", str(other), "--fix"]) == 0
    assert flawed.read_text() == FIXED and "Lid" in load(other).parents
    assert {path: path.read_bytes() for path in library_folder().iterdir()} == before


def test_output_stays_one_document_while_files_are_fixed(
    capsys: pytest.CaptureFixture[str], flawed: Path
) -> None:
    assert run(["check", "--static", str(flawed), "--fix", "--format", "json"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out) == {"sound": True, "diagnostics": []}
    assert "+     pick(x)" in captured.err


def test_fix_and_diff_exclude_each_other(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", "block_stacking", "--fix", "--diff"]) == 2
    assert "choose one" in capsys.readouterr().err


def on_a_terminal(words: list[str], **environment: str) -> str:
    """Return what a command writes to a terminal."""
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "ntp_dsl", *words]
    env = {k: v for k, v in os.environ.items() if k != "NO_COLOR"} | {"TERM": "xterm-256color"} | environment
    with subprocess.Popen(command, stdout=theirs, stderr=theirs, env=env):
        os.close(theirs)
        written = b""
        while True:
            try:
                chunk = os.read(ours, 65536)
            except OSError:  # the other end is closed
                break
            if not chunk:
                break
            written += chunk
    os.close(ours)
    return written.decode()


def test_colour_is_only_for_terminals_that_allow_it(flawed: Path) -> None:
    words = ["check", "--static", str(flawed)]
    assert "\x1b[1;31merror[E001]" in on_a_terminal(words)
    assert "\x1b" not in on_a_terminal(words, NO_COLOR="1")
    piped = subprocess.run([sys.executable, "-m", "ntp_dsl", *words], capture_output=True, text=True)
    assert piped.returncode == 1 and "\x1b" not in piped.stdout


def test_a_command_that_needs_a_sound_library_shows_its_errors(
    capsys: pytest.CaptureFixture[str], flawed: Path
) -> None:
    assert run(["run", str(flawed), "t", "--expert"]) == 2
    captured = capsys.readouterr()
    assert "program go(x: Objct)\n" in captured.err and captured.err.endswith("4 errors found\n")
