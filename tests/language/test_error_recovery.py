"""All mistakes are found in one run: sound declarations are checked, and no errors follow from others."""

from __future__ import annotations

from pathlib import Path

import pytest

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.loader import diagnose

GO = "program go(x: Object):\n    requires present(x) and reachable(x)\n    achieves holding(x)\n"


def diagnosed(folder: Path, text: str) -> list[Diagnostic]:
    (folder / "a.ntp").write_text(f"library a\nuse tabletop\n{text}")
    return list(diagnose(folder / "a.ntp").diagnostics)


def marked(text: str) -> tuple[str, list[tuple[int, int]]]:
    """Return the text without its `@`, and their lines and columns, below a header of two lines."""
    places, plain = [], ""
    for part in text.split("@"):
        plain += part
        places.append((plain.count("\n") + 3, len(plain) - plain.rfind("\n")))
    return plain, places[:-1]


# An `@` marks where each mistake begins; there are no others.
SEVERAL = {
    "every line of a body": GO + "    pick(x @x)\n    pick(x) @pick(x)\n    @pik(x)\n    pick(@y)\n",
    "syntax and meaning in two declarations": "type Cup is@\n" + GO + "    @pik(x)\n",
    "a misspelt keyword, and a name in its body": "@progam" + GO[7:] + "    @pik(x)\n",
    "two misspelt clauses": "program go(x: Object):\n    @require present(x) and reachable(x)\n"
    "    @achieve holding(x)\n    pick(x)\n",
    "names to the right of a misspelt word": "program go(x: Object):\n    @require presnt(x)\n"
    .replace("presnt", "@presnt") + "    achieves clear(x)\n    clear(x)\n",
    "a missing colon, and a name below it": GO + "    for y in Object if on(y, x)@\n        @pik(y)\n"
    "    pick(x)\n",
    "a broken first line and a broken body": "program go(x Object):\n    achieves clear(x)\n"
    .replace("x Object", "x @Object") + "    clear(x @x)\n",
    "sections of a task": "task t:\n    @scenes: blocks: 8 @Blok on table\n    @gaol: towers(blocks, "
    "placements=1..6, height=2..4)\n    @xyz: 3\n    run: @stak(goal)\n    success: @onn(table, table)\n",
    "lines at the margin": "program go(x: Object):\n@achieves clear(x)\nclear(x)\n@pik(x)\n".replace(
        "clear(x)\n@pik", "@pik"
    ),
    "a line too far in": GO + "    pick(x)\n        @pick(x)\n    @pik(x)\n",
    "a call that cannot be read": GO + "    for y in Object:\n        pick(y @y)\n    @pik(x)\n",
}  # fmt: skip


@pytest.mark.parametrize("name", SEVERAL)
def test_no_mistake_hides_another(name: str, tmp_path: Path) -> None:
    text, places = marked(SEVERAL[name])
    found = [(each.span.line, each.span.column) for each in diagnosed(tmp_path, text)]
    assert found == places


# What is broken is reported once, and what refers to it not at all.
BROKEN = {
    "a type": "type Cup is@\ntype Mug is Cup\n" + GO + "    pick(x)\nprogram wash(c: Mug):\n"
    "    requires present(c) and reachable(c)\n    achieves holding(c)\n    pick(c)\n",
    "an enumeration": "enum Side @left, right\napi turn(x: Object, s: Side)\n" + GO
    + "    pick(x)\n    turn(x, left)\n",
    "a record": "record Pair(a: Object @b: Object)\npredicate same(p: Pair): on(p.a, p.b)\n",
    "a constant": "constant shelf@ Place\npredicate bare(): clear(shelf)\n".replace("@ ", " @"),
    "a predicate": "predicate full(x @Object)\n" + GO.replace("present(x)", "present(x) and full(x)")
    + "    pick(x)\n",
    "a composition": "predicate full(x: Object): on(x, table) and@\napi fill(x: Object)\n"
    "    requires full(x)\n    achieves clear(x)\n" + GO + "    fill(x)\n    pick(x)\n",
    "a program": "program help(x @Object):\n    achieves clear(x)\n    clear(x)\n" + GO
    + "    help(x)\n    grasp(x)\n",
    "a line of a program": "program help(x: Object):\n    achieves clear(x @x)\n    clear(x)\n" + GO
    + "    help(x)\n    grasp(x)\n",
    "a docstring": 'api zap(x: Object)\n    @"""Never closed.\n    achieves clear(x)\ntype Cup\n' + GO
    + "    zap(x)\n    pick(x)\npredicate hot(c: Cup)\n",
    "a scene": "task t:\n    scene: blocks@ 8 Block on table\n    goal: towers(blocks, placements=1..6, "
    "height=2..4)\n    run: stack(goal)\n    success: all on(p.item, p.support) for p in goal\n"
    .replace("@ ", " @") + "program stack(goal: list[Placement]):\n"
    "    achieves all on(p.item, p.support) for p in goal\n    for p in goal:\n"
    "        pick_and_place(p.item, p.support)\n",
    "a use": "use @3things\n" + GO + "    lift(x, hard)\n",
    "a library that is not there": "use @completely_elsewhere\n" + GO + "    lift(x, hard)\n",
    "a word that begins nothing": GO + "    pick(x)\n@gadget Cup(size: length)\npredicate full(c: Cup)\n",
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_nothing_follows_from_what_is_broken(name: str, tmp_path: Path) -> None:
    text, places = marked(BROKEN[name])
    found = diagnosed(tmp_path, text)
    assert [(each.span.line, each.span.column) for each in found] == places, found


def test_mistakes_of_all_files_come_together_of_form_and_of_meaning(tmp_path: Path) -> None:
    (tmp_path / "b.ntp").write_text("library b\nuse tabletop\ntype Cup is Movabel\ntype is\n")
    codes = {each.code for each in diagnosed(tmp_path, "use b\ntype Mug is Cpu\nenum E a\n")}
    assert codes == {"E001", "E103"}


def test_the_fix_of_lines_at_the_margin_indents_them_all(tmp_path: Path) -> None:
    (mistake,) = diagnosed(tmp_path, "program go(x: Object):\nachieves clear(x)\n\nclear(x)\n")
    assert mistake.fix is not None
    assert [(each.span.line, each.replacement) for each in mistake.fix.edits] == [(4, "    "), (6, "    ")]
