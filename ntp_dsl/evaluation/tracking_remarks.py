"""What is odd about how a demonstration was tracked: its clock, its camera, its hand, its fixed objects."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ntp_dsl.common.text import printable
from ntp_dsl.demonstrations.demonstration import Demonstration

GAP = 1.0  # [s] between two frames, if it is also GAPS times as long as usual
GAPS = 10
SHIFT = 0.02  # [m] by which all objects, or one that never moves, are elsewhere than before
FIRST = 10  # frames of which a first and last place is the median
AWAY = 0.06  # [m] from the surface of the nearest object, where a hand that closes holds nothing
ALONG = 0.06  # [m] that an object goes with an open hand
BESIDE = 0.12  # [m] from the hand, within which an object may go with it
ALONE = 0.1  # [m] from the surface of an object that moves, where no hand moves it
SLOW = 0.3  # [s] within which what is carried moves by more than SHIFT
SAME_WAY = 0.02  # [m] by which the ways of both differ, at most


def tracking_remarks(shown: Demonstration) -> Iterator[str]:
    """Yield what is odd, as sentences; one of each kind, with the first place where it shows."""
    moved = _camera(shown) or _fixed(shown)
    for found in (_gap(shown), moved, _far_grasps(shown) or _moved_alone(shown), _late_hand(shown)):
        if found:
            yield printable(found)


def _gap(shown: Demonstration) -> str:
    steps = np.diff(shown.times)
    if not len(steps) or steps.max() < max(GAP, GAPS * float(np.median(steps))):
        return ""
    at = int(steps.argmax())
    return (
        f"nothing is shown from {shown.times[at]:.1f} s to {shown.times[at + 1]:.1f} s: what happens then is "
        "not explained"
    )


def _camera(shown: Demonstration) -> str:
    """Tell of a frame before which all objects, those that never move too, lay elsewhere in the same way."""
    if len(shown.objects) < 3:
        return ""
    ways = np.diff(shown.positions, axis=0)  # (T - 1, N, 3)
    common = np.median(ways, axis=1)
    spread = np.linalg.norm(ways - common[:, None], axis=2).max(axis=1)
    jumps = np.flatnonzero((np.linalg.norm(common, axis=1) > SHIFT) & (spread < SHIFT / 2))
    if not len(jumps):
        return ""
    far = float(np.linalg.norm(common[jumps[0]]))
    return f"all objects are {far:.2f} m elsewhere from frame {jumps[0] + 1} on: did the camera move?"


def _fixed(shown: Demonstration) -> str:
    """Tell of objects that never move and do, by more than their noise."""
    first, last = shown.positions[:FIRST], shown.positions[-FIRST:]
    way = np.linalg.norm(np.median(last, axis=0) - np.median(first, axis=0), axis=1)
    noise = np.linalg.norm(first.std(axis=0), axis=1)
    moved = [
        obj.name
        for obj, far, sigma in zip(shown.objects, way.tolist(), noise.tolist(), strict=True)
        if not obj.movable and far > SHIFT + 2 * sigma
    ]
    if not moved:
        return ""
    return f"what never moves by its declaration lies elsewhere at the end: {', '.join(moved)}"


def _far_grasps(shown: Demonstration) -> str:
    """Tell of a hand that closes away from everything, wherever it closes."""
    closings = np.flatnonzero(~shown.closed[:-1] & shown.closed[1:]) + 1
    movable = [index for index, obj in enumerate(shown.objects) if obj.movable]
    if not len(closings) or not movable:
        return ""
    reach = np.array([max(shown.objects[index].size) / 2 for index in movable])
    places = shown.positions[closings][:, movable]
    away = (np.linalg.norm(places - shown.grippers[closings, None], axis=2) - reach).min(axis=1)
    if away.min() < AWAY:
        return ""
    return (
        f"wherever the hand closes, it is {away.min():.2f} m or more from every object: is `gripper` the "
        "point between the fingertips, in the frame of the objects?"
    )


def _moved_alone(shown: Demonstration) -> str:
    """Tell of objects most of which move while neither the hand nor anything that it moves is near."""
    span = max(1, round(SLOW / float(np.median(np.diff(shown.times))))) if len(shown) > 1 else len(shown)
    if len(shown) <= span:
        return ""
    ways = shown.positions[span:] - shown.positions[:-span]  # (T - span, N, 3)
    apart = np.linalg.norm(shown.positions - shown.grippers[:, None], axis=2)[span:]
    apart -= np.array([max(obj.size) / 2 for obj in shown.objects])
    nearest: dict[str, float] = {}
    for index, obj in enumerate(shown.objects):
        moves = np.linalg.norm(ways[:, index], axis=1) > SHIFT
        if obj.movable and moves.any():
            along = np.linalg.norm(ways[moves] - ways[moves, index][:, None], axis=2) < SHIFT / 2
            carriers = np.where(along, apart[moves], np.inf).min(axis=1)  # what it lies in goes its way
            nearest[obj.name] = float(np.median(carriers))
    alone = {name: far for name, far in nearest.items() if far > ALONE}
    if 2 * len(alone) <= len(nearest):
        return ""
    name, far = max(alone.items(), key=lambda each: each[1])
    others = f", as {len(alone) - 1} others do" if len(alone) > 1 else ""
    return (
        f"{name} moves while the hand is some {far:.2f} m away from it{others}: "
        "are the hand and the objects in one frame?"
    )


def _late_hand(shown: Demonstration) -> str:
    """Tell of an object that goes along with an open hand."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], ~shown.closed, [False]]).astype(int)))
    for begin, end in edges.reshape(-1, 2).tolist():
        if end == len(shown):
            break
        hand = shown.grippers[end - 1, :2] - shown.grippers[begin:end, :2]
        ways = shown.positions[end - 1, :, :2] - shown.positions[begin:end, :, :2]
        beside = np.linalg.norm(shown.positions[begin:end] - shown.grippers[begin:end, None], axis=2) < BESIDE
        along = np.linalg.norm(ways - hand[:, None], axis=2) < SAME_WAY
        far = np.linalg.norm(hand, axis=1)[:, None] > ALONG
        frames, objects = np.nonzero(beside & along & far)
        for index in objects[:1].tolist():
            obj = shown.objects[index]
            if obj.movable and beside[-1, index]:
                since = shown.times[begin + int(frames[0])]
                return (
                    f"{obj.name} goes along with the open hand from {since:.1f} s on, before it closes at "
                    f"{shown.times[end]:.1f} s: does `closed` come too late?"
                )
    return ""
