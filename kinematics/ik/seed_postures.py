"""From a tool transform to joint positions that put the tool near it: what an iteration starts from."""

import numpy as np
from scipy.spatial import cKDTree

from kinematics.geometry.transforms import Array

ROUGHLY = 1.0  # a start need not be the very nearest; this halves the time
METRES_PER_RADIAN = 0.3  # how far a turned tool counts as a moved one [m/rad]


class Postures:
    """Random joint positions within the limits, found again by where they put the tool."""

    def __init__(self, joints: Array, tools: Array) -> None:
        self._joints = joints  # (n, dof) [rad]
        self._tree = cKDTree(np.array([_features(tool) for tool in tools]))

    def near(self, target: Array, count: int) -> Array:
        """(count, dof) joint positions whose tools are nearest the target transform."""
        nearest = self._tree.query(_features(target), k=count, eps=ROUGHLY)[1]
        found: Array = self._joints[nearest].reshape(count, -1)
        return found


def _features(tool: Array) -> Array:
    """(9,) position, approach and closing direction."""
    return np.concatenate([tool[:3, 3], METRES_PER_RADIAN * tool[:3, 2], METRES_PER_RADIAN * tool[:3, 1]])
