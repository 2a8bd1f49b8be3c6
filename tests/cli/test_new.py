"""`ntp new`: the new domain can be checked, recorded and trained by the commands of its README."""

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


def test_every_line_of_its_readme_works_as_printed(domain: Path) -> None:
    lines = re.findall(r"^    (ntp .*)", (domain / "README.md").read_text(), re.MULTILINE)
    assert [shlex.split(line)[1] for line in lines] == ["check", "run", "record", "train", "run"]
    few = {"record": ["-n", "3"], "train": ["--iterations", "2"]}
    for line in lines[:-1]:  # two steps of training make no program that can do the task
        words = shlex.split(line)[1:]
        assert run([*words, *few.get(words[0], [])]) == 0, line
    assert (domain / "model" / "pairs.safetensors").is_file()
    assert (domain / "model").name + "/" in (domain / ".gitignore").read_text().split()


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
