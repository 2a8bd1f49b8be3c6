"""Planning: ours and the peers' on the same queries; every path is checked again, five times as finely."""

from functools import partial
from typing import Any

import numpy as np

from kinematics.bench import plan_peers
from kinematics.bench.measuring import Tally, machine
from kinematics.bench.plan_queries import Query, Referee, drawn
from kinematics.collision import MARGIN
from kinematics.geometry import Array
from kinematics.planning import Planner
from kinematics.reasons import KinematicsError
from kinematics.robot import Robot, panda
from kinematics.trajectory import round_corners

PEER_QUERIES = 60  # of the peers, which take long


def bench(queries: int, seed: int, robot: Robot | None = None) -> dict[str, Any]:
    """`ours`, `peers` and `machine`."""
    robot = robot or panda()
    referee = Referee(robot)
    asked = [query for query, _ in zip(drawn(robot, referee, seed), range(queries), strict=False)]
    some = asked[:PEER_QUERIES]
    peers = {name: make(robot, referee) for name, make in plan_peers.INSTALLED.items()}
    return {
        "ours": measured(referee, Ours(robot, referee), asked),
        "peers": {name: measured(referee, peer, some) for name, peer in peers.items()},
        "ours_on_the_peers_queries": measured(referee, Ours(robot, referee), some),
        "machine": machine(),
    }


class Ours:
    """The planner of the skills; what it is timed on includes every check and the shortcuts."""

    def __init__(self, robot: Robot, referee: Referee) -> None:
        self._planner, self._referee = Planner(robot), referee

    def plan(self, query: Query) -> Array | None:
        scene = self._referee.scene(query)
        try:
            return self._planner.plan(query.start, query.goal, scene.is_free, query.seed).corners
        except KinematicsError:
            return None


def measured(referee: Referee, planner: Any, queries: list[Query]) -> dict[str, Any]:
    """Figures of a planner: an answer counts if it joins the ends; `grazing` counts those that touch."""
    tally, grazing = Tally(), 0
    for query in queries:
        corners = tally.timed(partial(planner.plan, query))
        tally.solved.append(corners is not None and _joins(corners, query))
        if corners is not None and not referee.is_clear(query, corners):
            grazing += 1
    return {**tally.figures(), "grazing": grazing}


def rounded(referee: Referee, query: Query, corners: Array) -> Array:
    """The curve that the arm would follow."""
    scene = referee.scene(query)
    return round_corners(corners, lambda chain: all(scene.is_free(q, MARGIN / 2) for q in chain))


def _joins(corners: Array, query: Query) -> bool:
    ends = (corners[0] - query.start, corners[-1] - query.goal)
    return all(float(np.abs(end).max()) < 1e-4 for end in ends)
