"""An element of a list is told by its fields: by their types, by their names, over several clauses."""

from __future__ import annotations

from pathlib import Path

import pytest
from listening import in_scene, lists, scene

import ntp_dsl
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.libraries import load, load_text

DOMAINS = Path(__file__).parents[1] / "evaluation" / "domains"
MAIL = """
library mail
use containers

type Chute is Place
type Basket is Place
type Parcel is Movable
type Egg is Movable
enum City: oslo, rome
enum Load: light, heavy
record Rule(city: City, load: Load, chute: Chute)
record Count(basket: Basket, eggs: number in 0 .. 3)
predicate city(p: Parcel) -> City
predicate load(p: Parcel) -> Load
predicate sorted(r: Rule): all in(p, r.chute) for p in Parcel if city(p) == r.city and load(p) == r.load
predicate most(b: Basket, n: number): n == n and some in(e, b) for e in Egg

program drop_off(p: Parcel, c: Chute):
    requires present(p) and reachable(p) and present(c) and reachable(c)
    achieves in(p, c)
    pick_and_place(p, c)

program apply(r: Rule):
    requires present(r.chute) and reachable(r.chute)
    achieves sorted(r)
    for p in Parcel if city(p) == r.city and load(p) == r.load:
        drop_off(p, r.chute)

program sort(rules: list[Rule]):
    achieves all sorted(r) for r in rules
    for r in rules:
        apply(r)

program add(e: Egg, b: Basket):
    requires present(e) and reachable(e) and present(b) and reachable(b)
    achieves in(e, b)
    pick_and_place(e, b)

program fill(b: Basket, n: number):
    requires present(b) and reachable(b)
    achieves most(b, n)
    for e in Egg:
        add(e, b)

program fill_all(counts: list[Count]):
    achieves all most(c.basket, c.eggs) for c in counts
    for c in counts:
        fill(c.basket, c.eggs)

task sorting:
    scene:
        chutes: 2 Chute on table with bin(12 cm, 12 cm, 4 cm)
        heavies: 1 Parcel on table with cube(4 cm), city(oslo), load(heavy)
        lights: 1 Parcel on table with cube(4 cm), city(rome), load(light)
    goal:    (oslo, heavy, chute_0)
    run:     sort(goal)
    success: all sorted(r) for r in goal

task filling:
    scene:
        baskets: 2 Basket on table with bin(12 cm, 12 cm, 4 cm)
        eggs: 3 Egg on table with cube(3 cm)
    goal:    (basket_0, 2)
    run:     fill_all(goal)
    success: all most(c.basket, c.eggs) for c in goal
"""


def heard(domain: str, text: str) -> list[str]:
    who, _ = in_scene(ntp_dsl.load(DOMAINS / domain), domain)
    return lists(who, text)


@pytest.mark.parametrize(
    ("domain", "text", "meant"),
    [
        (
            "garden_rows",
            "plant pot 1 with label 0 at stake 2, with a gap of 8 cm",
            "(pot_1, label_0, stake_2, 0.08)",
        ),
        (
            "garden_rows",
            "stake 0 gets pot 2 and label 0, with a gap of 9 cm",
            "(pot_2, label_0, stake_0, 0.09)",
        ),
        (
            "garden_rows",
            "set out pot 0 ahead of stake 1 with a gap of 6 cm, then label 2 ahead of it",
            "(pot_0, label_2, stake_1, 0.06)",
        ),
        (
            "sandwiches",
            "make a sandwich on plate 0: bottom slice 1, filling cheese 0, top slice 3",
            "(plate_0, slice_1, cheese_0, slice_3)",
        ),
        ("washing_up", "rinse mug 0 in basin 1, then it goes on rack 2", "(mug_0, basin_1, rack_2)"),
        ("kitting", "rod 1 is fitted in tray 0 at an offset of 5 cm and 4 cm", "(rod_1, tray_0, 0.05, 0.04)"),
        ("zoning", "bring every nut into the far zone", "(nut, far)"),
        (
            "picnic",
            "mat 3 gets dish 0, and the basket for plum 0 is basket 1",
            "(dish_0, mat_3, plum_0, basket_1)",
        ),
        ("depot", "load the heavy parcels at dock 1", "(heavy, dock_1)"),
        ("depot", "handling flat to dock 2", "(flat, dock_2)"),
    ],
)
def test_fields_are_told_by_types_and_by_their_names(domain: str, text: str, meant: str) -> None:
    assert heard(domain, text) == [meant]


