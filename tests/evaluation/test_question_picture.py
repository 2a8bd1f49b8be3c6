"""Questions as pictures: well-formed, with every offer in the key and on the page."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest
from test_other_domains import FOLDER

from ntp_dsl.cli.app import run
from ntp_dsl.evaluation.question_picture import question_picture
from ntp_dsl.semantics.observation import Observation, SceneObject

HOSTILE = "</svg><script>alert(1)</script>&\"'"


def scene(names: list[str]) -> Observation:
    objects = tuple(
        SceneObject(name, "Block", (0.04, 0.06, 0.05), shape)
        for name, shape in zip(names, ("box", "cylinder", "bowl"), strict=True)
    )
    places = [(0.4, -0.2, 0.02), (0.6, 0.1, 0.02), (0.5, 0.3, 0.02)]
    return Observation(objects, dict(zip(names, places, strict=True)), (0.5, 0.0, 0.3), False)


def drawn(text: str) -> tuple[ElementTree.Element, list[str]]:
    """Return a picture's root, and all of its texts."""
    root = ElementTree.fromstring(text)
    return root, [each.text or "" for each in root.iter() if each.tag.endswith("text")]


@pytest.mark.parametrize("names", [["a", "b", "c"], [HOSTILE, "b", "c"]])
def test_each_offer_is_in_the_key_and_numbered_on_the_page(names: list[str]) -> None:
    offered = [((names[0], each), f"({names[0]}, {each}) 50%") for each in names[1:]]
    root, texts = drawn(question_picture(scene(names), offered, "which?"))
    assert {*names} <= {*texts} and {text for _, text in offered} <= {*texts}
    assert [texts.count(number) for number in ("1", "2")] == [2, 2]  # on the page, and in the key
    assert not [each for each in root.iter() if each.tag.endswith("script")]


def test_all_that_is_drawn_lies_on_the_page() -> None:
    names = ["a", "b", "c"]
    root, _ = drawn(question_picture(scene(names), [((name,), name) for name in names], "which?"))
    width, height = float(root.attrib["width"]), float(root.attrib["height"])
    round_ones = [each for each in root.iter() if "cx" in each.attrib]
    assert len(round_ones) >= 2 + 3 * 3
    for each in round_ones:
        assert 0 < float(each.attrib["cx"]) < width and 0 < float(each.attrib["cy"]) < height


def test_questions_are_drawn_beside_what_is_read(tmp_path: Path) -> None:
    assert run(["read", str(FOLDER / "lanterns"), "in_doubt", "--pictures", str(tmp_path)]) == 0
    files = sorted(tmp_path.iterdir())
    assert files and all(each.name.startswith("question_") for each in files)
    _, texts = drawn(files[0].read_text())
    assert sum("50%" in each for each in texts) == 2
