"""The reference says what is true: its examples parse, and together they check."""

from __future__ import annotations

import re

from ntp_dsl.language.checker import check
from ntp_dsl.language.formatter import format_library
from ntp_dsl.language.parser import parse
from ntp_dsl.language.pieces import KEYWORDS
from ntp_dsl.language.syntax import Library
from ntp_dsl.resources import grammar_folder, library_folder


def reference() -> Library:
    page = (grammar_folder() / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"(?:^(?: {4}.*)?\n)+", page, flags=re.MULTILINE)
    return parse("\n".join(re.sub(r"^ {4}", "", block, flags=re.MULTILINE) for block in blocks))


def test_every_example_of_the_reference_checks() -> None:
    tabletop = parse((library_folder() / "tabletop.ntp").read_text())
    registry = check(reference(), tabletop)
    assert registry.apis["pull"].parameters[1].high == 0.3
    assert registry["stow"].takes_list and "serve" in registry.tasks
    assert parse(format_library(reference())) == reference()


def test_every_keyword_has_an_example() -> None:
    kinds = {
        type(each).__name__.removesuffix("Declaration").lower() for each in reference().declarations
    }
    assert kinds | {"library", "use"} >= set(KEYWORDS)
