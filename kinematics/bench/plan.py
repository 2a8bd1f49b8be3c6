"""Planning: ours and the peers' on the same queries; every path is checked again, five times as finely."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from kinematics.bench import plan_peers
from kinematics.bench.measuring import Tally, machine
from kinematics.bench.plan_queries import Query, Referee, drawn
from kinematics.errors import KinematicsError
from kinematics.geometry.transforms import Array
from kinematics.planning.planner import Planner
from kinematics.planning.trajectory import round_corners
from kinematics.robot.robot import Robot, panda

PEER_QUERIES = 200  # of the peers, which take long


def bench(queries: int, seed: int, robot: Robot | None = None) -> dict[str, Any]:
    """`ours`, `peers` and `machine`; and how many times faster than each peer ours is, where both solved."""
    robot = robot or panda()
    referee = Referee(robot)
    asked = [query for query, _ in zip(drawn(robot, referee, seed), range(queries), strict=False)]
    ours = run(referee, Ours(robot, referee), asked)
    peers = {
        name: run(referee, make(robot, referee), asked[:PEER_QUERIES])
        for name, make in plan_peers.INSTALLED.items()
    }
    return {
        "ours": ours.figures(),
        "peers": {name: peer.figures() for name, peer in peers.items()},
        "times_faster": {name: times_faster(ours, peer) for name, peer in peers.items()},
        "machine": machine(),
    }


@dataclass
class Paths(Tally):
    """What came of each query; an answer counts if it joins the ends."""

    grazing: int = 0  # that touch something when they are looked at five times as finely

    def figures(self) -> dict[str, Any]:
        return {**super().figures(), "grazing": self.grazing}


def times_faster(ours: Tally, peer: Tally) -> float | None:
    """The ratio of the medians of CPU time, on the queries that both were asked and solved, if any."""
    both = [k for k, solved in enumerate(zip(ours.solved, peer.solved, strict=False)) if all(solved)]
    if not both:
        return None
    medians = [float(np.median([tally.busy[k] for k in both])) for tally in (peer, ours)]
    return round(medians[0] / medians[1], 1)


class Ours:
    """The planner of the skills; what it is timed on includes every check and the shortcuts."""

    def __init__(self, robot: Robot, referee: Referee) -> None:
        self._planner, self._referee = Planner(robot), referee

    def plan(self, query: Query) -> Array | None:
        valid = self._referee.validity(query)
        try:
            return self._planner.plan(query.start, query.goal, valid, query.seed).corners
        except KinematicsError:
            return None


def run(referee: Referee, planner: Any, queries: list[Query]) -> Paths:
    """Every query, timed, and its path judged."""
    tally = Paths()
    for query in queries:
        corners = tally.timed(partial(planner.plan, query))
        tally.solved.append(corners is not None and _joins(corners, query))
        if corners is not None and not referee.is_clear(query, corners):
            tally.grazing += 1
    return tally


def rounded(referee: Referee, query: Query, corners: Array) -> Array:
    """The curve that the arm would follow."""
    valid = referee.validity(query)
    return round_corners(corners, lambda chain: all(map(valid, chain)))


def _joins(corners: Array, query: Query) -> bool:
    ends = (corners[0] - query.start, corners[-1] - query.goal)
    return all(float(np.abs(end).max()) < 1e-4 for end in ends)
