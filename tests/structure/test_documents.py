"""Commands and links in the documents exist."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sources import ROOT
from typer import Context

from ntp_dsl.cli.groups import COMMANDS, LazyGroup

DOCUMENTS = sorted(
    path
    for pattern in ("*.md", "docs/**/*.md", "examples/*/README.md", "grammar/*.md")
    for path in ROOT.glob(pattern)
)
LINE = re.compile(r"(?:^|`)(?:\$ |    )*((?:ntp|make) [^`\n]*)", re.MULTILINE)


def lines(program: str) -> list[str]:
    found = {
        line.split("  #")[0].strip()
        for path in DOCUMENTS
        for line in LINE.findall(path.read_text(encoding="utf-8"))
    }
    return sorted(line for line in found if line.startswith(f"{program} "))


def commands(group: LazyGroup, path: str = "ntp") -> Iterator[tuple[str, Any]]:
    context: Any = Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if isinstance(command, LazyGroup):
            yield from commands(command, f"{path} {name}")
        else:
            yield f"{path} {name}", command


EVERY_COMMAND = dict(commands(LazyGroup(COMMANDS)))


@pytest.mark.parametrize("line", lines("ntp"))
def test_a_command_line_of_the_documents_exists(line: str) -> None:
    named = [name for name in EVERY_COMMAND if line == name or line.startswith(f"{name} ")]
    assert named, f"there is no such command; there are {list(EVERY_COMMAND)}"
    options = {each for param in EVERY_COMMAND[named[0]].params for each in param.opts}
    used = {word.split("=")[0] for word in shlex.split(line) if re.match(r"--?[a-z]", word)}
    assert used <= options | {"--help"}


@pytest.mark.parametrize("line", lines("make"))
def test_a_make_target_of_the_documents_exists(line: str) -> None:
    targets = re.findall(r"^([\w-]+):(?!=)", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert line.split()[1].split("=")[0] in [*targets, "PYTHON"]


@pytest.mark.parametrize("name", EVERY_COMMAND)
def test_a_command_says_what_it_does_with_an_example_that_exists(name: str) -> None:
    help = EVERY_COMMAND[name].help or ""
    example = re.search(rf"Example: ({name} [^\n]*)", help)
    assert example, f"the help of {name} has no example"
    test_a_command_line_of_the_documents_exists(example.group(1))


def test_the_readme_is_read_in_one_sitting() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").split()) <= 600


def test_every_page_is_in_the_index() -> None:
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    pages = {path.name for path in (ROOT / "docs").glob("*.md")} - {"index.md"}
    assert {page for page in pages if f"]({page})" not in index} == set()


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_what_a_document_links_to_is_there(document: Path) -> None:
    links = re.findall(r"\]\(([^)#:]+)\)", document.read_text(encoding="utf-8"))
    assert [link for link in links if not (document.parent / link).exists()] == []
