"""Sentences become the lists that a program is called with, whatever its names are."""

from __future__ import annotations

import pytest
from listening import COLOURED, example, in_scene, lists, scene

import ntp_dsl
from ntp_dsl.datasets.wording import in_words
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.libraries import load_text
from ntp_dsl.sentences.understanding import SURE_ENOUGH

IN_ORDER = """put {a} on {b}; place {a} onto {b}; {a} goes on {b}; {a} belongs on top of {b}
{a} should end up on {b}; bring {a} to {b}; take {a} and put it on {b}; grab {a}, then set it down on {b}
please let {a} stand on {b}; could you put {a} atop {b}?; {a} on {b}; I'd like {a} to be on {b}
see to it that {a} rests on {b}; the right place for {a} is {b}; pick up {a}. Put it on {b}."""
INVERTED = """{b} carries {a}; on {b} put {a}; {b} is where {a} goes; top {b} with {a}; {b} has {a} on it
what {a} stands on is {b}; let {b} hold {a}; {b} is under {a}; use {b} as the base of {a}
{a} is carried by {b}; {b} has {a} on top of it
{b} with {a} on top; give {b} {a}; on top of {b}, place {a}; {b} is for {a}; {b} serves as a stand for {a}
find {b}. Put {a} on top of it.; {b}, and on it {a}; the one on top of {b} has to be {a}"""


def each(texts: str) -> list[str]:
    return [text.strip() for row in texts.splitlines() for text in row.split(";")]


@pytest.mark.parametrize("template", [*each(IN_ORDER), *each(INVERTED)])
@pytest.mark.parametrize(("a", "b"), [("block 3", "block 5"), ("block_5", "Block 3")])
def test_what_stands_on_what_is_told_by_grammar_and_not_by_order(template: str, a: str, b: str) -> None:
    who, _ = scene("block_stacking")
    said = who.understand([template.format(a=a, b=b)])
    names = [each.lower().replace(" ", "_") for each in (a, b)]
    assert [str(each.element) for each in said.choices] == [f"({names[0]}, {names[1]})"]
    assert said.choices[0].probability > SURE_ENOUGH and not said.passed_over


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("put block 1 on block 2 and block 3 on block 1", ["(block_1, block_2)", "(block_3, block_1)"]),
        (
            "block 2 carries block 1, and block 1 carries block 3",
            ["(block_1, block_2)", "(block_3, block_1)"],
        ),
        (
            "first block 1 goes on block 2, then block 3 on block 1",
            ["(block_1, block_2)", "(block_3, block_1)"],
        ),
        ("put block 1 and block 3 on block 2 and block 4", ["(block_1, block_2)", "(block_3, block_4)"]),
        ("top block 2 with block 1 and block 1 with block 3", ["(block_1, block_2)", "(block_3, block_1)"]),
    ],
)
def test_one_sentence_may_say_several_things(text: str, meant: list[str]) -> None:
    who, _ = scene("block_stacking")
    assert lists(who, text) == meant


def test_sentences_of_any_level_belong_to_one_element() -> None:
    who, _ = scene("block_stacking")
    assert lists(who, "get block 1 into the hand", "put it on block 2") == ["(block_1, block_2)"]


def test_what_two_objects_are_may_be_told_by_their_types_alone() -> None:
    who, _ = scene("seating")
    assert lists(who, "seat 2: guest 1") == lists(who, "guest 1 seat 2") == ["(guest_1, seat_2)"]


@pytest.mark.parametrize(
    "text",
    [
        "all toys go into bin 2",
        "put every toy into bin 2",
        "bin 2 is for the toys",
        "bin 2 should hold all toys",
    ],
)
def test_a_kind_is_a_member_of_an_enumeration(text: str) -> None:
    who, _ = scene("object_sorting", task="object_sorting")
    assert lists(who, text) == ["(toy, bin_2)"]


def test_one_of_a_kind_stands_for_all_of_it_where_the_list_is_of_kinds() -> None:
    who, drawn = scene("object_sorting", task="object_sorting")
    toy = next(obj.name for obj in drawn.objects if ("category", "toy") in obj.traits)
    assert lists(who, f"put {toy} into bin 1") == ["(toy, bin_1)"]


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("put the red cup on tray 1", ["(cup_0, tray_1)"]),
        ("put the red one on tray 1", ["(cup_0, tray_1)"]),
        ("put the blue cups on tray 0", ["(cup_2, tray_0)", "(cup_3, tray_0)"]),
        ("put the large cup on tray 0", ["(cup_0, tray_0)"]),
        ("put cups 1 and 3 on tray 0", ["(cup_1, tray_0)", "(cup_3, tray_0)"]),
        (
            "the green cup goes on tray 0 and the red one on the other tray",
            ["(cup_1, tray_0)", "(cup_0, tray_1)"],
        ),
    ],
)
def test_noun_phrases_are_of_types_traits_sizes_and_numbers(text: str, meant: list[str]) -> None:
    who, _ = scene("coloured")
    assert lists(who, text) == meant


def test_an_object_that_may_be_one_of_two_is_in_doubt_and_one_that_may_not_is_none() -> None:
    who, _ = scene("coloured")
    [doubtful] = who.understand(["put a blue cup on tray 1"]).choices
    assert doubtful.probability < SURE_ENOUGH and [str(e) for e, _ in doubtful.others] == ["(cup_3, tray_1)"]
    [certain] = who.understand(["put the red cup on tray 1"]).choices
    assert certain.probability > 0.95


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("wash the red cup", "dirty"),
        ("rinse cup 0", "dirty"),
        ("dry the red cup", "wet"),
        ("towel cup 0", "wet"),
    ],
)
def test_a_verb_or_one_much_like_it_tells_which_list_is_meant(text: str, meant: str) -> None:
    who, _ = scene("washing")
    [choice] = who.understand([text]).choices
    assert (choice.parameter, choice.element) == (meant, "cup_0") and choice.probability > SURE_ENOUGH


