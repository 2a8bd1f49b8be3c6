"""The planned worlds: a simulated cell with an arm; every primitive is a planned motion and a friction grasp.

This and `arm_bodies` are the modules that know `kinematics`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from math import atan2, cos, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinematics.errors import NoDisplay, Reason, UnusableRobot, UnusableShape
from kinematics.geometry.transforms import Pose
from kinematics.robot.robot import Robot, with_base_at
from kinematics.robot.robot import load as load_robot
from kinematics.shapes.bodies import TABLE
from kinematics.simulation import pybullet_loading
from kinematics.simulation.engines import cell_in
from kinematics.simulation.simulated_cell import GRIP_FORCE
from kinematics.skills import skills
from kinematics.skills.workspace import workspace_of
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics import predicates
from ntp_dsl.semantics.free_space import free_places, height_below, load
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.layout import angle_between_lines, bottom_of, places_beside, yaw
from ntp_dsl.semantics.observation import Argument, DeclaredFact, Observation
from ntp_dsl.worlds.arm_bodies import bodies_of, with_spread
from ntp_dsl.worlds.observer import Observer
from ntp_dsl.worlds.places import table_regions
from ntp_dsl.worlds.protocol import UNDISTURBED, Disturbances, Failure, Outcome, Scene
from ntp_dsl.worlds.starts import CENTRE, furniture_positions

IMPULSE = 0.12  # of a push: enough to topple an object [N s]
MOVED = 0.005  # from where a disturbance counts as having moved an object [m]
LIKE_FAILURES = 3  # after so many in a row an object is unreachable until it moves

FAILURES: Mapping[Reason, Failure] = {
    Reason.UNKNOWN_BODY: Failure.MISSING_OBJECT,
    Reason.UNUSABLE_POSE: Failure.MISSING_OBJECT,
    Reason.UNREACHABLE: Failure.NO_IK,
    Reason.HAND_FULL: Failure.NOT_READY,
    Reason.HAND_CLOSED: Failure.NOT_READY,
    Reason.TARGET_IN_HAND: Failure.NOT_READY,
    Reason.NOT_ABOVE: Failure.NOT_READY,
    Reason.START_IN_COLLISION: Failure.START_IN_COLLISION,
    Reason.GOAL_IN_COLLISION: Failure.GOAL_IN_COLLISION,
    Reason.NO_PATH: Failure.NO_PATH,
    Reason.SUPPORT_TILTED: Failure.PLACE_FAILED,
    Reason.NO_GRASP: Failure.GRASP_FAILED,
    Reason.NO_FREE_PLACE: Failure.NO_PATH,
    Reason.GRASP_FAILED: Failure.GRASP_FAILED,
    Reason.GRASP_SLIPPED: Failure.GRASP_FAILED,
    Reason.OBJECT_DROPPED: Failure.OBJECT_DROPPED,
    Reason.PLACEMENT_FAILED: Failure.PLACE_FAILED,
    Reason.PUSH_FAILED: Failure.PLACE_FAILED,
    Reason.NOT_ARRIVED: Failure.NO_PATH,
    Reason.STOPPED: Failure.TIME_OUT,
}


class ArmWorld:
    """Gravity, friction and an arm. Nothing is attached by a constraint or placed by hand."""

    starts_holding = False

    def __init__(self, engine: str, arm: str | None = None, gui: bool = False) -> None:
        """Make the world of an engine, `bullet` or `mujoco`.

        Raises `NtpError` for an arm that cannot be used, and for a window where there is no display.
        """
        self.engine = engine
        try:
            self._cell = cell_in(engine, _standing(arm), gui)
        except UnusableRobot as unusable:
            raise NtpError(f"--arm: {unusable}") from unusable
        except NoDisplay as unexpected:
            raise NtpError(f"--gui: {unexpected}") from unexpected
        if pybullet_loading.is_installed():  # its renderer draws the pictures of both engines
            self.render: Callable[[int, int], NDArray[np.uint8]] = self._cell.render
        self.on_frame: Callable[[Observation], None] | None = None
        self.disturbed: set[str] = set()
        self.facts: frozenset[DeclaredFact] = frozenset()
        self.skills: dict[str, Callable[..., Outcome]] = {
            "move_to": self._move_to,
            "grasp": self._grasp,
            "release": self._release,
            "move_beside": self._move_beside,
            "turn_held": self._turn_held,
            "align_held": self._align_held,
        }

    def reset(self, scene: Scene, seed: int, disturbances: Disturbances = UNDISTURBED) -> None:
        if scene.held is not None:
            raise NtpError(f"the {self.engine} world cannot start with an object in the hand")
        self._cell.on_frame = None
        try:
            bodies = [with_spread(body, seed, disturbances.spread) for body in bodies_of(scene)]
            self._observer = Observer(seed, disturbances)
            self._cell.reset(
                bodies,
                seed,
                camera_offset=self._observer.camera_offset,
                grip=GRIP_FORCE * (1 - disturbances.weak_grip),
            )
        except UnusableShape as error:
            raise NtpError(
                f"the {self.engine} world cannot make {error}; give the object another size"
            ) from error
        self._cell.on_frame = self._emit
        self._objects = scene.objects
        self._furniture = furniture_positions(scene.objects)
        self._regions = table_regions(scene)
        self._disturbances = disturbances
        self.facts = scene.facts
        self._seed, self._calls = seed, 0
        self._failed: Counter[str] = Counter()
        self._failed_at: dict[str, Vector] = {}
        self.disturbed = set()

    # Observations -------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        return self._cell.time

    def truth(self) -> Observation:
        poses = self._cell.poses()
        positions = {name: pose.position for name, pose in poses.items()}
        return Observation(
            self._objects,
            positions | self._furniture,
            self._cell.tool_position(),
            self._cell.hand_closed,
            self._unreachable(positions),
            {name: pose.quaternion_xyzw for name, pose in poses.items()},
            facts=self.facts,
        )

    def observe(self) -> Observation:
        return self._observer.observe(self.truth(), self.time)

    def supported(self, item: str, support: str) -> bool:
        """Return whether they touch; in a container, an item may lie on other contents."""
        below = TABLE if support in self._furniture else support
        if self._cell.contacts(item, below):
            return True
        seen = self.truth()
        heap = set(load(seen, support))
        touched, reached = set(), {item} & heap
        while reached:
            touched |= reached
            if any(self._cell.contacts(each, support) for each in reached):
                return True
            reached = {
                each for each in heap - touched if any(self._cell.contacts(each, other) for other in reached)
            }
        return False

    def settle(self, seconds: float) -> None:
        self._cell.settle(seconds)

    # Primitives ---------------------------------------------------------------------------------

    def call(self, api: str, arguments: tuple[Argument, ...]) -> Outcome:
        self._calls += 1
        self._rng = np.random.default_rng((self._seed, self._calls))
        try:
            outcome = self.skills[api](*arguments)
        except NoDisplay as closed:
            raise NtpError(f"--gui: {closed}") from closed
        self._remember(outcome, str(arguments[0]) if arguments else "")
        self._emit()
        self._cell.settle(self._disturbances.latency)  # until what came of it is seen
        return outcome

    def move_over(self, x: float, y: float) -> Outcome:
        height = height_below(self.truth(), x, y)
        return self._go(lambda seed, slip: skills.move_above_place(self._cell, x, y, seed, slip, height))

    def _move_to(self, target: str) -> Outcome:
        seen = self.truth()
        surface = seen.by_name.get(target)
        if surface is not None and surface.flat:
            places = free_places(seen, target, self._regions)
            top = seen.positions[target][2] + surface.size[2] / 2
            return self._go(lambda seed, slip: skills.move_above_places(self._cell, places, top, seed, slip))
        return self._go(lambda seed, slip: skills.move_above(self._cell, target, seed, slip))

    def _move_beside(self, item: str, other: str, side: str) -> Outcome:
        seen = self.truth()
        if other not in seen.positions:
            return Outcome(False, Failure.MISSING_OBJECT, {"other": other})
        if self._cell.held() != item:
            return Outcome(False, Failure.NOT_READY, {"in hand": self._cell.held() or "nothing"})
        places, level = places_beside(seen, item, other, side), bottom_of(seen, other)
        return self._go(lambda seed, slip: skills.move_above_places(self._cell, places, level, seed, slip))

    def _turn_held(self, item: str, to: float) -> Outcome:
        if self._cell.held() != item:
            return Outcome(False, Failure.NOT_READY, {"in hand": self._cell.held() or "nothing"})
        by = angle_between_lines(to, yaw(self.truth().orientation(item)))
        return self._go(lambda seed, slip: skills.turn_held(self._cell, by, seed, slip))

    def _align_held(self, item: str, other: str) -> Outcome:
        seen = self.truth()
        if other not in seen.positions:
            return Outcome(False, Failure.MISSING_OBJECT, {"other": other})
        return self._turn_held(item, yaw(seen.orientation(other)))

    def _go(self, move: Callable[[int, float | None], skills.Motion]) -> Outcome:
        """Carry out a motion during which the held object may slip."""
        held = self._cell.held()
        slips = held is not None and self._rng.random() < self._disturbances.slips
        slip_at = float(self._rng.uniform(0.1, 0.9)) if slips else None
        before = self._cell.poses()
        motion = move(self._call_seed(), slip_at)
        if slip_at is None or motion.reason is not Reason.OBJECT_DROPPED:
            return _outcome(motion)
        self.disturbed |= {str(held), *self._displaced(before)}
        return _outcome(motion, (f"slip {held}",))

    def _grasp(self, target: str) -> Outcome:
        return _outcome(skills.grasp(self._cell, target, self._call_seed()))

    def _release(self) -> Outcome:
        held = self._cell.held()
        motion = skills.release(self._cell, self._call_seed())
        if held is None:
            return Outcome(False, Failure.NOT_READY, {"in hand": "nothing"})
        if not motion.achieved:
            return _outcome(motion)
        return _outcome(motion, self._push(held))

    def _push(self, item: str) -> tuple[str, ...]:
        """Apply, at random, an impulse after a placement on another object: it may topple the tower."""
        seen = self.truth()
        stacked = any(
            predicates.on(seen, item, other) and seen.by_name[other].movable for other in self._cell.bodies
        )
        if not stacked or self._rng.random() >= self._disturbances.pushes:
            return ()
        before = self._cell.poses()
        angle = self._inward(before[item].position) + float(self._rng.uniform(-pi / 3, pi / 3))
        self._cell.push(item, IMPULSE, (cos(angle), sin(angle)))
        self.disturbed |= self._displaced(before)
        return (f"push {item}",)

    def _inward(self, position: Vector) -> float:
        """Return the direction of the workspace's centre [rad]: a pushed object must stay within reach."""
        return atan2(CENTRE[1] - position[1], CENTRE[0] - position[0])

    def _displaced(self, before: Mapping[str, Pose]) -> set[str]:
        """Return the bodies that have moved, except for the held one."""
        now = self._cell.poses()
        return {
            name
            for name, pose in before.items()
            if float(np.linalg.norm(np.subtract(pose.position, now[name].position))) > MOVED
        } - {str(self._cell.held())}

    # Facts --------------------------------------------------------------------------------------

    def _remember(self, outcome: Outcome, target: str) -> None:
        """Count failures: a target that fails repeatedly is unreachable until it moves."""
        if target not in self._cell.bodies:
            return
        if outcome.achieved or outcome.failure in (Failure.NOT_READY, Failure.OBJECT_DROPPED):
            self._failed.pop(target, None)
            return
        self._failed[target] += 1
        self._failed_at[target] = self._cell.pose(target).position

    def _unreachable(self, positions: Mapping[str, Vector]) -> frozenset[str]:
        return frozenset(
            name
            for name, times in self._failed.items()
            if times >= LIKE_FAILURES
            and float(np.linalg.norm(np.subtract(positions[name], self._failed_at[name]))) < MOVED
        )

    def _call_seed(self) -> int:
        return int(np.random.SeedSequence((self._seed, self._calls)).generate_state(1)[0])

    def _emit(self) -> None:
        if self.on_frame is not None:
            self.on_frame(self.observe())
        elif self._disturbances.latency:
            self._observer.note(self.truth(), self.time)


def _outcome(motion: skills.Motion, disturbances: tuple[str, ...] = ()) -> Outcome:
    evidence: dict[str, Any] = dict(motion.evidence)
    if motion.reason is not None:
        evidence["reason"] = str(motion.reason)
    return Outcome(
        motion.achieved,
        FAILURES[motion.reason] if motion.reason is not None else None,
        evidence,
        motion.planning_seconds,
        motion.moving_seconds,
        motion.solver,
        motion.planner,
        disturbances,
    )


def _standing(arm: str | None) -> Robot:
    """Return an arm, placed so that its workspace is centred where objects start."""
    robot = load_robot(arm or "panda")
    (x0, x1), (y0, y1) = workspace_of(robot).region
    return with_base_at(robot, CENTRE[0] - (x0 + x1) / 2, CENTRE[1] - (y0 + y1) / 2)
