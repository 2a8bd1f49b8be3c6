"""Bodies of many shapes are picked up, put down, stacked and dropped into containers."""

import math
from pathlib import Path

import numpy as np
import pytest

from kinematics.errors import Reason, UnusableShape
from kinematics.geometry.urdf import resolved_path
from kinematics.robot.robot import Robot
from kinematics.shapes.bodies import Body
from kinematics.shapes.catalogue import bowl, compound_from_urdf, fork, hull_from_mesh, prism, tub
from kinematics.shapes.containers import is_inside
from kinematics.shapes.shapes import Box, Cylinder, Hull, Shape, Sphere, half_extents_of, reach_of, support
from kinematics.simulation.engines import ENGINES, cell_in
from kinematics.simulation.simulated_cell import SimulatedCell
from kinematics.skills.routines import drop_into, pick, place, put_down
from kinematics.skills.workspace import workspace_of

DUCK = resolved_path("package://pybullet_data/duck_vhacd.obj", Path())
SHAPES: dict[str, tuple[Shape, float]] = {
    "cube": (Box((0.015, 0.015, 0.015)), 0.05),
    "tall box": (Box((0.02, 0.03, 0.07)), 0.2),
    "flat box": (Box((0.03, 0.04, 0.006)), 0.05),
    "cylinder": (Cylinder(0.014, 0.036), 0.05),
    "can": (Cylinder(0.03, 0.09), 0.2),
    "ball": (Sphere(0.015), 0.03),
    "hexagon": (prism(6, 0.018, 0.03), 0.05),
    "triangle": (prism(3, 0.025, 0.04), 0.05),
    "bowl": (bowl(), 0.12),
    "fork": (fork(), 0.02),
    "thin fork": (fork(thickness=0.004), 0.02),
    "mesh": (hull_from_mesh(DUCK, 0.04), 0.08),
}
BIN = Body("bin", tub(), (0.5, 0.3, 0.0425), mass=0.0)
BASE = Body("base", Box((0.04, 0.04, 0.02)), (0.5, 0.12, 0.02), mass=0.5)


def standing(name: str, shape: Shape, mass: float, x: float, y: float, yaw: float) -> Body:
    """Return a body on the table, upright."""
    height = support(shape, np.array([0.0, 0.0, -1.0])) + 1e-4
    return Body(name, shape, (x, y, height), (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)), mass)


def scene(cell: SimulatedCell, shape: Shape, mass: float, seed: int) -> None:
    generator = np.random.default_rng(seed)
    x, y = generator.uniform((0.38, -0.15), (0.62, -0.05))
    item = standing("item", shape, mass, x, y, generator.uniform(-math.pi, math.pi))
    cell.reset([item, BIN, BASE], seed)


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_is_picked_up_and_dropped_into_a_bin(cell: SimulatedCell, name: str, soak: bool) -> None:
    shape, mass = SHAPES[name]
    for seed in range(20 if soak else 1):
        scene(cell, shape, mass, seed)
        for motion in (pick(cell, "item", seed), drop_into(cell, "bin", seed)):
            assert motion.achieved, (seed, motion)
        assert is_inside(BIN.shape, BIN.pose, cell.pose("item").position)


@pytest.mark.parametrize("name", ["cylinder", "bowl", "fork", "hexagon"])
def test_a_shape_is_put_down_free_of_everything(cell: SimulatedCell, name: str, soak: bool) -> None:
    shape, mass = SHAPES[name]
    for seed in range(20 if soak else 1):
        scene(cell, shape, mass, 100 + seed)
        for motion in (pick(cell, "item", seed), put_down(cell, seed)):
            assert motion.achieved, (seed, motion)
        assert cell.contacts("item", "table") and not cell.contacts("item", "base")


@pytest.mark.parametrize("thickness", [0.004, 0.006])
@pytest.mark.parametrize("engine", ENGINES)
def test_small_forks_are_picked_up_by_every_arm(
    robot: Robot, engine: str, thickness: float, soak: bool
) -> None:
    (x0, x1), (y0, y1) = workspace_of(robot).region
    with cell_in(engine, robot) as cell:
        for seed in range(20 if soak else 2):
            generator = np.random.default_rng(seed)
            x, y = generator.uniform((x0 + 0.05, y0 + 0.05), (x1 - 0.05, y1 - 0.05))
            yaw = generator.uniform(-math.pi, math.pi)
            cell.reset([standing("fork", fork(thickness=thickness), 0.02, x, y, yaw)], seed)
            motion = pick(cell, "fork", seed)
            assert motion.achieved, (seed, motion)


