"""One layout: nothing but blanks and brackets changes, comments stay where they belong."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from language_samples import libraries

from ntp_dsl.language.canonical import format_library, format_text
from ntp_dsl.language.formatter import hash_declaration
from ntp_dsl.language.parser import parse
from ntp_dsl.language.syntax import Library
from ntp_dsl.resources import examples_folder, library_folder

TEXTS = sorted([*library_folder().glob("*.ntp"), *examples_folder().glob("*/*.ntp")])
STRING = re.compile(r'"""[\s\S]*?"""|"[^"\n]*"')
COMMENT = re.compile(rf"{STRING.pattern}|(#[^\n]*)")
slow = settings(
    max_examples=150,
    deadline=None,
    derandomize=True,
    phases=[Phase.generate],  # a large text is soon found, and takes minutes to make small
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)


def comments(text: str) -> list[str]:
    """Every comment; several that came to stand on one line count each."""
    found = [match.group(1) for match in COMMENT.finditer(text) if match.group(1)]
    return sorted(part for each in found for part in re.findall(r"#[^#]*", each.replace("  ", "")))


def disturbed(text: str, rng: random.Random) -> str:
    """The same tree, with comments, blanks, empty lines and line breaks wherever they may be."""
    kept: list[str] = []

    def hide(match: re.Match[str]) -> str:
        kept.append(match.group())
        return f"\0{len(kept) - 1}\0"

    hidden = STRING.sub(hide, text)
    written, depth = "", 0
    for mark in re.findall(r"\0\d+\0|\w+|\.\.|[^\w]", hidden):
        depth += (mark in "([") - (mark in ")]")
        if mark == "\n" and depth == 0:
            written += rng.choice(["", "", " ", f"  #t{len(written)}"]) + "\n"
            if rng.random() < 0.3:
                written += " " * rng.choice([0, 2, 4, 7]) + f"# o{len(written)}\n"
            written += rng.choice(["", "", "", "\n", " \n\n"])
        elif mark == " " and depth and rng.random() < 0.2:
            written += rng.choice(["  ", "\n", f" # i{len(written)}\n", f"\n#l{len(written)}\n "])
        elif mark in "([" and rng.random() < 0.2:
            written += mark + rng.choice([" ", "\n", f"#b{len(written)}\n", f"\n  # c{len(written)}\n"])
        elif mark in ")]" and rng.random() < 0.2:
            written += rng.choice([" ", "\n", f"#e{len(written)}\n", f"\n  # d{len(written)}\n"]) + mark
        else:
            written += mark
    return re.sub(r"\0(\d+)\0", lambda match: kept[int(match.group(1))], written)


def check_layout(text: str) -> None:
    tree = parse(text)
    formatted = format_text(text)
    assert parse(formatted) == tree
    assert format_text(formatted) == formatted
    assert comments(formatted) == comments(text)
    assert [*map(hash_declaration, parse(formatted).declarations)] == [
        *map(hash_declaration, tree.declarations)
    ]


@slow
@given(libraries, st.randoms(use_true_random=False))
def test_every_text_has_one_layout_that_keeps_its_comments(
    library: Library, rng: random.Random
) -> None:
    plain = format_library(library)
    assert format_text(plain) == plain
    check_layout(disturbed(plain, rng))


@pytest.mark.parametrize("seed", range(40))
def test_the_libraries_that_ship_come_back_from_any_layout(seed: int) -> None:
    text = TEXTS[seed % len(TEXTS)].read_text()
    other = disturbed(text, random.Random(seed))
    check_layout(other)
    without = re.sub(r"(?m)^ *#.*\n| *#.*$", "", other)
    assert format_library(parse(without)) == format_library(parse(text))


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: path.stem)
def test_the_libraries_that_ship_are_in_this_layout(path: Path) -> None:
    assert format_text(path.read_text(), path) == path.read_text()