@pytest.mark.parametrize(
    ("task", "text", "meant"),
    [
        ("sorting", "send heavy parcels for Oslo to chute 1", ["(oslo, heavy, chute_1)"]),
        ("sorting", "chute 0 takes the light parcels going to Rome", ["(rome, light, chute_0)"]),
        ("sorting", "apply the rule city rome, load light, chute 1", ["(rome, light, chute_1)"]),
        ("filling", "put two eggs into basket 1", ["(basket_1, 2)"]),
        ("filling", "there should be one egg in basket 0", ["(basket_0, 1)"]),
        (
            "filling",
            "one egg goes into basket 0, and basket 1 gets 3 eggs",
            ["(basket_0, 1)", "(basket_1, 3)"],
        ),
    ],
)
def test_members_describe_and_numbers_count_what_no_field_names(
    task: str, text: str, meant: list[str]
) -> None:
    who, _ = in_scene(load_text(MAIL), task)
    assert lists(who, text) == meant


def test_no_clause_is_lost_beside_one_that_is_understood() -> None:
    who, _ = in_scene(load_text(MAIL), "sorting")
    with pytest.raises(NtpError, match="is not understood"):
        who.understand(["the heavy parcels are here, and chute 0 takes the light parcels for Rome"])


@pytest.mark.parametrize(
    "text",
    [
        "put basin 1 into mug 0 on rack 2",
        "put mug 0 beside basin 1 and rack 2",
        "mug 0 is between basin 1 and rack 2",
    ],
)
def test_fields_are_not_what_is_related_as_nothing_declared_is(text: str) -> None:
    with pytest.raises(NtpError):
        heard("washing_up", text)


def test_no_noun_phrase_is_dropped_from_an_element() -> None:
    with pytest.raises(NtpError):
        heard("sandwiches", "a sandwich on plate 0: bottom slice 1, filling cheese 0, top slice 3, plate 1")


def test_one_field_of_two_that_are_alike_is_not_guessed() -> None:
    who, _ = in_scene(ntp_dsl.load(DOMAINS / "sandwiches"), "sandwiches")
    with pytest.raises(NtpError, match="is not understood"):
        who.understand(["sandwich plate 0 with slice 1, cheese 0 and slice 3"])


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("guest 0 takes seat 1 and guest 3 takes seat 5", ["(guest_0, seat_1)", "(guest_3, seat_5)"]),
        (
            "guests 0, 1 and 2 sit on seats 3, 4 and 5, in that order",
            ["(guest_0, seat_3)", "(guest_1, seat_4)", "(guest_2, seat_5)"],
        ),
    ],
)
def test_who_moves_takes_the_place(text: str, meant: list[str]) -> None:
    who, _ = scene("seating")
    assert lists(who, text) == meant


def test_what_was_named_is_what_is_pointed_at() -> None:
    who, _ = scene("table_cleanup", task="three_and_three")
    told = "fork 0 goes into bowl 1, then that bowl is set on the tray"
    assert lists(who, told) == ["(fork_0, bowl_1)", "(bowl_1, tray_0)"]


def test_the_other_one_is_of_the_kind_that_has_another() -> None:
    who, _ = scene("serving")
    told = "tray 1 is meant for tea, the other one for coffee"
    assert lists(who, told) == ["(tea, tray_1)", "(coffee, tray_0)"]


