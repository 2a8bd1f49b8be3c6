"""Every mistake is named and located, with what was probably meant."""

from __future__ import annotations

import pytest

from ntp_dsl.common.resources import library_folder
from ntp_dsl.language.checker import check
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, SourceError
from ntp_dsl.language.loader import diagnose_text
from ntp_dsl.language.parsing.parser import parse

TABLETOP = parse((library_folder() / "tabletop.ntp").read_text())
TASK = """task t:
    scene: blocks: 8 Block on table
    goal: towers(blocks, placements=1..6, height=2..4)
    run: build(goal)
    success: all on(p.item, p.support) for p in goal
program build(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        pick_and_place(p.item, p.support)
"""
PROGRAM = "program go(x: Object):\n    requires present(x) and reachable(x)\n    achieves holding(x)\n"
PUSH = "enum Side: left, right\napi push(x: Object, side: Side, way: length in 0 .. 0.3 m)\n"


def diagnostics(body: str) -> list[Diagnostic]:
    """Return the diagnostics of a library whose declarations begin on its third line."""
    try:
        check(parse(f"library a\nuse tabletop\n{body}"), TABLETOP)
    except SourceError as error:
        return list(error.diagnostics)
    return []


# The code of each; an `@` in the text marks where the caret must be, and is removed.
SYNTAX = {
    "a misspelt keyword": ("E002", "@progam go():\n    release()\n"),
    "an indented first line": ("E001", "type T\n  @type U\n"),
    "a missing colon": ("E001", "program go()@\n    achieves empty(gripper)\n    release()\n"),
    "a missing colon after for": ("E001", PROGRAM + "    for y in Object@\n        pick(y)\n"),
    "a missing comma": ("E001", "predicate near(x: Object @y: Object)\n"),
    "a missing type": ("E001", "predicate near(x: @)\n"),
    "an open bracket": ("E003", "predicate near@(x: Object\ntype T\n"),
    "a closing bracket too many": ("E003", "predicate near(x: Object)@)\n"),
    "an open docstring": ("E004", 'type T\n    @"""A thing.\ntype U\n'),
    "a second header": ("E005", "library @b\n"),
    "two calls in a loop": ("E006", PROGRAM + "    for y in T:\n        a(y)\n        @b(y)\n"),
    "half a block": ("E007", "task t:\n    scene: blocks: @1.5 Block on table\n"),
    "a number too large": ("E007", "task t:\n    scene: blocks: @1e40 Block on table\n"),
    "a clause twice": ("E008", "api go() requires p(x) @requires q(x)\n"),
    "a section twice": ("E008", "task t:\n    run: a()\n    @run: b()\n"),
    "a reserved name": ("E009", "predicate @all(x: Object)\n"),
    "nesting without end": ("E010", f"predicate p(): {'not ' * 10}@{'not ' * 59}q()\n"),
    "a misspelt clause": ("E001", "program go(x: T):\n    @require p(x)\n    a(x)\n"),
    "a misspelt section": ("E001", "task t:\n    @scenes: blocks: 8 Block on table\n"),
    "a character of no use": ("E001", PROGRAM + "    pick(@$x)\n"),
    "a crooked indent": ("E001", "program go(x: T):\n        achieves p(x)\n    @pick(x)\n"),
    "an indent too many": ("E001", "program go(x: T):\n    achieves p(x)\n        @pick(x)\n"),
}
PAIR = "record Pair(a: Object, b: Object)\npredicate fit(p: Pair) by python\n"
MEANING = {
    "an unknown type": ("E103", "predicate near(x: @Objct)\n"),
    "an unknown parent": ("E103", "type Cup is @Movabel\n"),
    "an unknown name": ("E101", PROGRAM + "    pick(@y)\n"),
    "an unknown list": ("E101", PROGRAM + "    for y in @golas:\n        pick(y)\n"),
    "an unknown predicate": ("E102", "predicate near(x: Object): @onn(x, table)\n"),
    "a program as a condition": ("E102", "predicate near(x: Object): @pick_and_place(x, table)\n"),
    "an unknown callee": ("E104", PROGRAM + "    @pik(x)\n"),
    "a call of a predicate": ("E104", PROGRAM + "    @holding(x)\n"),
    "an unknown field": ("E105", TASK.replace("p.item, p.support)\n", "p.@itm, p.support)\n")),
    "an unknown group": ("E106", TASK.replace("towers(blocks", "towers(@bloks")),
    "an unknown unit": ("E107", PUSH + PROGRAM + "    pick(x)\n    push(x, left, 3 @ft)\n"),
    "an unknown sampler": ("E108", TASK.replace("towers(", "@twoers(")),
    "an unknown option": ("E109", TASK.replace("height=", "@hight=")),
    "too few arguments": ("E201", PROGRAM + "    @pick()\n"),
    "too many arguments": ("E201", "predicate near(x: Object): @on(x, x, x)\n"),
    "a table to pick": ("E202", PROGRAM + "    pick(@table)\n"),
    "a list to pick": ("E202", TASK.replace("pick_and_place(p.item", "pick_and_place(@goal")),
    "a number for a side": ("E202", PUSH + PROGRAM + "    pick(x)\n    push(x, @3, 3 cm)\n"),
    "a length out of range": ("E203", PUSH + PROGRAM + "    pick(x)\n    push(x, left, @40 cm)\n"),
    "a range upside down": ("E203", "api pull(way: length in @3 .. 1 m)\n"),
    "an angle for a length": ("E202", PUSH + PROGRAM + "    pick(x)\n    push(x, left, @3 deg)\n"),
    "metres of an angle": ("E204", "api turn(by: angle in 0 .. @3 m)\n"),
    "a thing as a condition": ("E205", "predicate near(x: Object): clear(x) and @x\n"),
    "a truth as a thing": ("E205", PROGRAM + "    pick(@clear(x))\n"),
    "a loop over one thing": ("E206", PROGRAM + "    for y in @x:\n        pick(y)\n"),
    "a call with any": ("E207", PROGRAM + "    pick(@any)\n"),
    "any record": ("E207", PAIR + "predicate odd(x: Object): fit(@any)\n"),
    "any length": ("E207",
        "predicate near(x: Object, by: length) by python\npredicate odd(x: Object): near(x, @any)\n"),
    "a reading of any": ("E207",
        "enum Side: left, right\npredicate side(x: Object) -> Side\n"
        "predicate odd(x: Object): side(x) == side(@any)\n"),
    "a thing like a number": ("E208", "predicate near(x: Object): @x == 3\n"),
    "a program twice": ("E301",
        PROGRAM + "    pick(x)\n" + PROGRAM.replace("go", "@go") + "    pick(x)\n"),
    "a member twice": ("E301", "enum Side: left, @left\n"),
    "a clash with a used library": ("E302",
        "program @pick(x: Object):\n    achieves clear(x)\n    clear(x)\n"),
    "a type of itself": ("E303", "type Cup is @Cup\n"),
    "a parameter twice": ("E305", "predicate near(x: Object, @x: Object)\n"),
    "a variable twice": ("E306",
        PROGRAM + "    for @x in Object if on(x, table):\n        pick(x)\n"),
    "no achieves": ("E401", "program @go(x: Object):\n    clear(x)\n"),
    "an api without achieves first": ("E402",
        PUSH + PROGRAM + "    @push(x, left, 3 cm)\n    pick(x)\n"),
    "a requirement from nowhere": (
        "E403", "program go(x: Object):\n    requires present(x) and reachable(x)\n"
        "    achieves clear(x)\n    move_to(x)\n    clear(x)\n    @grasp(x)\n"),
    "a fact required too low": ("E403", "program go(x: Movable):\n    requires present(x)\n"
                                "    achieves holding(x)\n    @pick(x)\n"),
    "recursion without a loop": ("E404", PROGRAM + "    pick(x)\n    @go(x)\n"),
    "recursion that stays": ("E404",
        PROGRAM + "    for y in Object if on(y, x):\n        @go(x)\n    pick(x)\n"),
    "no call": ("E405", "program @go(x: Object):\n    achieves clear(x)\n"),
    "a predicate of itself": ("E407", "predicate @near(x: Object): near(x) and clear(x)\n"),
    "no success": ("E501", TASK.replace("task t", "task @t").replace(
        "    success: all on(p.item, p.support) for p in goal\n", "")),
    "an empty goal": ("E502", TASK.replace("placements=1", "@placements=0")),
    "a tower of one": ("E502", TASK.replace("height=2", "@height=1")),
    "a range of nothing": ("E502", TASK.replace("placements=1..6", "@placements=6..1")),
    "too few blocks": ("E502", TASK.replace("placements=1..6", "@placements=1..7")),
    "too few placements": ("E502",
        TASK.replace("placements=1..6", "@placements=1..6").replace("=2..4", "=4")),
    "no option": ("E502", TASK.replace("towers(", "@towers(").replace(", height=2..4", "")),
    "no blocks": ("E502", TASK.replace("blocks: 8", "@blocks: 0")),
    "a list of blocks as a goal": ("E202", TASK.replace("build(goal)\n", "build(@blocks)\n")),
    "an api as a root": ("E503", TASK.replace("build(goal)\n", "@release()\n")),
}  # fmt: skip


