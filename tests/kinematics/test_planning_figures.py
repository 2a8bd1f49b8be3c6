"""The figures of inverse kinematics and planning: from a few queries here, with `--soak` as claimed."""

import resource

import pytest

from kinematics.bench import ik, plan
from kinematics.bench.measuring import Tally
from kinematics.bench.plan_queries import Query, Referee, random_queries
from kinematics.robot.robot import Robot, load


def test_inverse_kinematics_solves_every_pose_within_reach(robot: Robot, soak: bool) -> None:
    count = 1000 if soak else 60
    sets = {"topdown": ik.top_down(robot, count, 0), "general": ik.general(robot, count, 0)}
    for name, figures in ik.evaluated(robot, ik.ours(robot), sets).items():
        assert figures["solved"] == 1.0, name


def queries(robot: Robot, referee: Referee, count: int) -> list[Query]:
    return [query for query, _ in zip(random_queries(robot, referee, 0), range(count), strict=False)]


def test_every_query_is_planned_and_no_path_grazes(robot: Robot, soak: bool) -> None:
    referee = Referee(robot)
    planner = plan.Ours(robot, referee)
    asked = queries(robot, referee, 1000 if soak else 10)
    paths = plan.run(referee, planner, asked)
    assert all(paths.solved) and paths.grazing == 0
    for query in asked[:: 5 if soak else 3]:
        corners = planner.plan(query)
        assert corners is not None and referee.is_clear(query, plan.rounded(referee, query, corners))


def test_many_queries_in_one_process_need_no_more_memory(soak: bool) -> None:
    robot = load("panda")
    referee = Referee(robot)
    planner = plan.Ours(robot, referee)
    asked = queries(robot, referee, 100 if soak else 10)
    for query in asked:
        planner.plan(query)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(100 if soak else 10):
        for query in asked:
            planner.plan(query)
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert grown < 50_000  # kB


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of the peers
@pytest.mark.parametrize(("bench", "keys"), [(ik, {"topdown", "general"}), (plan, {"solved", "grazing"})])
def test_a_benchmark_reports_ours_the_peers_and_the_machine(bench, keys: set[str], capfd) -> None:
    figures = bench.bench(2, 0)
    assert keys <= figures["ours"].keys() and figures["peers"] and figures["machine"]["libraries"]
    assert all(keys <= peer.keys() for peer in figures["peers"].values())


def test_a_ratio_of_times_covers_the_queries_that_both_solved() -> None:
    ours = Tally([True, True, False, True, True], busy=[1.0, 2.0, 3.0, 9.0, 9.0])
    peer = Tally([True, False, True, True], busy=[4.0, 80.0, 90.0, 36.0])
    assert plan.times_faster(ours, peer) == 4.0  # of the first query and of the fourth
    assert plan.times_faster(ours, Tally([False], busy=[1.0])) is None
