"""What a skill needs of a cell, simulated or real: motor commands in, measurements out, step by step."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from kinematics.geometry.transforms import Array, Pose
from kinematics.robot.robot import Robot
from kinematics.shapes.bodies import Body
from kinematics.shapes.pose_noise import Noise


class Cell(Protocol):
    """A robot on a table, with bodies. Skills know nothing else of it.

    The arm's base is where the robot's description has it, the table's top is the plane z = 0. A step lasts
    `TIME_STEP`; whoever drives a real arm sleeps that long in `step`. Poses are of bodies' centres, world
    frame; joints are in the order of the robot's description.
    """

    # Read by skills, and set by none.
    @property
    def robot(self) -> Robot: ...

    @property
    def bodies(self) -> Mapping[str, Body]: ...

    @property
    def noise(self) -> Noise:
        """How far observed poses may be off: skills feel their way accordingly."""
        ...

    @property
    def time(self) -> float:
        """Time on the robot's clock [s]."""
        ...

    @property
    def stepping_seconds(self) -> float:
        """Wall time spent in steps so far [s]; skills report it apart from planning."""
        ...

    @property
    def frame_seconds(self) -> float:
        """Wall time spent on whoever watches, inside steps [s]."""
        ...

    stop_requested: bool  # by anybody, at any time; a skill brakes, and the next one sets it back

    # -- measurements ----------------------------------------------------------------------

    def pose(self, name: str) -> Pose:
        """Return the best estimate of a body's pose; raise `UnknownBody` or `UnusablePose`."""
        ...

    def observed_pose(self, name: str) -> Pose:
        """Return a body's pose as one new observation gives it."""
        ...

    def observed_poses(self) -> dict[str, Pose]:
        """Return all bodies' poses as one new observation gives them."""
        ...

    def speed(self, name: str) -> float:
        """Return an upper bound on the speed of any point of the body [m/s]."""
        ...

    def joint_positions(self) -> Array:
        """Return the arm's joint positions (dof,) [rad]."""
        ...

    def joint_torques(self) -> Array:
        """Return the torques of the arm's motors (dof,): skills look at their changes only [N m]."""
        ...

    def tool_pose(self) -> Pose:
        """Return the pose of the tool frame: between the fingertips, z along the approach."""
        ...

    def finger_width(self) -> float:
        """Return the distance between the fingers [m]."""
        ...

    def held(self) -> str | None:
        """Return the body that a closed hand has between its fingers, or None."""
        ...

    def touched(self) -> frozenset[str]:
        """Return the bodies that either finger presses on."""
        ...

    # -- commands --------------------------------------------------------------------------

    def step(self) -> None:
        """Let one time step pass under the present commands."""
        ...

    def settle(self, seconds: float) -> None:
        """Let time pass [s]."""
        ...

    def settle_until_still(self, names: Sequence[str], at_most: float) -> None:
        """Let time pass until the bodies are at rest, `at_most` so long [s]."""
        ...

    def drive_arm(self, position: Sequence[float], velocity: Sequence[float]) -> None:
        """Set the set points of the arm's controllers, with velocity feed-forward [rad], [rad/s]."""
        ...

    def hold(self) -> None:
        """Hold the arm where it is; the fingers keep their command."""
        ...

    def open_fingers(self, opening: float, speed: float = ...) -> None:
        """Command the fingers to an opening [m], each with at most a speed [m/s]."""
        ...

    def close_fingers(self) -> None:
        """Command the fingers to close and to keep pressing."""
        ...

    def weaken_fingers(self) -> None:
        """Disturb the grasp: the fingers lose their force and give way, in spite of their command."""
        ...
