"""Paths, straight lines and trajectories: their ends, clearance, limits and repeatability."""

import math
import time
from dataclasses import replace
from functools import partial

import mujoco
import numpy as np
import pytest

from kinematics.collision.models import MARGIN, lever_arms
from kinematics.collision.scene import CollisionScene
from kinematics.collision.scene_state import HeldBody, SceneState
from kinematics.errors import NoPathFound, Obstructed, Reason
from kinematics.geometry.transforms import UPRIGHT, Array, Pose, angle_between
from kinematics.ik.differential_ik import StraightLines
from kinematics.ik.global_ik import InverseKinematics, tool_pointing_down
from kinematics.planning import planner as planning
from kinematics.planning.planner import MAXIMUM_CHECKS, PLANNERS, RESOLUTION, Path, Planner, Validity
from kinematics.planning.trajectory import ACCELERATION_SHARE, TIME_STEP, round_corners, time_parameterise
from kinematics.robot import models
from kinematics.robot.robot import Robot, panda
from kinematics.shapes.shapes import Box

ROBOT = panda()
SOLVER = InverseKinematics(ROBOT)
PLANNER = Planner(ROBOT)
SHAPES = {f"brick{i}": Box((0.025, 0.025, 0.025)) for i in range(6)}


SCENE = CollisionScene(ROBOT, SHAPES)


def walled() -> SceneState:
    """Return a wall of six cubes, two abreast and three high, round which the arm must go."""
    places = [(0.5 + 0.051 * column, 0.0, 0.025 + 0.05 * row) for column in (0, 1) for row in (0, 1, 2)]
    return SceneState({name: Pose(at, UPRIGHT) for name, at in zip(SHAPES, places, strict=True)}, 0.04)


def round_the_wall(margin: float = MARGIN) -> Validity:
    return partial(SCENE.is_free, state=walled(), margin=margin)


def beside(y: float) -> Array:
    q = SOLVER.solve(tool_pointing_down(0.52, y, 0.08), ROBOT.home)
    assert q is not None
    return q


def plan(seed: int, planner: str = "rrt_connect") -> Path:
    return PLANNER.plan(beside(-0.15), beside(0.15), round_the_wall(), seed, planner)


@pytest.mark.parametrize("seed", range(5))
def test_a_planned_path_joins_its_ends_and_stays_clear(seed: int) -> None:
    corners, touches_nothing = plan(seed).corners, round_the_wall(margin=0.0)
    assert np.allclose(corners[0], beside(-0.15)) and np.allclose(corners[-1], beside(0.15))
    for a, b in zip(corners, corners[1:], strict=False):
        steps = math.ceil(5 * float(np.linalg.norm(b - a)) / RESOLUTION)
        assert all(touches_nothing(a + (b - a) * k / steps) for k in range(steps + 1))


def test_the_same_seed_gives_the_same_path_and_another_seed_another() -> None:
    first, between, again = plan(3), plan(4), plan(3)
    assert np.array_equal(first.corners, again.corners) and first.checks == again.checks
    assert not np.array_equal(first.corners, between.corners)


@pytest.mark.parametrize("planner", PLANNERS)
def test_every_planner_finds_the_way_round_the_wall(planner: str) -> None:
    assert plan(0, planner).planner == planner


def test_an_end_in_collision_is_reported_as_the_start_or_the_goal() -> None:
    with pytest.raises(Obstructed) as failure:
        PLANNER.plan(beside(-0.15), beside(0.0), round_the_wall(), seed=0)
    assert failure.value.reason is Reason.GOAL_IN_COLLISION


@pytest.mark.parametrize("planner", PLANNERS)
def test_a_busy_machine_changes_neither_the_path_nor_the_number_of_checks(planner: str) -> None:
    quick, free = plan(2, planner), round_the_wall()

    def slowly(q: Array) -> bool:
        time.sleep(1e-4)
        return free(q)

    slow = PLANNER.plan(beside(-0.15), beside(0.15), slowly, 2, planner)
    assert np.array_equal(slow.corners, quick.corners) and slow.checks == quick.checks


