"""The scene of a trace, and that of its demonstration, in motion."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import dist
from pathlib import Path
from typing import TYPE_CHECKING

from ntp_dsl.semantics.geometry import Quaternion, Vector
from ntp_dsl.semantics.observation import SceneObject
from ntp_dsl.traces.page.document import Moment, PageObject, PageScene, Turn
from ntp_dsl.traces.page.page_pictures import pictures
from ntp_dsl.traces.schema import Call
from ntp_dsl.traces.trace import Trace

if TYPE_CHECKING:
    from ntp_dsl.demonstrations.demonstration import Demonstration

MOST_FRAMES = 1500  # of a demonstration; of more, evenly spaced ones are taken
STILL = 5e-4  # [m] that an object has to move for a new place
TURNED = 0.01  # change of a quaternion's part for a new orientation


def episode_scene(trace: Trace, title: str, folder: Path) -> PageScene:
    """Return the scene of an episode, with the camera's pictures of the folder."""
    return PageScene(
        title=title,
        objects=_objects(trace.header.objects),
        motion=[*episode_motion(trace)],
        turns=[*_changed((call.frame, trace.states[call.state].orientations) for call in trace.calls)],
        pictures=[(each.frame, each.uri) for each in pictures(trace, folder)],
    )


def demonstrated_scene(shown: Demonstration) -> PageScene:
    """Return the motion of a demonstration, whose frames scopes count."""
    frames = range(0, len(shown), -(-len(shown) // MOST_FRAMES) or 1)
    quaternions = shown.orientations
    turns: list[tuple[int, Mapping[str, Quaternion]]] = []
    if quaternions is not None:
        turns = [(t, dict(zip(shown.names, quaternions[t].tolist(), strict=True))) for t in frames]
    return PageScene(
        title="demonstration",
        objects=_objects(shown.objects),
        motion=[*_demonstrated(shown, frames)],
        turns=[*_changed(iter(turns))],
        pictures=[],
    )


def _objects(objects: Sequence[SceneObject]) -> dict[str, PageObject]:
    return {each.name: PageObject(each.type, each.size, each.shape) for each in objects}


def episode_motion(trace: Trace) -> Iterator[Moment]:
    """Yield the traced motion; without it, the states that calls were made in."""
    if trace.motions:
        yield from ((m.frame, m.time, m.gripper, m.closed, m.positions) for m in trace.motions)
        return
    positions: Mapping[str, Vector] = {}
    last: Call | None = None
    for call in trace.calls:
        if last is None or call.state != last.state:
            last, state = call, trace.states[call.state]
            moved = {name: p for name, p in state.positions.items() if positions.get(name) != p}
            positions = state.positions
            yield call.frame, call.frame / 10, state.gripper, state.closed, moved


def _demonstrated(shown: Demonstration, frames: Sequence[int]) -> Iterator[Moment]:
    places: dict[str, Vector] = {}
    for t in frames:
        moved: dict[str, Vector] = {}
        for name, (x, y, z) in zip(shown.names, shown.positions[t].tolist(), strict=True):
            if name not in places or dist(places[name], (x, y, z)) > STILL:
                moved[name] = (round(x, 4), round(y, 4), round(z, 4))
        places |= moved
        x, y, z = shown.grippers[t].tolist()
        hand = (round(x, 4), round(y, 4), round(z, 4))
        yield t, round(float(shown.times[t]), 3), hand, bool(shown.closed[t]), moved


def _changed(turns: Iterator[tuple[int, Mapping[str, Quaternion]]]) -> Iterator[Turn]:
    """Yield the orientations that changed, each with its frame."""
    known: dict[str, Quaternion] = {}
    for frame, orientations in turns:
        new = {
            name: _rounded(turn)
            for name, turn in orientations.items()
            if name not in known or max(abs(p - q) for p, q in zip(known[name], turn, strict=True)) > TURNED
        }
        known |= new
        if new:
            yield frame, new


def _rounded(turn: Quaternion) -> Quaternion:
    x, y, z, w = turn
    return round(x, 3), round(y, 3), round(z, 3), round(w, 3)
