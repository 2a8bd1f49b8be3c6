"""From a scene's state to the bodies of a MuJoCo model."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from kinematics.collision.models import PARKED
from kinematics.collision.scene_state import SceneState
from kinematics.geometry.transforms import Pose, pose_of, wxyz
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot


def geoms_of(model: Any, body: str) -> Any:
    """Return the indices of all geoms of a body of a model."""
    first, count = int(model.body(body).geomadr[0]), int(model.body(body).geomnum[0])
    return np.arange(first, first + count)


def mocap_ids(model: Any, names: Iterable[str]) -> dict[str, int]:
    """Return the indices of the scene's bodies among the model's mocap bodies."""
    return {name: int(model.body(f"body_{name}").mocapid[0]) for name in names}


def place_bodies(data: Any, mocap: Mapping[str, int], state: SceneState) -> None:
    """Put every body at its pose, and park absent ones."""
    for name, index in mocap.items():
        if name in state.absent:
            data.mocap_pos[index] = PARKED
        else:
            data.mocap_pos[index] = state.poses[name].position
            data.mocap_quat[index] = wxyz(state.poses[name].quaternion_xyzw)


def place_held(model: Any, geoms: Any, pose_in_tool: Pose) -> None:
    """Put the body with these geoms into the hand."""
    _place(model, int(model.geom_bodyid[geoms[0]]), pose_in_tool)


def place_fingers(model: Any, robot: Robot, opening: float, prefix: str) -> None:
    """Put the fingers of the arm, or of its ghost, each this far from the middle [m]."""
    for link, transform in gripper_of(robot).link_poses(opening).items():
        _place(model, model.body(prefix + link).id, pose_of(transform))


def _place(model: Any, body: int, pose: Pose) -> None:
    model.body_pos[body] = pose.position
    model.body_quat[body] = wxyz(pose.quaternion_xyzw)
