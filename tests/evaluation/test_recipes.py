"""The libraries of the recipes are sound, and their experts and the core do what they say."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from ntp_dsl.core.one_core import shipped_core
from ntp_dsl.evaluation.episodes import Plan, run_all
from ntp_dsl.language.loader import diagnose, load

PAGE = (Path(__file__).parents[2] / "docs" / "recipes.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"(?:^(?: {4}.*)?\n)+", re.MULTILINE)
TEXTS = [re.sub(r"^ {4}", "", each, flags=re.MULTILINE).strip() + "\n" for each in BLOCK.findall(PAGE)]
LIBRARIES = {text.split()[1]: text for text in TEXTS if text.startswith("library ")}


@pytest.mark.parametrize("name", LIBRARIES)
def test_a_recipe_is_done_as_it_is_written(name: str, tmp_path: Path) -> None:
    path = tmp_path / f"{name}.ntp"
    path.write_text(LIBRARIES[name])
    assert [str(each) for each in diagnose(path).diagnostics] == []
    for task in load(path).tasks:
        for model in (None, shipped_core()):
            for episode in run_all(Plan(path, task, model), 2, workers=1):
                assert episode.success, (task, episode.reason)


def test_there_are_recipes() -> None:
    assert {"free_pads", "laid_table"} <= set(LIBRARIES)
