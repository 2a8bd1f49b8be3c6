"""An incremental check reports what a full check reports, whatever was edited in between."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from mutations import edited

from ntp_dsl.language.incremental import Session
from ntp_dsl.language.loader import diagnose

SHAPES = """library shapes
use tabletop
type Cup is Movable
enum Side: left, right
record Serving(cup: Cup, side: Side)
constant tray: Place
predicate served(c: Cup): on(c, tray) and clear(c)
api turn(c: Cup, side: Side)
    requires holding(c)
    achieves clear(c)
"""
KITCHEN = """library kitchen
use shapes
program serve(c: Cup):
    requires present(c) and reachable(c)
    achieves served(c)
    clear(tray)
    pick_and_place(c, tray)

program spin(c: Cup, side: Side):
    requires present(c) and reachable(c)
    achieves holding(c)
    pick(c)
    when side == left: turn(c, left)

program free(x: Place):
    achieves not some on(o, x) for o in Object
    for o in Object if on(o, x):
        pick_and_place(o, table)

program serve_all(goal: list[Serving]):
    achieves all served(s.cup) for s in goal
    for s in goal:
        serve(s.cup)

program again(c: Cup):
    requires present(c) and reachable(c)
    achieves served(c)
    serve(c)
"""


@pytest.mark.parametrize("seed", range(12))
def test_an_incremental_check_reports_what_a_full_one_reports(seed: int, tmp_path: Path, soak: bool) -> None:
    rng = random.Random(seed)
    path, other = tmp_path / "kitchen.ntp", tmp_path / "shapes.ntp"
    texts = {path: KITCHEN, other: SHAPES}
    session = Session()
    for _ in range(200 if soak else 12):
        edit = rng.choice([path, path, other])
        if rng.random() < 0.3:
            texts[edit] = KITCHEN if edit == path else SHAPES
        else:
            texts[edit] = edited(texts[edit], rng)
        for each, text in texts.items():
            each.write_text(text, newline="")
        assert session.diagnose(path).diagnostics == diagnose(path).diagnostics


def test_edited_texts_replace_their_files(tmp_path: Path) -> None:
    path = tmp_path / "shapes.ntp"
    path.write_text(SHAPES)
    session = Session()
    assert session.diagnose(path).diagnostics == ()
    moved = session.diagnose(path, {path: "\n\n" + SHAPES}).registry
    assert moved is not None and moved["turn"].span.line == 10
    text = "\n\n" + SHAPES.replace("is Movable", "is Movabel")
    (mistake,) = session.diagnose(path, {path: text}).diagnostics
    assert (mistake.code, mistake.span.line) == ("E103", 5)
