"""`ntp new`: the new domain can be checked and run by the commands of its README."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from ntp_dsl.cli.app import run
from ntp_dsl.language.formatting.canonical import format_text


@pytest.fixture(params=[[], ["--python"]], ids=["plain", "python"])
def domain(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    assert run(["new", "pairs", *request.param, "--out", "my domains"]) == 0
    return Path("my domains") / "pairs"


def test_every_line_of_its_readme_works_as_printed(domain: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = re.findall(r"^    (ntp .*)", (domain / "README.md").read_text(), re.MULTILINE)
    assert [shlex.split(line)[1] for line in lines] == ["check", "run", "run", "read", "eval"]
    for line in lines:
        assert run(shlex.split(line)[1:]) == 0, line
    assert re.search(r"^success +1\.000 ", capsys.readouterr().out, re.MULTILINE)


def test_it_is_in_canonical_layout_without_placeholders(domain: Path) -> None:
    text = (domain / "pairs.ntp").read_text()
    assert format_text(text) == text
    assert not any("$" in path.read_text() for path in domain.iterdir())


def test_existing_files_are_not_overwritten(capsys: pytest.CaptureFixture[str], domain: Path) -> None:
    before = {path: path.read_bytes() for path in domain.iterdir()}
    assert run(["new", "pairs", "--out", str(domain.parent)]) == 2
    assert "exists already" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in domain.iterdir()} == before


@pytest.mark.parametrize(
    "name, message",
    [
        ("my domain", "for example: my_domain"),
        ("9", "letters, digits and underscores"),
        ("all", "keyword of the language"),
        ("tabletop", "standard library"),
    ],
)
def test_an_invalid_name_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str, message: str
) -> None:
    assert run(["new", name, "--out", str(tmp_path)]) == 2
    assert message in capsys.readouterr().err and not any(tmp_path.iterdir())
