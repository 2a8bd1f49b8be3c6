"""From a robot to the pairs of its links that touch by construction, which no check of collisions counts."""

import itertools
from collections import Counter
from typing import Any

import mujoco
import numpy as np

from kinematics.collision.models import CONFIGURATIONS, MARGIN
from kinematics.errors import UnusableRobot
from kinematics.geometry.transforms import Array, pose_of, wxyz
from kinematics.robot import models
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot

ALWAYS = 0.95  # share of random configurations from which a contact of two links counts as built in

Pair = tuple[str, str]  # of links, in the order of the model


@models.per_robot
def always_touching(robot: Robot) -> tuple[Pair, ...]:
    """Return the pairs of links that are nearer than `MARGIN` by construction.

    Those are nearer nearly everywhere, or at home where one joint connects them; all within the hand, whose
    joints no path moves; and those that the TOML allows. Raise `UnusableRobot` for any other pair at home.
    """
    contacts = _SelfContacts(robot)
    limits = robot.limits
    counts: Counter[Pair] = Counter()
    for q in np.random.default_rng(0).uniform(limits.lower, limits.upper, (CONFIGURATIONS, robot.dof)):
        counts.update(contacts.distances(q).keys())
    built = {pair for pair, count in counts.items() if count >= ALWAYS * CONFIGURATIONS}
    built |= set(map(contacts.ordered, robot.allowed_collisions))
    built |= set(itertools.combinations(sorted(robot.hand_links, key=contacts.index), 2))
    at_home = contacts.distances(robot.home)
    adjacent = {contacts.ordered((joint.parent, joint.child)) for joint in robot.urdf.joints.values()}
    built |= adjacent & at_home.keys()
    if faults := {pair: distance for pair, distance in at_home.items() if pair not in built}:
        raise UnusableRobot(_told(robot, faults))
    return tuple(sorted(built))


def _told(robot: Robot, faults: dict[Pair, float]) -> str:
    """Return what is wrong with `home`, the worst pair first."""
    told = [
        f"'{first}' and '{second}' " + (f"overlap by {-mm:.1f} mm" if mm < 0 else f"are {mm:.1f} mm apart")
        for mm, (first, second) in sorted((1000 * distance, pair) for pair, distance in faults.items())
    ]
    return (
        f"{robot.name}: at `home` the arm is in collision with itself: {', '.join(told)} (plans keep "
        f"{1000 * MARGIN:g} mm); give another `home`, or, if only the meshes are at fault, list the pairs "
        "under `allowed_collisions` in the TOML"
    )


class _SelfContacts:
    """The arm alone in MuJoCo, with an open hand."""

    def __init__(self, robot: Robot) -> None:
        spec = models.mujoco_spec(robot)
        for geom in spec.geoms:
            geom.margin = MARGIN
        self._model: Any = models.compiled(spec, robot)
        self._data = mujoco.MjData(self._model)
        gripper = gripper_of(robot)
        for link, transform in gripper.link_poses(gripper.maximum_opening).items():
            body, pose = self.index(link), pose_of(transform)
            self._model.body_pos[body] = pose.position
            self._model.body_quat[body] = wxyz(pose.quaternion_xyzw)

    def index(self, link: str) -> int:
        """Return the number of a link in the model."""
        return int(self._model.body(link).id)

    def ordered(self, pair: Pair) -> Pair:
        """Return two links in the order of the model."""
        first, second = sorted(pair, key=self.index)
        return first, second

    def distances(self, q: Array) -> dict[Pair, float]:
        """Return the pairs nearer than `MARGIN`, with their least distances; negative in overlap [m]."""
        self._data.qpos[:] = q
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        contacts = self._data.contact
        bodies = np.sort(self._model.geom_bodyid[contacts.geom], axis=1).tolist()
        found: dict[Pair, float] = {}
        for (a, b), distance in zip(bodies, contacts.dist.tolist(), strict=True):
            if distance < MARGIN:  # MuJoCo reports contacts up to the sum of two margins
                pair = (self._model.body(a).name, self._model.body(b).name)
                found[pair] = min(distance, found.get(pair, MARGIN))
        return found