def test_no_name_of_a_library_steers_how_it_is_understood() -> None:
    renamed = COLOURED
    for old, new in (("tidy", "zrtk"), ("Move", "Qx"), ("moves", "qs"), ("colour", "hue"), ("Colour", "Hue")):
        renamed = renamed.replace(old, new)
    who, _ = in_scene(load_text(renamed), "zrtk")
    for text in ("the green cup goes on tray 1", "tray 0 carries the red cup"):
        assert lists(who, text) == lists(scene("coloured")[0], text)


def test_the_order_of_objects_and_of_sentences_does_not_matter() -> None:
    told = ["put block 1 on block 2", "block 3 carries block 4", "block 5 belongs on block 1"]
    who, _ = scene("block_stacking")
    assert sorted(lists(who, *told)) == sorted(lists(who, *reversed(told)))


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("put the gherkin on block 2", "'gherkin'"),
        ("do not put block 1 on block 2", "'not'"),
        ("paint block 1", "'paint'"),
        ("put block 1 under the table", "no step or effect of 'stack' matches"),
        ("put block 9 on block 1", "there is no 'block 9'"),
        ("put block 1 beside block 2", "no step or effect of 'stack' matches"),
        ("remove block 1 from block 2", "'remove'"),
        ("take block 1 off block 2", "no step or effect of 'stack' matches"),
        ("avoid putting block 1 on block 2", "'avoid'"),
        ("no block goes on block 2", "'no'"),
        ("put everything but block 1 on block 2", "'but'"),
        ("put most blocks on block 2", "'most'"),
        ("put block 1 or block 3 on block 2", "'or'"),
        ("is block 1 on block 2?", "'is'"),
        ("blocks 1, 2 and 3 go on blocks 4 and 5", "no step or effect of 'stack' matches"),
        ("bitte lege block 1 auf block 2", "'auf'"),
        ("put block 1 on block 2 " * 40, "words: say it in several"),
        ("", "it names no object"),
    ],
)
def test_what_is_not_understood_is_named(text: str, word: str) -> None:
    who, _ = scene("block_stacking")
    with pytest.raises(NtpError, match="sentence 1") as caught:
        who.understand([text])
    assert word in str(caught.value)


@pytest.mark.parametrize(
    "text",
    ["put the tray in the guest", "seat 1 on guest 2", "guest 1 leaves seat 2", "guest 1 hates seat 2"],
)
def test_types_do_not_make_good_what_grammar_denies(text: str) -> None:
    who, _ = scene("seating")
    with pytest.raises(NtpError):
        who.understand([text])


def test_of_a_count_it_is_asked_which_are_meant() -> None:
    who, _ = scene("coloured")
    found = who.understand(["put two cups on tray 1"])
    assert len(found.choices) == 2 and found.probability < SURE_ENOUGH
    assert lists(who, "put two blue cups on tray 1") == ["(cup_2, tray_1)", "(cup_3, tray_1)"]


def test_what_is_got_first_and_told_of_later_is_one_thing() -> None:
    who, _ = scene("block_stacking")
    assert lists(who, "get block 2.", "block 1 goes on it") == ["(block_1, block_2)"]
    assert lists(who, "put block 1 on block 2 and block 3 on it") == [
        "(block_1, block_2)",
        "(block_3, block_1)",
    ]
    assert lists(who, "move block 1 from the table to block 3") == ["(block_1, block_3)"]
    tower = ["(block_5, block_3)", "(block_7, block_5)"]
    assert sorted(lists(who, "from bottom to top: block 3, block 5, block 7")) == tower
    assert sorted(lists(who, "block 7 on block 5 on block 3")) == tower


def test_a_word_that_is_passed_over_is_told() -> None:
    who, _ = scene("block_stacking")
    assert who.understand(["put block 1 jubilantly on block 2"]).passed_over == ((0, "jubilantly"),)


@pytest.mark.parametrize(
    "name",
    ["block_stacking", "seating", "table_cleanup", "object_sorting", "set_the_table", "serving", "blueprint"],
)
@pytest.mark.parametrize("seed", [1, 2])
def test_what_a_demonstration_shows_comes_back_from_its_own_words(name: str, seed: int) -> None:
    registry = example(name)
    shown = ntp_dsl.demonstrate(ntp_dsl.draw(registry, name, seed))
    assert shown.calls is not None
    who, drawn = in_scene(registry, name, seed)
    found = who.understand(in_words(registry, shown.calls))
    for got, wanted in zip(found.arguments, drawn.arguments, strict=True):
        assert isinstance(got, tuple) and isinstance(wanted, tuple) and {*got} == {*wanted}
    assert found.probability > SURE_ENOUGH


def test_a_library_may_word_its_calls_itself() -> None:
    worded = COLOURED.replace(
        "        pick_and_place(m.cup, m.tray)\n",
        "        serve(m.cup, m.tray)\nprogram serve(cup: Cup, tray: Tray):\n"
        '    says "treat {tray} to {cup}"\n'
        "    requires present(cup) and reachable(cup) and present(tray) and reachable(tray)\n"
        "    achieves on(cup, tray)\n    pick_and_place(cup, tray)\n",
    )
    who, _ = in_scene(load_text(worded), "tidy")
    assert lists(who, "treat tray 1 to the red cup") == ["(cup_0, tray_1)"]
