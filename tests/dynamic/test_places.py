"""The check's diagnostics are at what the user wrote, whatever goes wrong, and wherever it shows."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from checked_libraries import ALL_ON, PLACING, STACKING, diagnostics, excerpt, written

from ntp_dsl.common.resources import library_folder
from ntp_dsl.dynamic import check
from ntp_dsl.dynamic.places import Places
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.loader import load
from ntp_dsl.language.syntax.nodes import NOWHERE
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import ACHIEVED, Failure, Outcome, World

STACKS = PLACING + STACKING.format(run="fill(goal)", success=ALL_ON)
SHIPPED_ALONE = STACKING.format(run="put_down()", success="empty(gripper) and " + ALL_ON)
LIBRARIES = {
    "a task of its own program": STACKS,
    "a task of a shipped program": SHIPPED_ALONE,
    "a program and no task": "program lift(item: Movable):\n    requires present(item) and reachable(item)\n"
    "    achieves holding(item)\n    pick(item)\n",
    "nothing but a type": "type Cup is Movable\n",
}
LIES = {"done": ACHIEVED, "refused": Outcome(False, Failure.NO_PATH)}


def lying(api: str, outcome: Outcome) -> Callable[..., World]:
    """Return a maker of worlds in which an api does nothing but say so."""

    def make(*given: Any, **options: Any) -> World:
        world = make_world(*given, **options)
        world.skills[api] = lambda *_: outcome
        return world

    return make


def away(path: Path, found: list[Diagnostic]) -> list[str]:
    """Return the diagnostics that are in another file, or nowhere."""
    return [str(each) for each in found if each.span.path != path or not each.span.line]


@pytest.mark.parametrize("lie", LIES)
@pytest.mark.parametrize("api", ["move_to", "grasp", "release"])
@pytest.mark.parametrize("library", LIBRARIES)
def test_a_shipped_api_that_lies_is_reported_in_the_users_text(
    library: str, api: str, lie: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(check, "make_world", lying(api, LIES[lie]))
    path = written(tmp_path, LIBRARIES[library])
    found = diagnostics(path)
    is_called = (library, api) != ("a task of a shipped program", "grasp")
    assert {each.code for each in found if each.severity == "error"} == {"E601" if is_called else "E603"}
    assert away(path, found) == []
    monkeypatch.setattr(check, "check_contracts", lambda *_: iter(()))
    assert away(path, diagnostics(path)) == []  # as if the api lied in rare states alone


def scene(rng: np.random.Generator) -> str:
    """Return a task that is hard to do: large objects, few and small pads, little room."""
    wide, high = rng.integers(3, 16), rng.integers(2, 12)
    pad, pads, blocks = rng.integers(4, 25), rng.integers(1, 3), rng.integers(3, 7)
    return f"""
type Pad is Place
{PLACING}
task crowded:
    scene:
        pads: {pads} Pad on table with box({pad} cm, {pad} cm, 1 cm)
        blocks: {blocks} Block on table with box({wide} cm, {wide} cm, {high} cm)
    goal:    matchings(blocks, pads, pairs={rng.integers(1, 4)})
    run:     fill(goal)
    success: {ALL_ON}
"""


def test_what_goes_wrong_in_a_random_scene_is_reported_in_the_users_text(soak: bool, tmp_path: Path) -> None:
    codes: set[str] = set()
    for seed in range(300 if soak else 9):
        path = written(tmp_path, scene(np.random.default_rng(seed)))
        found = diagnostics(path)
        assert away(path, found) == [], seed
        codes |= {each.code for each in found}
    assert codes == {"E605", "E608", "W603"}


def test_a_start_without_room_is_reported_at_the_line_of_the_scene(tmp_path: Path) -> None:
    path = written(tmp_path, scene(np.random.default_rng(4)))  # whose nominal starts have just enough room
    (error,) = diagnostics(path)
    assert error.code == "E608" and excerpt(path, error).startswith("blocks: "), error


def test_a_shipped_library_that_is_checked_itself_is_the_place(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check, "make_world", lying("grasp", ACHIEVED))
    path = library_folder() / "tabletop.ntp"
    found = diagnostics(path)
    assert {each.code for each in found} == {"E601"} and away(path, found) == []


def test_what_is_at_a_place_of_a_shipped_library_is_moved_and_the_place_noted(tmp_path: Path) -> None:
    path = written(tmp_path, STACKS)
    registry = load(path)
    places = Places(registry, path)
    home = registry.tasks["tower"].scene[0].span
    for span in (*(row.span for row in registry.apis.values()), registry.programs["place"].span, NOWHERE):
        moved = places.owned(Diagnostic("N603", "never ready", span), home)
        assert moved.span == home
        assert [note.span for note in moved.notes] == ([span] if span.line else [])
    own = Diagnostic("W605", "not achieved", registry.programs["fill"].span)
    assert places.owned(own, home) == own
