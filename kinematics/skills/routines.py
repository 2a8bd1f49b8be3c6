"""Sequences of skills: pick, place, put down, drop."""

from collections.abc import Callable

from kinematics.errors import Reason
from kinematics.shapes import containers
from kinematics.simulation.cell import Cell
from kinematics.skills.skills import Motion, grasp, move_above, move_above_free_place, release


def pick(cell: Cell, item: str, seed: int) -> Motion:
    """Grasp an item, and hold it above where it was."""
    return _in_turn(lambda: move_above(cell, item, seed), lambda: grasp(cell, item, seed))


def place(cell: Cell, support: str, seed: int) -> Motion:
    """Put the held body on top of another, centred and aligned."""
    return _in_turn(lambda: move_above(cell, support, seed), lambda: release(cell, seed))


def put_down(cell: Cell, seed: int) -> Motion:
    """Put the held body on the clearest free place of the table."""
    return _in_turn(lambda: move_above_free_place(cell, seed), lambda: release(cell, seed))


def drop_into(cell: Cell, container: str, seed: int) -> Motion:
    """Drop the held body into a bin, a tray or a bowl."""
    body = cell.bodies.get(container)
    if body is not None and containers.cavity_of(body.shape) is None:
        return Motion(False, Reason.PLACEMENT_FAILED, {"message": f"'{container}' has no cavity"})
    return place(cell, container, seed)


def _in_turn(*skills: Callable[[], Motion]) -> Motion:
    """Run skills in sequence until one fails; return their evidence and times as one motion."""
    done: list[Motion] = []
    for skill in skills:
        done.append(skill())
        if not done[-1].achieved:
            break
    evidence = {key: value for motion in done for key, value in motion.evidence.items()}
    return Motion(
        done[-1].achieved,
        done[-1].reason,
        evidence,
        sum(motion.planning_seconds for motion in done),
        sum(motion.moving_seconds for motion in done),
        sum(motion.simulated_seconds for motion in done),
        "+".join(dict.fromkeys(solver for motion in done for solver in motion.solver.split("+") if solver)),
        done[0].planner,
    )
