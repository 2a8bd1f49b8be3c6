"""`docs/debugging.md` as its tests read it: what is planted for each fault, the commands, what they print."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "debugging.md"
SECTION = re.compile(r"^### (.+)$", re.MULTILINE)
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LEFT_OUT = "…"


@dataclass(frozen=True)
class Block:
    """A block of code: a `diff` to plant, `python` to run, or a `console` with commands and their output."""

    kind: str
    text: str


@dataclass(frozen=True)
class Quoted:
    """A command, and the parts of its output that the page quotes."""

    command: str
    parts: tuple[str, ...]


def sections() -> dict[str, list[Block]]:
    """Return the faults of the page by their titles."""
    _, *found = SECTION.split(PAGE.read_text(encoding="utf-8"))
    return {
        title: [Block(*each) for each in BLOCK.findall(text)]
        for title, text in zip(found[::2], found[1::2], strict=True)
    }


def quoted(console: str) -> list[Quoted]:
    """Return the commands of a console, each with what is quoted of its output."""
    _, *found = re.split(r"^\$ (.+)$", console, flags=re.MULTILINE)
    return [
        Quoted(command, tuple(part for part in map(together, text.split(LEFT_OUT)) if part))
        for command, text in zip(found[::2], found[1::2], strict=True)
    ]


def together(text: str) -> str:
    """Return a text without line breaks and alignment, which depend on the width of the terminal."""
    return " ".join(text.split())


def plant(diff: str, folder: Path) -> None:
    """Copy the library that a diff names into a folder, and apply the diff to it."""
    name, *lines = diff.splitlines()
    source = ROOT / name.removeprefix("--- ")
    planted = folder / source.parent.name
    planted.mkdir()
    for file in source.parent.iterdir():
        if file.suffix in (".ntp", ".py"):
            (planted / file.name).write_bytes(file.read_bytes())
    text = source.read_text(encoding="utf-8")
    for old, new in _changes(lines):
        assert text.count(old) == 1, f"expected once in {source.name}: {old}"
        text = text.replace(old, new)
    (planted / source.name).write_text(text, encoding="utf-8")


def _changes(lines: list[str]) -> list[tuple[str, str]]:
    """Return what is taken away and what is put there, by the lines that are without a mark around it."""
    changes, old, new = [], "", ""
    for line in [*lines, LEFT_OUT]:
        if line == LEFT_OUT:
            changes.append((old, new))
            old, new = "", ""
            continue
        mark, rest = line[:1], line[1:] + "\n"
        old += rest if mark in "- " else ""
        new += rest if mark in "+ " else ""
    return [(old, new) for old, new in changes if old]
