"""Goals in so many words, objects by name, facts at the start: what may be written, and what is wrong."""

from __future__ import annotations

import pytest

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.loader import diagnose_text
from ntp_dsl.language.parsing.parser import parse
from ntp_dsl.language.syntax.formatter import declaration_rows
from ntp_dsl.language.syntax.nodes import GivenGoal, TaskDeclaration

HEAD = """library shelf
use tabletop

type Shelf is Place
type Jar is Movable
enum Label: tea, salt
record Filling(jar: Jar, label: Label)
predicate open(s: Shelf) by state
predicate labelled(j: Jar, what: Label) by state

api write(j: Jar, what: Label)
    requires holding(j)
    achieves labelled(j, what)

program fill(goal: list[Filling]):
    achieves all labelled(f.jar, f.label) for f in goal
    for f in goal:
        label(f.jar, f.label)

program label(j: Jar, what: Label):
    requires present(j) and reachable(j)
    achieves labelled(j, what)
    pick(j)
    write(j, what)

program build(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        pick_and_place(p.item, p.support)

"""
SCENE = """    scene:
        tea_jar: Jar on table
        jars:    2 Jar on table
        board:   Shelf on table
"""
SOUND = {
    "a goal, of objects by their names": "    goal: (tea_jar, board), (jar_0, tea_jar), (jar_1, jar_0)\n"
    "    run: build(goal)\n    success: all on(p.item, p.support) for p in goal\n",
    "a goal on lines of its own": "    goal:\n        (tea_jar, board)\n        (jar_0, tea_jar),\n"
    "    run: build(goal)\n    success: all on(p.item, p.support) for p in goal\n",
    "a goal with members": "    goal: (jar_1, salt), (tea_jar, tea)\n"
    "    run: fill(goal)\n    success: all labelled(f.jar, f.label) for f in goal\n",
    "no goal": "    run: pick_and_place(tea_jar, board)\n    success: on(tea_jar, board)\n",
    "facts of objects and of a group": "    initially: open(board), labelled(jars, salt)\n"
    "    run: pick_and_place(tea_jar, board)\n    success: on(tea_jar, board)\n",
}
WRONG = {  # an `@` marks where the caret must be
    "a row that is too short": ("E201", "    goal: @(tea_jar)\n    run: build(goal)\n"),
    "an object of another type": ("E202", "    goal: (@board, tea)\n    run: fill(goal)\n"),
    "an unknown object": ("E101", "    goal: (tea_jra, @board_0)\n    run: build(goal)\n"),
    "a number in the place of an object": ("E202", "    goal: (tea_jar, @3 cm)\n    run: build(goal)\n"),
    "a goal that nothing takes": ("E502", "    goal: @(tea_jar, board)\n    run: pick(tea_jar)\n"),
    "no goal where one is run": ("E501", "    run: build(goal)\n"),
    "a fact that is not of the state": (
        "E504",
        "    initially: @on(tea_jar, board)\n    run: pick_and_place(tea_jar, board)\n",
    ),
    "a fact that does not hold": (
        "E504",
        "    initially: open(board), @not labelled(tea_jar, tea)\n    run: pick_and_place(tea_jar, board)\n",
    ),
    "a fact of any object": (
        "E205",
        "    initially: open(@any)\n    run: pick_and_place(tea_jar, board)\n",
    ),
    "a goal of what is no record": (
        "E103",
        "    goal: (tea_jar, board) -> list[@Jar]\n    run: build(goal)\n",
    ),
    "a fact of an object of another type": (
        "E202",
        "    initially: open(@tea_jar)\n    run: pick_and_place(tea_jar, board)\n",
    ),
}


def diagnosed(sections: str, scene: str = SCENE) -> list[Diagnostic]:
    return list(diagnose_text(f"{HEAD}task t:\n{scene}{sections}").diagnostics)


@pytest.mark.parametrize("name", SOUND)
def test_what_is_given_is_sound(name: str) -> None:
    assert [each.message for each in diagnosed(SOUND[name]) if each.severity == "error"] == []


