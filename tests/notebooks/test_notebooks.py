"""The notebooks of the documentation run from the first cell to the last, and show what they end in."""

from __future__ import annotations

import ast
import json
from pathlib import Path
from typing import Any

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[2] / "docs" / "notebooks").glob("*.ipynb"))
LONGEST = 2000  # characters of what a cell shows as plain text


def cells(notebook: Path) -> list[str]:
    rows = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    return ["".join(row["source"]) for row in rows if row["cell_type"] == "code"]


def run_cell(source: str, names: dict[str, Any], place: str) -> Any:
    """Return what the cell ends in, as a notebook has it."""
    tree = ast.parse(source, place)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, place, "exec"), names)
    return eval(compile(ast.Expression(last.value), place, "eval"), names) if last else None


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_shows_what_it_ends_in(
    notebook: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": "notebook"}
    for number, source in enumerate(cells(notebook)):
        shown = run_cell(source, names, f"{notebook.name}, cell {number}")
        assert len(repr(shown)) < LONGEST, f"cell {number} floods the page"
        for rich in ("_repr_html_", "_repr_svg_", "_repr_png_"):
            if (draw := getattr(shown, rich, None)) is not None:
                assert draw(), f"{rich} of cell {number} shows nothing"


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_what_it_showed(notebook: Path) -> None:
    rows = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    assert all(row["outputs"] == [] for row in rows if row["cell_type"] == "code")