@pytest.mark.parametrize("name", [*SYNTAX, *MEANING])
def test_a_mistake_is_named_and_located(name: str) -> None:
    code, text = {**SYNTAX, **MEANING}[name]
    before = text[: text.index("@")]
    place = before.count("\n") + 3, len(before) - (before.rfind("\n") + 1) + 1
    found = [(each.code, each.span.line, each.span.column) for each in diagnostics(text.replace("@", ""))]
    assert (code, *place) in found
    assert name in {"no blocks", "an open docstring"} or len({row[1] for row in found}) == 1, found


def test_every_syntax_error_is_reported_at_once() -> None:
    text = "".join(text.replace("@", "") for _, text in SYNTAX.values() if '"""' not in text)
    codes = [each.code for each in diagnostics(text)]
    assert len(codes) >= len(SYNTAX) - 1


def test_an_error_lists_every_mistake_with_its_place() -> None:
    with pytest.raises(SourceError) as caught:
        check(parse("library a\nuse tabletop\ntype Cup is Movabel\ntype Lid is Cop\n", "a.ntp"), TABLETOP)
    assert str(caught.value).split("\n") == [
        "a.ntp:3:13: error[E103]: there is no type 'Movabel'; did you mean 'Movable'?",
        "a.ntp:4:13: error[E103]: there is no type 'Cop'; did you mean 'Cup'?",
    ]