def test_what_stands_upright_stays_where_it_is_put(cell: SimulatedCell) -> None:
    """At whatever yaw, to the last bit: MuJoCo's plane throws such cylinders now and then."""
    generator = np.random.default_rng(0)
    for seed in range(4):
        bodies = [
            standing(f"{k}", shape, 0.05, 0.25 + 0.15 * (k % 5), 0.2 * (k // 5) - 0.4, yaw)
            for k, yaw in enumerate(generator.uniform(-math.pi, math.pi, 25).tolist())
            for shape in [(Cylinder(0.015, 0.03), Cylinder(0.03, 0.06), bowl())[k % 3]]
        ]
        cell.reset(bodies, seed)
        cell.settle(0.5)
        moved = [math.dist(cell.pose(body.name).position, body.position) for body in bodies]
        assert max(moved) < 2e-3


def test_a_can_is_placed_on_a_base(cell: SimulatedCell) -> None:
    scene(cell, *SHAPES["can"], seed=3)
    for motion in (pick(cell, "item", 3), place(cell, "base", 3)):
        assert motion.achieved, motion
    assert cell.contacts("item", "base")
    assert math.dist(cell.pose("item").position[:2], cell.pose("base").position[:2]) < 3e-3


def test_a_bowl_nests_in_another_and_holds_a_fork(cell: SimulatedCell) -> None:
    lower = standing("lower", bowl(), 0.12, 0.45, 0.12, 0.3)
    upper = standing("upper", bowl(), 0.12, 0.5, -0.1, 1.0)
    cutlery = standing("fork", fork(), 0.02, 0.36, -0.12, 0.4)
    cell.reset([lower, upper, cutlery], 0)
    for motion in (pick(cell, "fork", 0), drop_into(cell, "lower", 0)):
        assert motion.achieved, motion
    assert is_inside(lower.shape, cell.pose("lower"), cell.pose("fork").position)
    for motion in (pick(cell, "upper", 1), place(cell, "lower", 1)):
        assert motion.achieved, motion
    pitch = cell.pose("upper").position[2] - cell.pose("lower").position[2]
    assert pitch == pytest.approx(0.052, abs=2e-3)


def test_nothing_is_dropped_into_a_body_without_a_cavity(cell: SimulatedCell) -> None:
    scene(cell, *SHAPES["cube"], seed=0)
    assert pick(cell, "item", 0).achieved
    before = cell.time
    assert drop_into(cell, "base", 0).reason is Reason.PLACEMENT_FAILED
    assert cell.time == before


@pytest.mark.parametrize("name", SHAPES)
def test_the_support_of_a_shape_bounds_it(name: str) -> None:
    shape, _ = SHAPES[name]
    x, y, z = half_extents_of(shape)
    for direction in np.random.default_rng(0).normal(size=(50, 3)):
        direction /= np.linalg.norm(direction)
        assert support(shape, direction) <= np.abs(direction) @ (x, y, z) + 1e-9
    level = np.array([math.cos(0.3), math.sin(0.3), 0.0])
    assert support(shape, level) <= reach_of(shape) * 1.01


def test_the_hull_of_a_mesh_is_centred_on_its_bounding_box() -> None:
    hull = hull_from_mesh(DUCK, 0.04)
    assert isinstance(hull, Hull)
    points = np.array(hull.points)
    assert np.allclose(points.min(axis=0), -points.max(axis=0))


def test_a_urdf_of_one_link_is_a_shape_and_any_other_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "mug.urdf"
    parts = '<collision><origin xyz="0 0 0.01"/><geometry><box size="0.04 0.03 0.02"/></geometry></collision>'
    path.write_text(f'<robot name="mug"><link name="mug">{parts}</link></robot>')
    shape = compound_from_urdf(path)
    assert half_extents_of(shape) == pytest.approx((0.02, 0.015, 0.02))
    path.write_text('<robot name="mug"><link name="mug"/></robot>')
    with pytest.raises(UnusableShape, match="expected one link with collision geometry"):
        compound_from_urdf(path)
