"""Who is to blame for what did not go well: decision, planner, grasp, physics or disturbance."""

from __future__ import annotations

from ntp_dsl.traces.schema import ROOT, Call, Trace
from ntp_dsl.worlds.protocol import Failure

DECISION, PLANNER, GRASP, PHYSICS, DISTURBANCE = "decision", "planner", "grasp", "physics", "disturbance"

OF_FAILURE = {
    Failure.NO_IK: PLANNER,
    Failure.START_IN_COLLISION: PLANNER,
    Failure.GOAL_IN_COLLISION: PLANNER,
    Failure.NO_PATH: PLANNER,
    Failure.TIME_OUT: PLANNER,
    Failure.GRASP_FAILED: GRASP,
    Failure.OBJECT_DROPPED: GRASP,
    Failure.PLACE_FAILED: PHYSICS,
}


def of_call(call: Call) -> str:
    """For what a call came to; nothing where it went well.

    A call that was refused was the wrong one to make, and so was a program that had to give up.
    """
    if call.went_well or not call.outcome:
        return ""
    if call.disturbances:
        return DISTURBANCE
    return OF_FAILURE.get(call.outcome, DECISION)  # type: ignore[call-overload,no-any-return]


def of_all(trace: Trace) -> list[str]:
    """By the calls' numbers. For a program that gave up, that of the last primitive below that failed."""
    blamed = [of_call(call) for call in trace.calls]
    last: list[str] = [""] * len(blamed)  # of the primitives below each call
    for call in reversed(trace.calls):
        if call.is_program:
            if blamed[call.id]:
                blamed[call.id] = last[call.id] or blamed[call.id]
        else:
            last[call.id] = blamed[call.id]
        if call.parent != ROOT and not last[call.parent]:
            last[call.parent] = last[call.id]
    return blamed
