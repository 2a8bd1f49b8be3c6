"""The reference says what is true: its examples parse, and together they check."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ntp_dsl.common.resources import grammar_folder, library_folder
from ntp_dsl.language.checker import check
from ntp_dsl.language.formatting.canonical import format_library
from ntp_dsl.language.parsing.blocks import KEYWORDS
from ntp_dsl.language.parsing.parser import parse
from ntp_dsl.language.syntax.nodes import Library
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.user_code.loading import load_with_python

FENCED = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def page() -> str:
    return (grammar_folder() / "README.md").read_text(encoding="utf-8")


def declarations() -> str:
    """Return the text of every example, as one library."""
    blocks = re.findall(r"(?:^(?: {4}.*)?\n)+", FENCED.sub("", page()), flags=re.MULTILINE)
    return "\n".join(re.sub(r"^ {4}", "", block, flags=re.MULTILINE) for block in blocks)


def reference() -> Library:
    return parse(declarations())


def test_every_example_of_the_reference_checks() -> None:
    tabletop = parse((library_folder() / "tabletop.ntp").read_text())
    registry = check(reference(), tabletop)
    assert registry.apis["pull"].parameters[1].high == 0.3
    assert registry["stow"].takes_list and "serve" in registry.tasks
    assert parse(format_library(reference())) == reference()


def test_every_keyword_has_an_example() -> None:
    kinds = {type(each).__name__.removesuffix("Declaration").lower() for each in reference().declarations}
    assert kinds | {"library", "use"} >= set(KEYWORDS)


def test_the_functions_of_the_reference_are_what_its_declarations_leave_to_python(tmp_path: Path) -> None:
    (tmp_path / "kitchen.ntp").write_text(declarations())
    (tmp_path / "kitchen.py").write_text("\n".join(FENCED.findall(page())))
    registry = load_with_python(tmp_path / "kitchen.ntp")
    assert set(registry.python.functions) == {
        ("expert", "stow_best"), ("predicate", "full"), ("skill", "pull"), ("sampler", "some_of"),
    }  # fmt: skip
    drawn = draw(registry, find_task(registry, "serve_some"), np.random.default_rng(0))
    assert {row.type for row in drawn.goal} == {"Placement"}
    laid = draw(registry, find_task(registry, "set_out"), np.random.default_rng(0))
    assert laid.starts["block_0"].surface.startswith("shelf_") and 2 <= len(laid.goal) <= 3
    assert all(thing.traits for thing in draw(registry, find_task(registry, "put_in_order"),
        np.random.default_rng(0)).objects if thing.type == "Drawer")  # fmt: skip
