"""Attribution of failed calls: to the decision, planner, grasp, physics or a disturbance."""

from __future__ import annotations

from collections.abc import Sequence

from ntp_dsl.traces.schema import ROOT, Attribution, Call, CallOutcome

ATTRIBUTION_OF_OUTCOME = {
    CallOutcome.NO_IK: Attribution.PLANNER,
    CallOutcome.START_IN_COLLISION: Attribution.PLANNER,
    CallOutcome.GOAL_IN_COLLISION: Attribution.PLANNER,
    CallOutcome.NO_PATH: Attribution.PLANNER,
    CallOutcome.TIME_OUT: Attribution.PLANNER,
    CallOutcome.GRASP_FAILED: Attribution.GRASP,
    CallOutcome.OBJECT_DROPPED: Attribution.GRASP,
    CallOutcome.PLACE_FAILED: Attribution.PHYSICS,
}


def attribute_call(call: Call) -> Attribution | None:
    """Return what a call's failure is attributed to; None where it succeeded or was cut off.

    Refused calls and unfinished programs are attributed to the decision to call them.
    """
    if call.outcome is None or call.succeeded:
        return None
    if call.execution.disturbances:
        return Attribution.DISTURBANCE
    return ATTRIBUTION_OF_OUTCOME.get(call.outcome, Attribution.DECISION)


def attribute_all(calls: Sequence[Call]) -> list[Attribution | None]:
    """Return the attribution of every call, by number.

    An unfinished program has that of the last failed primitive below it.
    """
    attributions = [attribute_call(call) for call in calls]
    last: list[Attribution | None] = [None] * len(attributions)  # of the primitives below each call
    for call in reversed(calls):
        if call.is_program:
            if attributions[call.id]:
                attributions[call.id] = last[call.id] or attributions[call.id]
        else:
            last[call.id] = attributions[call.id]
        if call.parent != ROOT and not last[call.parent]:
            last[call.parent] = last[call.id]
    return attributions