@pytest.mark.parametrize(
    ("domain", "told", "meant"),
    [
        (
            "kitting",
            ["Tray 0 has nut 1 at 4 cm, 4 cm and rod 0 at minus 4 cm, 4 cm."],
            ["(nut_1, tray_0, 0.04, 0.04)", "(rod_0, tray_0, -0.04, 0.04)"],
        ),
        (
            "garden_rows",
            ["First take pot 2 to stake 0 with label 1.", "Leave a gap of 9 cm."],
            ["(pot_2, label_1, stake_0, 0.09)"],
        ),
        (
            "washing_up",
            ["rinse mug 0 in basin 1 and mug 2 in basin 2, then put them on racks 0 and 1"],
            ["(mug_0, basin_1, rack_0)", "(mug_2, basin_2, rack_1)"],
        ),
        (
            "washing_up",
            ["rinse mugs 0 and 2 in basin 1; the first goes on rack 0, the second on rack 1"],
            ["(mug_0, basin_1, rack_0)", "(mug_2, basin_1, rack_1)"],
        ),
    ],
)
def test_several_elements_are_told_in_one_sentence_and_one_in_several(
    domain: str, told: list[str], meant: list[str]
) -> None:
    who, _ = in_scene(load(DOMAINS / domain), domain)
    assert lists(who, *told) == meant


def test_words_that_are_passed_over_are_told_with_their_own_sentence() -> None:
    who, _ = in_scene(load(DOMAINS / "garden_rows"), "garden_rows")
    told = ["First take pot 2 to stake 0 with label 1.", "Quickly and gladly leave a gap of 9 cm."]
    assert (1, "gladly") in who.understand(told).passed_over


@pytest.mark.parametrize(
    "told",
    [
        "a tower of blocks 1, 2 and 3 with block 3 at the bottom and block 1 at the top",
        "a tower of block 1, block 2 and block 3 with block 3 at the bottom and block 1 at the top",
        "stack blocks 3, 2 and 1, block 3 at the bottom, block 2 in the middle and block 1 on top",
    ],
)
def test_what_stands_in_a_tower_is_told_by_its_levels(told: str) -> None:
    who, _ = scene("block_stacking")
    assert lists(who, told) == ["(block_2, block_3)", "(block_1, block_2)"]
    assert lists(who, f"{told}. Block 0 goes on block 1")[2:] == ["(block_0, block_1)"]


@pytest.mark.parametrize(
    "told",
    [
        "a tower of blocks 1, 2, 3 and 4 with block 3 at the bottom and block 1 at the top",  # 2 on 4?
        "a tower of blocks 1 and 2 with block 2 at the bottom and block 2 at the top",
        "a tower with block 3 at the bottom and blocks 1 and 2 at the top",
        "put block 3 on block 4 next to the tower with block 1 at the bottom and block 2 at the top",
    ],
)
def test_a_tower_that_leaves_an_order_open_is_refused(told: str) -> None:
    who, _ = scene("block_stacking")
    with pytest.raises(NtpError, match="not understood"):
        who.understand([told])


@pytest.mark.parametrize(
    ("told", "meant"),
    [
        ("the second one goes on block 5", "(block_2, block_5)"),
        ("the latter goes on block 5", "(block_2, block_5)"),
        ("the third goes on block 5", ""),
    ],
)
def test_an_ordinal_stands_for_one_of_those_that_were_named(told: str, meant: str) -> None:
    who, _ = scene("block_stacking")
    before = "blocks 1 and 2 go on blocks 3 and 4"
    if meant:
        assert lists(who, before, told)[2:] == [meant]
    else:
        with pytest.raises(NtpError, match="sentence 2 is not understood"):
            who.understand([before, told])


@pytest.mark.parametrize("sign", ["minus ", "-", "- ", "\u2212", "\u2212 ", "\u2013"])
def test_a_sign_is_a_sign_however_it_is_written(sign: str) -> None:
    who, _ = in_scene(load(DOMAINS / "kitting"), "kitting")
    assert lists(who, f"nut 1 goes into tray 0 at {sign}4 cm, 3 cm") == ["(nut_1, tray_0, -0.04, 0.03)"]
    with pytest.raises(NtpError, match="'minus'"):
        who.understand(["nut 1 goes into tray 0 at 4 cm minus 1 cm, 3 cm"])


@pytest.mark.parametrize(
    ("library", "text"),
    [
        ("serving", "keep tray 0 free of tea"),
        ("serving", "drink the tea and put coffee on tray 0"),
        ("block_stacking", "put block 1 on what is on block 2"),
        ("block_stacking", "put block 1 on block 2 and take it off again"),
        ("seating", "guest 0 takes guest 1's seat"),
        ("object_sorting", "toys are forbidden in bin 2"),
    ],
)
def test_what_takes_back_or_points_elsewhere_is_refused(library: str, text: str) -> None:
    who, _ = scene(library)
    with pytest.raises(NtpError):
        who.understand([text])


