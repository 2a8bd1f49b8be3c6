"""What calls left behind: which failures were not made good, and where the objects were afterwards."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from math import dist

from ntp_dsl.semantics.observation import Observation, SceneObject, without_lists
from ntp_dsl.traces.failure_attribution import ATTRIBUTION_OF_OUTCOME
from ntp_dsl.traces.phrases import format_call
from ntp_dsl.traces.schema import ROOT, Call, CallOutcome
from ntp_dsl.traces.trace import Trace

NAME = re.compile(r"\w+")
NOTABLE = 0.002  # off the middle of what is below [m]
NEARBY = 0.12  # of an object that may be in the way, from centre to centre [m]
CLOSE = 0.035  # between an object and one that it came down beside [m]


def never_made_good(trace: Trace) -> list[Call]:
    """Return the primitives that went wrong and whose caller did not succeed then or later."""
    done = {format_call(call): call.id for call in trace.calls if call.is_program and call.succeeded}
    return [call for call in trace.calls if _went_wrong(call) and not _made_good(trace, call, done)]


def _went_wrong(call: Call) -> bool:
    if call.is_program or call.outcome in (None, CallOutcome.STOPPED):
        return False
    return bool(call.execution.unmet) if call.succeeded else True


def _made_good(trace: Trace, call: Call, done: dict[str, int]) -> bool:
    return call.parent == ROOT or done.get(format_call(trace.calls[call.parent]), ROOT) >= call.parent


def aftermath(trace: Trace, call: Call) -> str:
    """Return where a call's objects were seen after it, if it was executed in vain; else nothing."""
    in_vain = call.outcome is CallOutcome.UNFINISHED or call.outcome in ATTRIBUTION_OF_OUTCOME
    seen = seen_after(trace, call) if in_vain or call.execution.unmet else None
    if seen is None:
        return ""
    return "; ".join(_places(seen, objects_of(call, seen), bool(call.execution.unmet)))


def at_the_end(trace: Trace, call: Call, told: str) -> str:
    """Return where the objects that a text names were when a call returned; empty where it names none."""
    if call.end_state is None:
        return ""
    seen = trace.states[call.end_state]
    names = [each for each in dict.fromkeys(NAME.findall(told)) if each in seen.positions]
    return "; ".join(_places(seen, names, False))


def seen_after(trace: Trace, call: Call) -> Observation | None:
    """Return the state of the next decision; None where the run ended with the call."""
    number = call.end_state
    if not call.is_program and call.parent != ROOT:
        later = trace.next_of(call)
        number = trace.calls[call.parent].end_state if later is None else later.state
    return None if number is None else trace.states[number]


def _places(seen: Observation, names: Sequence[str], with_hand: bool) -> Iterator[str]:
    """Yield where objects are, how far the first is from the second, and what is at the first.

    Args:
        with_hand: whether to say where the hand is, beside a single object.
    """
    at = {name: seen.positions[name] for name in names}
    if len(at) == 1 and with_hand:
        at = {"the gripper": seen.gripper, **at}
    for name, place in at.items():
        yield f"{name} at {_vector(place)}"
    yield from seen.facts_about(at)
    if len(at) < 2:
        return
    (first, to), (second, base) = list(at.items())[:2]
    yield f"from {second} to {first} {_vector([x - y for x, y in zip(to, base, strict=True)])}"
    if first not in seen.positions or seen.held == first:
        return
    if standing := stands(seen, first):
        yield standing
    others = [each.name for each in seen.objects if each.name in seen.positions and not each.roomy]
    gaps = {name: dist(to[:2], seen.positions[name][:2]) for name in others if name not in (first, second)}
    near = min(gaps, key=lambda name: gaps[name], default=None)
    if near is not None and gaps[near] < NEARBY and seen.positions[near][2] < to[2] + CLOSE:
        yield f"next to {first} is {near} at {_vector(seen.positions[near])}"


def objects_of(call: Call, seen: Observation) -> list[str]:
    """Return the objects among a call's arguments that are seen, each once."""
    names = dict.fromkeys(map(str, without_lists(call.arguments)))
    return [each for each in names if each in seen.positions]


def stands(seen: Observation, name: str) -> str:
    """Return what an object stands on, and how far off its middle; empty where it stands on nothing."""
    from ntp_dsl.semantics.predicates import stands_on  # and with it numpy, which few explanations need

    below = [each for each in seen.objects if stands_on(seen, name, each.name)]
    places = [f"{each.name}{_off_middle(seen, name, each)}" for each in below]
    return f"{name} stands on {' and '.join(places)}" if places else ""


def _off_middle(seen: Observation, name: str, below: SceneObject) -> str:
    off = dist(seen.positions[name][:2], seen.positions[below.name][:2])
    return "" if below.roomy or off < NOTABLE else f", {1000 * off:.0f} mm off its middle"


def crowding(trace: Trace, call: Call) -> str | None:
    """Return the object that stands right beside the one that a call put down; None where none does."""
    from ntp_dsl.semantics.free_space import clearance

    seen = seen_after(trace, call)
    names = objects_of(call, seen) if seen is not None else []
    if seen is None or not names or seen.held == names[0] or trace.states[call.state].held != names[0]:
        return None
    at, size = seen.positions[names[0]], seen.by_name[names[0]].size
    beside = {
        each.name: float(clearance(at[:2], size, [(seen.positions[each.name], each.size)]))
        for each in seen.objects
        if each.name in seen.positions and each.name not in names and each.movable
        if abs(seen.positions[each.name][2] - at[2]) < (each.size[2] + size[2]) / 2
    }
    nearest = min(beside, key=lambda name: beside[name], default=None)
    return nearest if nearest is not None and beside[nearest] < CLOSE else None


def _vector(values: list[float] | tuple[float, ...]) -> str:
    return f"({', '.join(f'{value:.3f}' for value in values)}) m"
