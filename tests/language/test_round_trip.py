"""Text and tree mean the same, and no text brings the parser down."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from language_samples import libraries

from ntp_dsl.common.resources import examples_folder, library_folder
from ntp_dsl.language.checker import check
from ntp_dsl.language.diagnostics.diagnostics import SourceError
from ntp_dsl.language.formatting.canonical import format_library
from ntp_dsl.language.parsing.parser import parse
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax.formatter import hash_declaration
from ntp_dsl.language.syntax.nodes import Library

TEXTS = sorted([*library_folder().glob("*.ntp"), *examples_folder().glob("*/*.ntp")])
slow = settings(
    max_examples=120,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)


@slow
@given(libraries)
def test_what_is_formatted_reads_back_as_the_same_tree(library: Library) -> None:
    text = format_library(library)
    assert parse(text) == library
    assert format_library(parse(text)) == text


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: path.stem)
def test_the_libraries_that_ship_read_back_as_the_same_tree(path: Path) -> None:
    library = parse(path.read_text(), path)
    assert parse(format_library(library)) == library


def test_comments_layout_and_docstrings_do_not_change_a_hash() -> None:
    plain = parse("library a\napi go(x: T) requires p(x) achieves q(x)\n")
    spaced = parse(
        'library a\n# why\napi go(\n  x: T\n):\n    """Goes."""\n    requires p( x )  # so\n'
        "    achieves (q(x))\n"
    )
    other = parse("library a\napi go(x: T) requires q(x) achieves p(x)\n")
    hashes = [hash_declaration(each.declarations[0]) for each in (plain, spaced, other)]
    assert hashes[0] == hashes[1] != hashes[2]
    assert len(hashes[0]) == 16


def answers(text: str) -> Registry | SourceError:
    """Check a text; return its registry or its error."""
    try:
        return check(parse(text))
    except SourceError as error:
        assert str(error) and error.diagnostics
        assert all(each.span.line >= 1 for each in error.diagnostics)
        return error


@settings(max_examples=150, deadline=1000, derandomize=True)
@given(st.binary(max_size=200))
def test_noise_is_answered(noise: bytes) -> None:
    answers(noise.decode("utf-8", errors="replace"))


@pytest.mark.parametrize("seed", range(250))
def test_a_mutated_library_is_answered(seed: int) -> None:
    rng = random.Random(seed)
    text = TEXTS[seed % len(TEXTS)].read_text()
    for _ in range(rng.randint(1, 4)):
        at, width = rng.randrange(len(text)), rng.choice([0, 1, 1, 5, 40])
        noise = rng.choice(["", "(", ")", '"""', "\n", " ", ":", "all ", "for", "\t", "\0", "é", "[", "9e9"])
        text = text[:at] + noise + text[at + width :]
    answers(text)


@pytest.mark.parametrize(
    "piece",
    ["(", "not ", "x + ", "all p(x) for x in ", "[", '"""', "f(", "-", "1..", "\n for x in y:"],
)
def test_depth_without_end_is_answered(piece: str) -> None:
    answers(f"library a\npredicate p(): {piece * 3000}x\n")
    answers(f"library a\nprogram p():\n    {piece * 3000}x()\n")


def test_a_quotation_mark_in_a_docstring_opens_nothing() -> None:
    library = parse('library a\n"""5" wide"""\nuse b\ntype T\n    """(\n    3" or # more\n    """\ntype U\n')
    assert [each.name for each in library.declarations] == ["T", "U"]
    assert library.docstring == '5" wide' and len(library.uses) == 1


def test_two_docstrings_of_an_api_are_one() -> None:
    (api,) = parse('library x\napi rest() """Move home."""\n    """Slowly."""\n').declarations
    assert api.docstring == "Move home.\n\nSlowly."


@pytest.mark.parametrize(
    ("text", "once", "twice"),
    [
        ("api go(d: length in {}) by python", "3 .. 12 cm", "3 cm .. 12 cm"),
        ("task t:\n    scene: a: 2 T on table with x({})\n", "-18 .. -14 cm", "-18 cm .. -14 cm"),
    ],
    ids=["of a parameter", "of a position"],
)
def test_a_range_takes_its_unit_from_its_upper_bound(text: str, once: str, twice: str) -> None:
    libraries = [parse(f"library a\n\n{text.format(range)}\n") for range in (once, twice)]
    assert libraries[0] == libraries[1]
    assert once in format_library(libraries[1])