def test_lengths_go_to_the_sides_that_fields_are_named_for() -> None:
    who, _ = in_scene(load(DOMAINS / "sky"), "sky")
    meant = ["(star_0, pole_0, 0.05, 0.04)"]
    assert lists(who, "star 0 shines 5 cm ahead of and 4 cm to the left of pole 0") == meant
    assert lists(who, "star 0 shines 4 cm to the left and 5 cm ahead of pole 0") == meant
    with pytest.raises(NtpError, match="say how far 'left', which may be below zero"):
        who.understand(["star 0 shines 5 cm ahead of pole 0 and 4 cm to its right"])
    with pytest.raises(NtpError):  # of one length there is only one
        who.understand(["star 0 shines 5 cm ahead of pole 0"])


def test_of_places_that_are_listed_the_first_comes_first() -> None:
    who, _ = in_scene(load(DOMAINS / "bridges"), "bridges")
    assert lists(who, "lay plank 0 across pillar 1 and pillar 0") == ["(plank_0, pillar_1, pillar_0)"]
    assert lists(who, "plank 0 spans pillars 1 and 3") == ["(plank_0, pillar_1, pillar_3)"]


DISTANT = """
library distant
use tabletop
type Tent is Movable
type Fire is Place
enum Cloth: plain, waxed, oil
record Camp(tent: Tent, fire: Fire, apart: length in 8 .. 20 cm, cloth: Cloth)
predicate treated(t: Tent, c: Cloth) by state
predicate pitched(t: Tent, f: Fire, d: length, c: Cloth): d == d and on(t, f) and treated(t, c)
api treat(t: Tent, c: Cloth)
    requires empty(gripper)
    achieves treated(t, c)
program prepare(t: Tent, c: Cloth):
    achieves treated(t, c)
    put_down()
    treat(t, c)
program camp(t: Tent, f: Fire, d: length, c: Cloth):
    requires present(t) and reachable(t) and present(f) and reachable(f)
    achieves pitched(t, f, d, c)
    prepare(t, c)
    pick_and_place(t, f)
program camp_all(camps: list[Camp]):
    achieves all pitched(c.tent, c.fire, c.apart, c.cloth) for c in camps
    for c in camps:
        camp(c.tent, c.fire, c.apart, c.cloth)
task camping:
    scene:
        fires: 2 Fire on table with cylinder(4 cm, 1 cm)
        tents: 4 Tent on table with cylinder(4 cm, 5 cm)
    goal:    (tent_0, fire_0, 10 cm, plain)
    run:     camp_all(goal)
    success: all pitched(c.tent, c.fire, c.apart, c.cloth) for c in goal
"""


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("tent 1 stands 14 cm away from fire 0, plain", ["(tent_1, fire_0, 0.14, plain)"]),
        ("wax tent 1 and pitch it at a distance of 9 cm from fire 1", ["(tent_1, fire_1, 0.09, waxed)"]),
        (
            "fire 0 gets tent 2 at 9 cm, oiled, and fire 1 tent 3 at 12 cm, plain",
            ["(tent_2, fire_0, 0.09, oil)", "(tent_3, fire_1, 0.12, plain)"],
        ),
    ],
)
def test_a_length_is_from_a_place_and_a_verb_is_a_member(text: str, meant: list[str]) -> None:
    who, _ = in_scene(load_text(DISTANT), "camping")
    assert lists(who, text) == meant


@pytest.mark.parametrize(
    ("library", "text", "word"),
    [
        ("serving", "put the empty cups on tray 0", "'empty' is no trait of anything here"),
        ("block_stacking", "when block 1 is clear, put block 2 on it", "is a condition"),
    ],
)
def test_what_narrows_or_makes_a_condition_is_refused(library: str, text: str, word: str) -> None:
    who, _ = scene(library)
    with pytest.raises(NtpError, match=word):
        who.understand([text])
