"""Who is to blame for what did not go well: decision, planner, grasp, physics or disturbance."""

from __future__ import annotations

from ntp_dsl.traces.schema import Call
from ntp_dsl.world import Failure

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
