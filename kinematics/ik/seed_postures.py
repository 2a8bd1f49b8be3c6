"""From a tool transform to joint positions that put the tool near it, from which an iteration starts."""

import numpy as np
from scipy.spatial import cKDTree

from kinematics.geometry.transforms import Array

APPROXIMATION = 1.0  # a seed need not be the very nearest; this halves the time
METRES_PER_RADIAN = 0.3  # weight of a rotation against a translation [m/rad]


class SeedPostures:
    """Random joint positions, indexed by the tool transforms that they give."""

    def __init__(self, joints: Array, tools: Array) -> None:
        self._joints = joints  # (n, dof) [rad]
        self._tree = cKDTree(np.array([_features(tool) for tool in tools]))

    def near(self, target: Array, count: int) -> Array:
        """Return joint positions (count, dof) whose tools are nearest to the target transform."""
        nearest = self._tree.query(_features(target), k=count, eps=APPROXIMATION)[1]
        found: Array = self._joints[nearest].reshape(count, -1)
        return found


def _features(tool: Array) -> Array:
    """Return position, approach and closing direction (9,)."""
    return np.concatenate([tool[:3, 3], METRES_PER_RADIAN * tool[:3, 2], METRES_PER_RADIAN * tool[:3, 1]])
