"""`ntp graph`: the call graph in the terminal and as a picture without overlaps."""

from __future__ import annotations

import re
from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree

import pytest

from ntp_dsl.cli.app import run
from ntp_dsl.common.resources import examples_folder
from ntp_dsl.graph.calls import call_graph
from ntp_dsl.graph.layers import place
from ntp_dsl.graph.svg import draw
from ntp_dsl.language.loader import load
from ntp_dsl.language.registry import Registry

EXAMPLES = sorted(path.parent.name for path in examples_folder().glob("*/*.ntp"))
SVG = "{http://www.w3.org/2000/svg}"


def test_edges_have_the_loops_of_calls(stacking: Registry) -> None:
    graph = call_graph(stacking)
    assert ("task block_stacking", "stack", "") in graph.edges
    assert ("stack", "pick_and_place", "for p in goal") in graph.edges
    assert ("clear", "pick", "for b in Object if covers(b, item)") in graph.edges
    assert graph.node("grasp").contract[1] == "achieves holding(target)"
    assert {root.kind for root in graph.roots()} == {"task"}


def test_one_program_can_be_selected(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["graph", "block_stacking", "--program", "place", "--list"]) == 0
    names = re.findall(r"^(?:program|api) +(\w+)", capsys.readouterr().out, re.MULTILINE)
    assert names == ["place", "move_to", "release"]
    assert run(["graph", "block_stacking", "--program", "plce"]) == 2
    assert "has no program 'plce'; did you mean 'place'?" in capsys.readouterr().err


def test_the_tree_shows_contracts_docstrings_and_recursion(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["graph", "block_stacking"]) == 0
    out = capsys.readouterr().out
    assert "requires present(item) and reachable(item)" in out
    assert "Take away what rests on the item." in out and "clear(item: Place)  ↺ recursive" in out
    assert "for p in goal: pick_and_place(" in out


def test_a_library_without_tasks_shows_all_its_programs(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["graph", "tabletop", "--list"]) == 0
    named = set(re.findall(r"^\w+ +(\w+)", capsys.readouterr().out, re.MULTILINE))
    assert named == {*load("tabletop").programs, *load("tabletop").apis}


@pytest.mark.parametrize("name", EXAMPLES)
def test_no_box_of_the_picture_covers_another(name: str, tmp_path: Path) -> None:
    out = tmp_path / "pictures" / "calls.svg"
    assert run(["graph", name, "--out", str(out)]) == 0
    page = ElementTree.parse(out).getroot()
    boxes = [
        [float(each.get(side, 0)) for side in ("x", "y", "width", "height")]
        for each in page.iter(f"{SVG}rect")
        if "box" in each.get("class", "")
    ]
    assert len(boxes) == len(call_graph(load(name)).nodes)
    for (x, y, w, h), (u, v, width, height) in combinations(boxes, 2):
        assert x + w <= u or u + width <= x or y + h <= v or v + height <= y
    right, bottom = (float(page.get(side, 0)) for side in ("width", "height"))
    assert all(x >= 0 and y >= 0 and x + w <= right and y + h <= bottom for x, y, w, h in boxes)


def test_the_picture_is_self_contained_with_a_dark_theme(stacking: Registry) -> None:
    text = draw(call_graph(stacking))
    assert "prefers-color-scheme: dark" in text and "href" not in text
    assert text.count("line back") == 1 and "covers(b, item)" in text
    assert draw(call_graph(stacking)) == text


def test_texts_of_a_library_cannot_break_the_picture(tmp_path: Path) -> None:
    path = tmp_path / "a.ntp"
    path.write_text(
        'library a\nuse tabletop\nprogram go(x: Object):\n    """<b> & \\"c\\"."""\n'
        "    achieves clear(x)\n    for b in Object if covers(b, x): go(b)\n    clear(x)\n"
    )
    text = draw(call_graph(load(path), "go"))
    assert ElementTree.fromstring(text).tag == f"{SVG}svg" and "line back" in text


def test_callers_are_above_callees_except_in_cycles() -> None:
    edges = [("a", "b"), ("b", "c"), ("c", "a"), ("a", "c"), ("a", "d")]
    placed = place(dict.fromkeys("abcd", 10.0), edges, last="d")
    assert [placed.ranks[each] for each in "abcd"] == [0, 1, 2, 3]
    assert ("a", "c") in placed.routes and ("c", "a") not in placed.routes
    assert len(placed.routes["a", "d"]) == 4


def test_a_picture_is_written_as_svg_and_into_a_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for out, said in [
        (tmp_path / "a.png", "expected a file that ends in .svg"),
        (tmp_path, "is a folder, not a file"),
    ]:
        assert run(["graph", "block_stacking", "--out", str(out)]) == 2
        assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
