"""Benchmark of planning: the same queries for ours and the peers; every path is checked again, finely."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from kinematics.bench import plan_peers
from kinematics.bench.measuring import Tally, machine
from kinematics.bench.plan_queries import Query, Referee, random_queries
from kinematics.errors import KinematicsError
from kinematics.geometry.transforms import Array
from kinematics.planning.planner import Planner
from kinematics.planning.trajectory import round_corners
from kinematics.robot.robot import Robot, panda

PEER_QUERIES = 200  # for peers, which are slow


def bench(queries: int, seed: int, robot: Robot | None = None) -> dict[str, Any]:
    """Return the figures `ours`, `peers`, `machine` and `times_faster`: than each peer, where both solved."""
    robot = robot or panda()
    referee = Referee(robot)
    drawn = [query for query, _ in zip(random_queries(robot, referee, seed), range(queries), strict=False)]
    ours = run(referee, Ours(robot, referee), drawn)
    peers = {
        name: run(referee, make(robot, referee), drawn[:PEER_QUERIES])
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
    """Results of queries; a path counts as solved if it joins the ends."""

    grazing: int = 0  # paths that touch something when they are checked five times as finely

    def figures(self) -> dict[str, Any]:
        """Return the figures of the tally, and the number of grazing paths."""
        return {**super().figures(), "grazing": self.grazing}


def times_faster(ours: Tally, peer: Tally) -> float | None:
    """Return the ratio of the median CPU times on the queries that both solved, if there are any."""
    both = [k for k, solved in enumerate(zip(ours.solved, peer.solved, strict=False)) if all(solved)]
    if not both:
        return None
    medians = [float(np.median([tally.busy[k] for k in both])) for tally in (peer, ours)]
    return round(medians[0] / medians[1], 1)


class Ours:
    """The planner of the skills; its time includes every check and the shortcuts."""

    def __init__(self, robot: Robot, referee: Referee) -> None:
        self._planner, self._referee = Planner(robot), referee

    def plan(self, query: Query) -> Array | None:
        """Return the corners of a path, or None."""
        valid = self._referee.validity(query)
        try:
            return self._planner.plan(query.start, query.goal, valid, query.seed).corners
        except KinematicsError:
            return None


def run(referee: Referee, planner: Any, queries: list[Query]) -> Paths:
    """Time every query, and evaluate its path."""
    tally = Paths()
    for query in queries:
        corners = tally.timed(partial(planner.plan, query))
        tally.solved.append(corners is not None and _joins(corners, query))
        if corners is not None and not referee.is_clear(query, corners):
            tally.grazing += 1
    return tally


def rounded(referee: Referee, query: Query, corners: Array) -> Array:
    """Return the curve that the arm would follow (n, dof)."""
    valid = referee.validity(query)
    return round_corners(corners, lambda chain: all(map(valid, chain)))


def _joins(corners: Array, query: Query) -> bool:
    ends = (corners[0] - query.start, corners[-1] - query.goal)
    return all(float(np.abs(end).max()) < 1e-4 for end in ends)