@pytest.mark.parametrize("name", SOUND)
def test_what_is_given_is_formatted_to_what_it_means(name: str) -> None:
    parsed = parse(f"{HEAD}task t:\n{SCENE}{SOUND[name]}")
    task = parsed.declarations[-1]
    text = "\n".join(" " * row.indent + row.text for row in declaration_rows(task))
    assert parse(f"library again\n{text}\n").declarations == (task,)


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_named_where_it_is(name: str) -> None:
    code, text = WRONG[name]
    before = f"{HEAD}task t:\n{SCENE}{text}".partition("@")[0]
    found = diagnosed(f"{text.replace('@', '')}    success: present(tea_jar)\n")
    assert code in {each.code for each in found}
    if "@" in text:
        line, column = before.count("\n") + 1, len(before.rpartition("\n")[2]) + 1
        assert (line, column) in {(each.span.line, each.span.column) for each in found if each.code == code}


SHARED = {
    "the scene": "    scene: as base\n",
    "other numbers": "    scene: as base with\n        jars: 3..5\n",
    "another group in its place, and one more": "    scene: as base with\n"
    "        board: Shelf on table with box(9 cm, 9 cm, 1 cm)\n        lid: Jar on table\n",
}


@pytest.mark.parametrize("name", SHARED)
def test_a_scene_may_be_that_of_a_task_above(name: str) -> None:
    rest = "    run: pick_and_place(tea_jar, board)\n    success: on(tea_jar, board)\n"
    base = f"task base:\n{SCENE}    initially: open(board)\n{rest}"
    text = f"{HEAD}{base}task t:\n{SHARED[name]}{rest}"
    report = diagnose_text(text)
    assert [each.message for each in report.diagnostics if each.severity == "error"] == []
    first, second = parse(text).declarations[-2:]
    assert isinstance(first, TaskDeclaration) and isinstance(second, TaskDeclaration)
    assert second.facts == first.initially
    names = [group.name for group in second.scene]
    assert names[:3] == [group.name for group in first.scene]
    rows = [" " * row.indent + row.text for each in (first, second) for row in declaration_rows(each)]
    assert parse("library again\n" + "\n".join(rows) + "\n").declarations == (first, second)


@pytest.mark.parametrize(
    ("scene", "code"),
    [
        ("as bsae", "E101"),
        ("as t", "E101"),
        ("as base with\n        jras: 3", "E106"),
        ("as base with\n        jars: 3\n        jars: 4", "E305"),
        ("as base with\n        jars: 4..3", "E502"),
        ("as base with\n        jar_0: Jar on table", "E305"),
    ],
)
def test_a_scene_that_cannot_be_shared_is_named(scene: str, code: str) -> None:
    rest = "    run: pick_and_place(tea_jar, board)\n    success: on(tea_jar, board)\n"
    text = f"{HEAD}task base:\n{SCENE}{rest}task t:\n    scene: {scene}\n{rest}"
    assert code in {each.code for each in diagnose_text(text).diagnostics}


def test_a_goal_of_many_rows_stands_on_lines_of_its_own() -> None:
    rows = ", ".join(f"(jar_{n}, jar_{n + 1})" for n in range(6))
    [task] = parse(f"library a\ntask t:\n    goal: {rows}\n").declarations
    assert isinstance(task, TaskDeclaration) and isinstance(task.goal, GivenGoal)
    assert len(declaration_rows(task)) == 2 + 6


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("predicate heat(s: Shelf) -> number by state", "E112"),
        ("predicate far(s: Shelf, way: length) by state", "E202"),
        ("predicate all_open(s: list[Shelf]) by state", "E202"),
    ],
)
def test_what_is_of_the_state_is_true_or_false_of_objects_and_members(line: str, code: str) -> None:
    assert code in {each.code for each in diagnose_text(f"{HEAD}{line}\n").diagnostics}


@pytest.mark.parametrize("groups", ["jars: 2 Jar", "jars: 1..2 Jar", "jar_1: 2 Jar"])
def test_an_object_may_not_have_the_name_of_a_numbered_one(groups: str) -> None:
    scene = f"    scene:\n        {groups} on table\n        jar_1: Jar on table\n"
    found = diagnosed("    run: pick(jar_1)\n    success: holding(jar_1)\n", scene)
    assert "E305" in {each.code for each in found}
