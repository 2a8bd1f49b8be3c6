"""What is odd about a demonstration that was made elsewhere, so that people know it before it is run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ntp_dsl.common.text import printable
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.evaluation.demonstrated import as_demonstrated
from ntp_dsl.evaluation.tracking_remarks import tracking_remarks
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.attempts import without_attempts
from ntp_dsl.semantics.facts import Fact, Literal
from ntp_dsl.semantics.observation import Observation
from ntp_dsl.semantics.state import State
from ntp_dsl.semantics.state_changes import says_of_state
from ntp_dsl.tasks.instances import Instance

MOVED = 0.05  # [m] from where it began
LAST = 10  # frames of which an object's last place is the mean: noise averages out
STILL = 0.01  # [m] from the last one, within which its places are averaged
FEW = 3  # objects or facts that a sentence names
JUMP = 0.15  # [m] aside from one frame to the next, which only a hand can bring about
CARRIED = 0.1  # [m] that a closed hand goes, with which something should have moved


def remarks(registry: Registry, instance: Instance, shown: Demonstration) -> Iterator[str]:
    """Yield what is odd, as sentences. Raises `NtpError` for a demonstration of another task."""
    instance = as_demonstrated(registry, instance, shown)
    last = _moment(shown, LAST)
    in_hand = _moment(shown, 1).held
    moved = _moved(shown)
    if moved and not shown.closed.any():
        yield f"the hand is never closed, and yet {_named(moved)} moved: is `closed` right?"
    yield from _odd_beginning(shown)
    yield from _jumps(shown)
    yield from _nothing_carried(shown)
    yield from tracking_remarks(shown)
    state = State(registry, last)
    facts = instance.literals(registry, last) if instance.is_judged else []
    lacking = [str(fact) for fact in facts if not state.holds(fact)]
    if shown.facts is None and any(_is_of_state(registry, fact) for fact in facts if not state.holds(fact)):
        yield "the demonstration has no column `facts`, so that nothing of the state can be seen in it"
    if in_hand is not None and (lacking or not facts):
        yield f"the demonstration ends with {printable(in_hand)} in the hand: is it whole?"
    if lacking:
        yield f"the demonstration does not end in the goal that it states: at its end, not {_named(lacking)}"


def act(shown: Demonstration, frame: int) -> str:
    """Return what the hand does, or which fact changes, just before a frame after the first, and when."""
    when = f"at {float(shown.times[frame]):.1f} s"
    before, after = shown.closed[frame - 1], shown.closed[frame]
    if before != after:
        what = "closes" if after else "opens"
        near = int(np.argmin(np.linalg.norm(shown.positions[frame] - shown.grippers[frame], axis=1)))
        return printable(f"the hand {what} at {shown.names[near]}, {when}")
    assert shown.facts is not None, "else there were no act"
    now, was = (without_attempts(shown.facts[each]) for each in (frame, frame - 1))
    changed = [f"{each} comes true" for each in now - was] + [f"{each} ceases to hold" for each in was - now]
    return printable(f"{_named(sorted(changed)) or 'something changes'}, {when}")


def _odd_beginning(shown: Demonstration) -> Iterator[str]:
    if shown.closed[0] and not shown.closed.all():
        yield "the hand is closed in the first frame, as if it had taken something: does it begin too late?"


def _jumps(shown: Demonstration) -> Iterator[str]:
    """Yield where an object is somewhere else from one frame to the next, and no closed hand brought it."""
    aside = np.linalg.norm(np.diff(shown.positions[:, :, :2], axis=0), axis=2)
    is_open = ~(shown.closed[1:] | shown.closed[:-1])
    frames, objects = np.nonzero((aside > JUMP) & is_open[:, None])
    for frame, index in list(zip(frames.tolist(), objects.tolist(), strict=True))[:FEW]:
        name, far = printable(shown.names[index]), aside[frame, index]
        yield f"{name} jumps by {far:.2f} m at frame {frame + 1} and the hand is open: is it tracked rightly?"


def _nothing_carried(shown: Demonstration) -> Iterator[str]:
    """Yield where the hand goes somewhere closed, and nothing moves with it."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], shown.closed, [False]]).astype(int)))
    for begin, end in edges.reshape(-1, 2).tolist():
        hand, places = shown.grippers[begin:end], shown.positions[begin:end]
        way = np.linalg.norm(hand - hand[:1], axis=1).max()
        moved = np.linalg.norm(places - places[:1], axis=2).max(initial=0.0)
        if way > CARRIED and moved < STILL:
            since = shown.times[begin] - shown.times[0]
            yield f"the hand closes after {since:.1f} s and goes {way:.2f} m, and no object moves with it"


def _is_of_state(registry: Registry, fact: Fact) -> bool:
    """Return whether a literal, or the body of its predicate, says something of the state."""
    if not isinstance(fact, Literal):
        return False
    declared = registry.predicates[fact.predicate]
    return declared.is_state or any(says_of_state(registry, declared.body))


def _moment(shown: Demonstration, frames: int) -> Observation:
    """Return the end of a demonstration, with the places of what lies still averaged over the last frames."""
    places = shown.positions[-frames:]
    still = np.linalg.norm(places - places[-1:], axis=2, keepdims=True) < STILL
    positions = np.mean(places, axis=0, where=still).tolist()
    turns = shown.orientations[-1].tolist() if shown.orientations is not None else []
    x, y, z = shown.grippers[-1].tolist()
    return Observation(
        shown.objects,
        {name: (px, py, pz) for name, (px, py, pz) in zip(shown.names, positions, strict=True)},
        (x, y, z),
        bool(shown.closed[-1]),
        orientations={name: tuple(turn) for name, turn in zip(shown.names, turns, strict=False)},
        facts=shown.facts[-1] if shown.facts else frozenset(),
    )


def _moved(shown: Demonstration) -> list[str]:
    way = np.linalg.norm(shown.positions - shown.positions[:1], axis=2).max(axis=0)
    return [name for name, far in zip(shown.names, way.tolist(), strict=True) if far > MOVED]


def _named(texts: list[str]) -> str:
    more = f" and {len(texts) - FEW} more" if len(texts) > FEW else ""
    return printable(", ".join(texts[:FEW])) + more
