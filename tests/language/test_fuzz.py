"""Every text is answered quickly: with a registry, or with diagnostics inside the text."""

from __future__ import annotations

import random
import time
from functools import cache

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from hypothesis.extra.lark import from_lark
from language_samples import libraries
from lark import Lark
from mutations import broken, edited
from sound_libraries import sound_library

from ntp_dsl.common.resources import examples_folder, grammar_folder, library_folder
from ntp_dsl.language.checker import check, check_units, link
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, SourceError, has_errors
from ntp_dsl.language.formatting.canonical import format_library
from ntp_dsl.language.names.incremental_cache import IncrementalCache
from ntp_dsl.language.parsing.blocks import KEYWORDS
from ntp_dsl.language.parsing.parser import lines, parse, read
from ntp_dsl.language.parsing.partial_library import PartialLibrary
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax.nodes import Library, Span

LONGEST = 1.0  # seconds of processor time for one text
SHARES = 20  # into which the texts are split, so that several processes can take them
SLOW = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much]


@cache
def tabletop() -> Library:
    return parse((library_folder() / "tabletop.ntp").read_text())


@cache
def texts() -> list[str]:
    """Return the libraries that ship, and texts that use every construct."""
    paths = [*library_folder().glob("*.ntp"), *examples_folder().glob("*/*.ntp")]
    page = (grammar_folder() / "README.md").read_text()
    shown = "\n".join(row[4:] for row in page.split("\n") if row.startswith("    ") or not row)
    return [*(path.read_text() for path in sorted(paths)), shown, sound_library(random.Random(0))]


CACHE = IncrementalCache()  # of `tabletop`


def all_diagnostics(text: str) -> list[Diagnostic]:
    partial = read(text, None)
    units, found = link([partial, *([] if partial.library.name == "tabletop" else [_tabletop()])])
    CACHE.begin()
    return list(check_units(units, [*partial.diagnostics, *found], {}, cache=CACHE).diagnostics)


@cache
def _tabletop() -> PartialLibrary:
    return read((library_folder() / "tabletop.ntp").read_text(), library_folder() / "tabletop.ntp")


def assert_inside(span: Span, rows: list[str]) -> None:
    assert 1 <= span.line <= span.end_line <= len(rows) + 1, span
    assert 1 <= span.column <= len(rows[span.line - 1]) + 1, span
    end = rows[span.end_line - 1] if span.end_line <= len(rows) else ""
    assert 1 <= span.end_column <= len(end) + 1, span
    assert (span.line, span.column) <= (span.end_line, span.end_column), span


def assert_answered(text: str) -> None:
    start = time.process_time()
    found = all_diagnostics(text)
    error = SourceError(found, {None: lines(text)})
    assert time.process_time() - start < LONGEST, "too slow"
    rows = lines(text).split("\n")
    for each in found:
        spans = [each.span, *(note.span for note in each.notes if note.span.line)]
        spans += [edit.span for edit in each.fix.edits] if each.fix else []
        for span in spans:
            if span.path is None:
                assert_inside(span, rows)
    assert str(error) or not found
    if not has_errors(found):
        assert isinstance(check(parse(text), tabletop()), Registry)


@pytest.mark.parametrize("share", range(SHARES))
def test_every_text_is_answered(share: int, soak: bool) -> None:
    rng = random.Random(share)
    for number in range(90_000 // SHARES if soak else 900 // SHARES):
        text = rng.choice(texts())
        if len(text) > 2000 and rng.random() < 0.8:
            start = text.rfind("\n", 0, rng.randrange(len(text))) + 1
            text = text[start : start + 1500]
        for _ in range(rng.randint(1, 4)):
            text = rng.choice([broken, broken, edited])(text, rng)
        try:
            assert_answered(text)
        except Exception as failure:
            raise AssertionError(f"share {share}, text {number}: {text!r}") from failure


@pytest.mark.parametrize("share", range(4))
def test_texts_of_the_grammar_are_answered(share: int, soak: bool) -> None:
    grammar = Lark((grammar_folder() / "ntp.lark").read_text(), start=list(KEYWORDS))
    spaced = {"_NEWLINE": st.just("\n    "), "_INDENT": st.just(""), "_DEDENT": st.just("")}
    pieces = [from_lark(grammar, start=keyword, explicit=spaced) for keyword in KEYWORDS]

    @settings(
        phases=[Phase.generate],
        max_examples=1_250 if soak else 13,
        deadline=None,
        derandomize=True,
        suppress_health_check=SLOW,
    )
    @given(st.lists(st.one_of(*pieces), min_size=1, max_size=3).map("\n".join))
    def answered(text: str) -> None:
        assert_answered(text)

    answered()


@pytest.mark.parametrize("share", range(4))
def test_random_trees_are_answered(share: int, soak: bool) -> None:
    @settings(
        phases=[Phase.generate],
        max_examples=1_250 if soak else 13,
        deadline=None,
        derandomize=True,
        suppress_health_check=SLOW,
    )
    @given(libraries, st.randoms(use_true_random=False))
    def answered(library: Library, rng: random.Random) -> None:
        text = format_library(library)
        assert_answered(text)
        assert_answered(broken(text, rng))

    answered()


@pytest.mark.parametrize("share", range(4))
def test_a_sound_library_has_no_diagnostics(share: int, soak: bool) -> None:
    for seed in range(share, 1_000 if soak else 20, 4):
        text = sound_library(random.Random(seed))
        found = all_diagnostics(text)
        assert found == [], f"seed {seed}:\n{SourceError(found, {None: text})}\n{text}"
