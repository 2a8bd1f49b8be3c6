"""What failed calls are attributed to: decision, planner, grasp, physics or disturbance."""

from __future__ import annotations

from ntp_dsl.traces.schema import ROOT, Attribution, Call, CallOutcome, Trace

OF_OUTCOME = {
    CallOutcome.NO_IK: Attribution.PLANNER,
    CallOutcome.START_IN_COLLISION: Attribution.PLANNER,
    CallOutcome.GOAL_IN_COLLISION: Attribution.PLANNER,
    CallOutcome.NO_PATH: Attribution.PLANNER,
    CallOutcome.TIME_OUT: Attribution.PLANNER,
    CallOutcome.GRASP_FAILED: Attribution.GRASP,
    CallOutcome.OBJECT_DROPPED: Attribution.GRASP,
    CallOutcome.PLACE_FAILED: Attribution.PHYSICS,
}


def of_call(call: Call) -> Attribution | None:
    """Return what a call's failure is attributed to; None where it went well or was cut off.

    A call that was refused was the wrong one to make, and so was a program that had to give up.
    """
    if call.outcome is None or call.went_well:
        return None
    if call.execution.disturbances:
        return Attribution.DISTURBANCE
    return OF_OUTCOME.get(call.outcome, Attribution.DECISION)


def of_all(trace: Trace) -> list[Attribution | None]:
    """Return the attribution of every call, by number.

    For a program that gave up it is that of the last primitive below that failed.
    """
    found = [of_call(call) for call in trace.calls]
    last: list[Attribution | None] = [None] * len(found)  # of the primitives below each call
    for call in reversed(trace.calls):
        if call.is_program:
            if found[call.id]:
                found[call.id] = last[call.id] or found[call.id]
        else:
            last[call.id] = found[call.id]
        if call.parent != ROOT and not last[call.parent]:
            last[call.parent] = last[call.id]
    return found
