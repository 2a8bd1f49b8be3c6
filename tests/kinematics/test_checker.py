"""The collision checker agrees with a second one, on random configurations among bodies of every shape."""

import math
from pathlib import Path

import numpy as np
import pytest
from kinematics_coal import CoalChecker

from kinematics.collision.scene import MARGIN, CollisionScene
from kinematics.collision.scene_state import SceneState
from kinematics.geometry.transforms import Pose
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot
from kinematics.shapes.catalogue import bowl, prism, tub
from kinematics.shapes.shapes import Box, Cylinder, Shape, Sphere

SHAPES: dict[str, Shape] = {
    "cube": Box((0.05, 0.05, 0.05)),
    "pillar": Box((0.03, 0.03, 0.3)),
    "can": Cylinder(0.06, 0.2),
    "ball": Sphere(0.08),
    "prism": prism(6, 0.07, 0.12),
    "bowl": bowl(),
    "bin": tub(),
}
TOLERANCE = 1e-5  # within which the two checkers may disagree [m]


def test_two_checkers_agree_on_what_touches_and_on_how_near(robot: Robot, soak: bool, tmp_path: Path) -> None:
    generator = np.random.default_rng(0)
    scene = CollisionScene(robot, SHAPES)
    limits, seen = robot.limits, {True: 0, False: 0}
    for _ in range(50 if soak else 3):
        poses = {}
        for body in SHAPES:
            angle = generator.uniform(-math.pi, math.pi)
            radius, yaw = generator.uniform(0.25, 0.7), generator.uniform(-1.5, 1.5)
            place = (radius * math.cos(angle), radius * math.sin(angle), generator.uniform(0.05, 0.6))
            poses[body] = Pose(place, (0.0, 0.0, math.sin(yaw), math.cos(yaw)))
        state = SceneState(poses, gripper_of(robot).maximum_opening)
        other = CoalChecker(robot, SHAPES, poses, tmp_path)
        for q in generator.uniform(limits.lower, limits.upper, (100 if soak else 40, robot.dof)):
            ours, theirs = scene.clearance(q, state), other.distance(q)
            if abs(theirs) > TOLERANCE:
                assert (ours < 0) == (theirs < 0), (q, ours, theirs, scene.contacts(q, state))
                seen[theirs < 0] += 1
            if TOLERANCE < theirs < MARGIN - TOLERANCE:
                assert ours == pytest.approx(theirs, abs=TOLERANCE)
    assert min(seen.values()) > 10