def test_a_near_name_comes_with_a_fix() -> None:
    (mistake,) = diagnostics("type Cup is Movabel\n")
    assert mistake.fix is not None
    assert (mistake.fix.replacement, mistake.fix.span) == ("Movable", mistake.span)


@pytest.mark.parametrize(
    "body",
    [
        TASK,
        PROGRAM + "    pick(x)\n",
        PUSH + PROGRAM + "    pick(x)\n    push(x, right, 3 cm)\n",
        "predicate free(x: Place): not some on(o, x) for o in Object\n",
        "program unload(x: Place):\n    achieves not some on(o, x) for o in Object\n"
        "    for o in Object if on(o, x):\n        pick_and_place(o, table)\n",
    ],
)
def test_a_sound_library_raises_no_alarm(body: str) -> None:
    assert diagnostics(body) == []


def test_a_count_that_is_a_parameter_is_told_to_be_a_number_of_the_text() -> None:
    text = "library a\nuse tabletop\nprogram p(n: number):\n    achieves {} n on(b, table) for b in Block\n"
    for words in ("at least", "exactly"):
        (found,) = [each for each in diagnose_text(text.format(words)).diagnostics if each.code == "E001"]
        assert found.message == "expected a number, found 'n'" and "cannot be a parameter" in found.help
