"""A promise is kept where calls achieve it, as a whole or in its parts."""

from __future__ import annotations

from pathlib import Path

import pytest

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.loader import diagnose

LIBRARY = """
library a
use containers

type Gift is Movable
type Case is Movable
type Lid is Movable
record Parcel(gift: Gift, case: Case, lid: Lid)
predicate there(x: Place): present(x) and reachable(x)
predicate all_there(g: Gift, c: Case, l: Lid): there(g) and there(c) and there(l)
predicate packed(g: Gift, c: Case, l: Lid): in(g, c) and on(l, c)

program pack(g: Gift, c: Case, l: Lid):
    requires all_there(g, c, l) and hollow(c)
    achieves {pack}
    put_in(g, c)
    {close}

program pack_all(goal: list[Parcel]):
    achieves all packed(p.gift, p.case, p.lid) for p in goal
    for p in goal:
        pack(p.gift, p.case, p.lid)
"""
IN_PARTS, WHOLE = "in(g, c) and on(l, c)", "packed(g, c, l)"


def promises(folder: Path, pack: str, close: str = "pick_and_place(l, c)") -> list[Diagnostic]:
    path = folder / "a.ntp"
    path.write_text(LIBRARY.replace("{pack}", pack).replace("{close}", close))
    found = diagnose(path).diagnostics
    assert [str(each) for each in found if each.severity == "error"] == []
    return [each for each in found if each.code == "N401"]


@pytest.mark.parametrize("pack", [IN_PARTS, WHOLE])
def test_what_is_composed_is_achieved_by_achieving_its_parts(tmp_path: Path, pack: str) -> None:
    assert promises(tmp_path, pack) == []


def test_of_a_composed_predicate_the_reversed_part_is_named(tmp_path: Path) -> None:
    (note,) = promises(tmp_path, WHOLE, "pick_and_place(c, l)")
    expected = "packed(g, c, l) is promised, and the calls achieve 'on' of other objects only"
    assert note.message == expected


LAMPS = """
library lamps
use tabletop

type Lamp is Place
predicate lit(l: Lamp) by state
predicate warm(l: Lamp) by state
api light(l: Lamp)
    requires warm(l)
    achieves lit(l)
api rub(l: Lamp)
    requires not {dark}
    achieves warm(l)
program prepare(l: Lamp):
    requires not {dark}
    achieves warm(l)
    rub(l)
program brighten(l: Lamp):
    achieves {wanted}
    prepare(l)
    light(l)
"""


@pytest.mark.parametrize(
    "wanted, dark, is_given",
    [
        ("lit(l)", "lit(l)", True),
        ("all lit(k) for k in Lamp", "lit(l)", False),
        ("lit(l) and exactly 0 warm(k) for k in Lamp", "lit(l)", False),
    ],
)
def test_of_one_fact_that_is_to_be_achieved_it_is_given_that_it_does_not_hold(
    wanted: str, dark: str, is_given: bool, tmp_path: Path
) -> None:
    path = tmp_path / "lamps.ntp"
    path.write_text(LAMPS.format(wanted=wanted, dark=dark))
    codes = [each.code for each in diagnose(path).diagnostics if each.severity == "error"]
    assert ("E403" not in codes) is is_given