ENDS = beside(-0.15), beside(0.15)


def walled_off(q: Array) -> bool:
    """Return whether `q` is on one of two islands, each around one end of a motion."""
    return any(float(np.abs(q - end).max()) < 0.05 for end in ENDS)


@pytest.mark.parametrize("planner", PLANNERS)
def test_a_search_that_cannot_succeed_ends_after_a_bounded_number_of_checks(planner: str) -> None:
    found = []
    for _ in range(2):
        with pytest.raises(NoPathFound) as failure:
            PLANNER.plan(*ENDS, walled_off, 0, planner)
        assert failure.value.reason is Reason.NO_PATH
        found.append(failure.value.evidence["checks"])
    assert found[0] == found[1] and MAXIMUM_CHECKS <= found[0] < 1.05 * MAXIMUM_CHECKS


@pytest.mark.parametrize("planner", PLANNERS)
def test_a_search_ends_even_if_the_planner_checks_nothing(
    planner: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(planning, "MAXIMUM_ROUNDS", 5)
    with pytest.raises(NoPathFound, match="no path after"):
        PLANNER.plan(*ENDS, walled_off, 0, planner)


def test_a_goal_slightly_beyond_a_limit_counts_as_at_the_limit() -> None:
    start, goal = ENDS[0], ENDS[1].copy()
    goal[0] = ROBOT.limits.upper[0] + 5e-7

    def beside_a_post(q: Array) -> bool:
        return not (0.5 < q[0] < 0.6 and abs(q[1] - start[1]) < 0.3)

    path = PLANNER.plan(start, goal, beside_a_post, seed=0)
    assert path.planner == "rrt_connect" and ROBOT.limits.contains(path.corners[-1])
    assert np.allclose(path.corners[-1], goal)


def test_a_check_depends_on_the_state_that_is_passed_and_on_no_other() -> None:
    wall = walled()
    away = replace(wall, poses={name: Pose((0.0, 0.6, 0.025), UPRIGHT) for name in SHAPES})
    low, over = beside(0.0), SOLVER.solve(tool_pointing_down(0.52, 0.0, 0.19), ROBOT.home)
    assert over is not None
    holding = wall.with_held(HeldBody("brick0", Pose((0.0, 0.0, 0.02), UPRIGHT)))
    states = [wall, away, wall.moved("brick5", away.poses["brick5"]), holding, holding.without_held()]
    states += [wall.with_opening(0.0), SCENE.tolerating(low, wall)]
    tool, shift = tool_pointing_down(0.52, 0.0, 0.1), np.array([0.1, 0.0, 0.0])

    def answers(scene: CollisionScene, state: SceneState) -> list[float]:
        return [
            scene.clearance(low, state),
            scene.clearance(over, state),
            scene.hand_is_free(tool, state, margin=0.0),
            scene.distance("brick4", "brick5", state),
            scene.distance_to_others("brick5", [shift], state),
        ]

    alone = [answers(CollisionScene(ROBOT, SHAPES), state) for state in states]
    assert len(set(map(str, alone))) >= 5
    for k in np.random.default_rng(0).integers(len(states), size=50):
        assert answers(SCENE, states[k]) == alone[k]


def test_what_is_near_at_the_start_may_be_as_near_but_not_nearer() -> None:
    start, wall = beside(0.15), walled()

    def under_a_finger(state: SceneState, z: float) -> SceneState:
        return state.moved("brick0", Pose((0.52, 0.195, z), UPRIGHT))

    near = under_a_finger(wall, 0.047)
    tolerating = SCENE.tolerating(start, near)
    assert not SCENE.is_free(start, near) and SCENE.is_free(start, tolerating)
    assert SCENE.is_free(start, under_a_finger(tolerating, 0.045))
    assert not SCENE.is_free(start, under_a_finger(tolerating, 0.05))


def test_a_held_body_is_checked_and_a_hand_without_an_arm_too() -> None:
    over = SOLVER.solve(tool_pointing_down(0.52, 0.0, 0.19), ROBOT.home)
    assert over is not None and SCENE.is_free(over, walled())
    stacked = SceneState({name: Pose((0.52, 0.0, 0.125), UPRIGHT) for name in SHAPES}, 0.04)
    holding = stacked.with_held(HeldBody("brick0", Pose((0.0, 0.0, 0.0), UPRIGHT)))
    assert SCENE.clearance(over, holding) < 0.0 or SCENE.is_free(over, holding, margin=0.0)
    assert SCENE.drop_height(over, holding, 1.0) == pytest.approx(0.015, abs=1e-3)
    assert not SCENE.hand_is_free(tool_pointing_down(0.52, 0.0, 0.1), stacked, margin=0.0)
    assert SCENE.hand_is_free(tool_pointing_down(0.52, 0.3, 0.1), stacked, margin=0.0)


def test_a_straight_line_is_straight_and_keeps_its_orientation() -> None:
    start = beside(0.1)
    tool = SOLVER.forward(start)
    low = tool.copy()
    low[:3, 3] += 0.03, -0.02, -0.05
    line = StraightLines(ROBOT).follow(start, [low])
    assert line is not None
    way = low[:3, 3] - tool[:3, 3]
    for q in line:
        reached = SOLVER.forward(q)
        along = reached[:3, 3] - tool[:3, 3]
        off = along - way * float(along @ way) / float(way @ way)
        assert np.linalg.norm(off) < 5e-4
        assert angle_between(reached[:3, :3], low[:3, :3]) < 2e-3
    assert np.allclose(SOLVER.forward(line[-1])[:3, 3], low[:3, 3], atol=5e-4)


def test_a_line_out_of_reach_is_none() -> None:
    far = tool_pointing_down(1.3, 0.0, 0.2)
    assert StraightLines(ROBOT).follow(beside(0.1), [far]) is None


def test_a_trajectory_keeps_to_the_limits_and_ends_at_rest() -> None:
    path = plan(1)

    def free(chain: Array) -> bool:
        return all(map(round_the_wall(), chain))

    trajectory = time_parameterise(round_corners(path.corners, free), ROBOT.limits)
    velocity = np.diff(trajectory.positions, axis=0) / TIME_STEP
    acceleration = np.diff(velocity, axis=0) / TIME_STEP
    jerk = np.diff(acceleration, axis=0) / TIME_STEP
    assert (np.abs(velocity) <= ROBOT.limits.velocity).all()
    assert (np.abs(acceleration) <= 2 * ACCELERATION_SHARE * ROBOT.limits.acceleration).all()
    assert (np.abs(jerk) <= ROBOT.limits.jerk).all()
    assert np.allclose(trajectory.positions[-1], path.corners[-1])
    assert np.allclose(trajectory.velocities[-1], 0.0)
    back = trajectory.reversed()
    assert np.array_equal(back.positions[::-1], trajectory.positions)


def test_no_point_of_the_arm_goes_far_between_two_checks(robot: Robot) -> None:
    """No farther than the outermost link in a step, whichever joints a straight edge moves."""
    model = models.mujoco_model(robot)
    data, planner, limits = mujoco.MjData(model), Planner(robot), robot.limits
    generator = np.random.default_rng(0)
    step = RESOLUTION * float(lever_arms(robot).max())

    def links(q: Array) -> Array:
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        return np.array(data.geom_xpos)

    for _ in range(20):
        start, goal = generator.uniform(limits.lower, limits.upper, (2, robot.dof))
        checked: list[Array] = []
        planner.plan(start, goal, lambda q: not checked.append(q), seed=0)  # noqa: B023
        along = sorted(checked, key=lambda q: float((q - start) @ (goal - start)))
        assert np.array_equal(along[0], start) and np.allclose(along[-1], goal)
        places = np.array([links(q) for q in along])  # (n, geoms, 3)
        assert float(np.linalg.norm(np.diff(places, axis=0), axis=2).max()) <= step
