"""Small libraries for the dynamic check, and its diagnostics."""

from __future__ import annotations

from pathlib import Path

from ntp_dsl.dynamic.check import check_dynamically
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.loader import load

PLACING = """
program fill(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        pick_and_place(p.item, p.support)
"""
BRINGING = """
program fill(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        bring(p.item, p.support)

program bring(item: Movable, support: Place):
    requires present(item) and reachable(item) and present(support) and reachable(support)
    achieves on(item, support)
"""
STACKING = """
task tower:
    scene:   blocks: 5 Block on table
    goal:    towers(blocks, placements=1..2, height=2)
    run:     {run}
    success: {success}
"""
ALL_ON = "all on(p.item, p.support) for p in goal"


def written(folder: Path, declarations: str) -> Path:
    path = folder / "mine.ntp"
    path.write_text(f"library mine\nuse tabletop\n{declarations}")
    return path


def diagnostics(path: Path) -> list[Diagnostic]:
    return check_dynamically(load(path), path)


def excerpt(path: Path, diagnostic: Diagnostic) -> str:
    row = path.read_text().split("\n")[diagnostic.span.line - 1]
    return row[diagnostic.span.column - 1 : diagnostic.span.end_column - 1]
