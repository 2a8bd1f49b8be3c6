"""The kinematic world: no forces, but objects rest, fall, slip and topple; thousands of episodes a minute."""

from __future__ import annotations

from collections.abc import Callable
from math import hypot

import numpy as np

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics import predicates
from ntp_dsl.semantics.containers import takes
from ntp_dsl.semantics.free_space import free_places, height_below, place_in
from ntp_dsl.semantics.geometry import Vector, moved, turned_about, turned_by
from ntp_dsl.semantics.layout import angle_between_lines, bottom_of, places_beside, yaw
from ntp_dsl.semantics.observation import TOO_WIDE, Argument, DeclaredFact, Observation, SceneObject
from ntp_dsl.worlds.observer import Observer
from ntp_dsl.worlds.places import table_regions
from ntp_dsl.worlds.protocol import ACHIEVED, UNDISTURBED, Disturbances, Failure, Outcome, Scene
from ntp_dsl.worlds.resting import RestingObjects
from ntp_dsl.worlds.scenes import movable

HOVER = 0.10  # the tool's height over a target's top [m]
HOME: Vector = (0.42, 0.0, 0.45)
PLACEMENT_ERROR = 0.0007  # standard deviation of where a released object ends up [m]
FRAME = 0.1  # [s]
REACH = 0.035  # from where the hand closes around an object below it, seen from above [m]
OFF = 0.035  # from where a clumsy motion should end, along each axis [m]
BELOW_RIM = 0.013  # of a bowl, where it is grasped [m]
TURNING = 1.5  # of the hand about the vertical [rad/s]


class KinematicWorld(RestingObjects):
    """Positions only. A held object follows the tool; a released one falls onto what is below."""

    starts_holding = True
    frame_seconds = FRAME  # between two looks at a motion
    clearance = HOVER

    def __init__(self, placement_error: float = PLACEMENT_ERROR) -> None:
        self._placement_error = placement_error
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
        if disturbances.need_an_arm:
            raise NtpError(
                "the kinematic world has neither friction nor a hand that presses: "
                f"{'--spread' if disturbances.spread else '--weak-grip'} goes with --world bullet or mujoco"
            )
        self._rng = np.random.default_rng(seed)
        self._observer = Observer(seed, disturbances)
        self._objects = scene.objects
        self._by_name = scene.lying
        self._items: dict[str, SceneObject] = {t.name: scene.lying[t.name] for t in movable(scene.objects)}
        on_table = (t for t in scene.objects if t.size[0] <= TOO_WIDE)
        self._solid = {t.name: scene.lying[t.name] for t in on_table}
        self._regions = table_regions(scene)
        self._positions = dict(scene.positions)
        self._orientations = dict(scene.orientations)
        self._disturbances = disturbances
        self.facts = scene.facts
        self._gripper = scene.gripper or HOME
        self._held, self._closed = scene.held, scene.held is not None
        self._load: list[str] = []  # the contents of the held bowl
        if scene.held is not None:
            self._load = self._contents(scene.held)
        self._time = 0.0
        self._speed = float(self._rng.uniform(0.2, 0.6))  # of the tool [m/s]
        self.disturbed = set()

    # Observations -------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        return self._time

    def truth(self) -> Observation:
        return Observation(
            self._objects,
            dict(self._positions),
            self._gripper,
            self._closed,
            orientations=self._orientations,
            facts=self.facts,
        )

    def observe(self) -> Observation:
        return self._observer.observe(self.truth(), self._time)

    def supported(self, item: str, support: str) -> bool:
        seen = self.truth()
        return predicates.inside(seen, item, support) or predicates.on(
            seen, item, support, predicates.ACCEPTED
        )

    def settle(self, seconds: float) -> None:
        end = self._time + seconds
        while self._time + self.frame_seconds < end:
            self._time += self.frame_seconds
            self._emit()
        self._time = end

    # Primitives ---------------------------------------------------------------------------------

    def call(self, api: str, arguments: tuple[Argument, ...]) -> Outcome:
        outcome = self.skills[api](*arguments)
        self._emit()
        if self._disturbances.latency:
            self.settle(self._disturbances.latency)  # until what came of it is seen
        return outcome

    def _move_to(self, target: str) -> Outcome:
        if target not in self._positions:
            return Outcome(False, Failure.MISSING_OBJECT, {"target": target})
        if target == self._held:
            return Outcome(False, Failure.NOT_READY, {"in hand": target})
        if not self._by_name[target].flat:
            return self._go(self._hover(target))
        places = free_places(self.truth(), target, self._regions)
        if not places:
            return Outcome(False, Failure.NO_PATH, {"no free place on": target})
        return self._go(self._above(*places[0], self._top(target)))

    def _move_beside(self, item: str, other: str, side: str) -> Outcome:
        if other not in self._positions:
            return Outcome(False, Failure.MISSING_OBJECT, {"other": other})
        if self._held != item:
            return Outcome(False, Failure.NOT_READY, {"in hand": self._held or "nothing"})
        seen = self.truth()
        places = places_beside(seen, item, other, side)
        if not places:
            return Outcome(False, Failure.NO_PATH, {"no free place beside": other, "side": side})
        return self._go(self._above(*places[0], bottom_of(seen, other)))

    def move_over(self, x: float, y: float) -> Outcome:
        outcome = self._go(self._over_point(x, y))
        self._emit()
        return outcome

    def _over_point(self, x: float, y: float) -> Vector:
        return self._above(x, y, height_below(self.truth(), x, y))

    def _go(self, place: Vector) -> Outcome:
        """Move the tool to a place; the held object may slip on the way."""
        goal = self._off(place)
        lost = self._held
        if lost is None or self._rng.random() >= self._disturbances.slips:
            self._travel(goal)
            return ACHIEVED
        self._travel(between(self._gripper, goal, float(self._rng.uniform(0.1, 0.95))))
        return self._slip(lost)

    def _slip(self, item: str) -> Outcome:
        """Lose what is held, where it is."""
        self._drop_held(spread=0.03)
        self.disturbed.add(item)
        return Outcome(False, Failure.OBJECT_DROPPED, {"dropped": item}, disturbances=(f"slip {item}",))

    def _grasp(self, target: str) -> Outcome:
        if target not in self._positions:
            return Outcome(False, Failure.MISSING_OBJECT, {"target": target})
        if self._held is not None:
            return Outcome(False, Failure.NOT_READY, {"in hand": self._held})
        if target not in self._items:
            return Outcome(False, Failure.NOT_READY, {"never moves": target})
        x, y, z = self._grip(target)
        over = hypot(self._gripper[0] - x, self._gripper[1] - y) < REACH
        seen = self.truth()
        blocked = [other for other in self._items if predicates.covers(seen, other, target)]
        if not over or blocked:
            evidence = {"target": target, "blocked by": blocked, "above": over}
            return Outcome(False, Failure.NOT_READY, evidence)
        self._pick_up(target, (x, y, z))
        return ACHIEVED

    def _pick_up(self, target: str, grip: Vector) -> None:
        """Move the tool down to an object, close it, and move back up."""
        back = self._gripper
        self._travel(grip)
        self._hold(target)
        self._travel(back)

    def _hold(self, target: str) -> None:
        self._held, self._closed = target, True
        self._load = self._contents(target)
        self._emit()

    def _grip(self, target: str) -> Vector:
        """Return where the hand closes: around the middle, or at the nearest point of a bowl's wall."""
        x, y, z = self._positions[target]
        obj = self._items[target]
        if obj.cavity is None:
            return x, y, z
        dx, dy = self._gripper[0] - x, self._gripper[1] - y
        reach = obj.size[0] / 2 / max(hypot(dx, dy), 1e-6)
        return x + reach * dx, y + reach * dy, z + obj.size[2] / 2 - BELOW_RIM

    def _align_held(self, item: str, other: str) -> Outcome:
        if other not in self._positions:
            return Outcome(False, Failure.MISSING_OBJECT, {"other": other})
        return self._turn_held(item, yaw(self.truth().orientation(other)))

    def _turn_held(self, item: str, to: float) -> Outcome:
        """Turn the hand, and what it holds, about the vertical through the middle of that."""
        if self._held != item:
            return Outcome(False, Failure.NOT_READY, {"in hand": self._held or "nothing"})
        if self._disturbances.slips and self._rng.random() < self._disturbances.slips:
            return self._slip(item)
        start, places = self.truth().orientation(item), {name: self._positions[name] for name in self._load}
        middle, gripper = self._positions[item], self._gripper
        angle, began = angle_between_lines(to, yaw(start)), self._time
        duration = 0.15 + abs(angle) / TURNING
        for moment in (*np.arange(self.frame_seconds, duration, self.frame_seconds), duration):
            self._time = began + float(moment)
            turn = turned_by(start, angle * float(moment) / duration)
            self._orientations = {**self._orientations, item: turn}
            done = angle * float(moment) / duration
            self._gripper = turned_about(middle, gripper, done)
            self._positions |= {name: turned_about(middle, at, done) for name, at in places.items()}
            self._emit()
        lying = self.truth().by_name[item]
        self._by_name = {**self._by_name, item: lying}
        self._items[item] = self._solid[item] = lying
        return ACHIEVED

    def _release(self) -> Outcome:
        if self._held is None:
            self._closed = False
            return Outcome(False, Failure.NOT_READY, {"in hand": "nothing"})
        item, back = self._held, self._gripper
        x, y, _ = self._positions[item]
        height = self._resting_height(item, x, y)
        offset = self._gripper[2] - self._positions[item][2]
        self._travel((self._gripper[0], self._gripper[1], height + offset))
        self._move_tool(np.array(self._off(self._gripper)))
        self._drop_held(spread=self._placement_error)
        self._travel(back)
        return self._push(item)

    def _push(self, item: str) -> Outcome:
        """Topple, at random, the upper part of a tower after a placement."""
        tower = self._tower_below(item)
        if len(tower) < 2 or self._rng.random() >= self._disturbances.pushes:
            return ACHIEVED
        fallen = tower[: int(self._rng.integers(1, len(tower)))]
        for name in fallen:
            angle, reach = self._rng.uniform(0, 2 * np.pi), self._rng.uniform(0.06, 0.12)
            x, y, _ = self._positions[name]
            self.disturbed.add(name)
            away = x + reach * float(np.cos(angle)), y + reach * float(np.sin(angle))
            self._fall(name, *self._within_reach(*away, (x, y)))
        self._drop_unsupported()
        self._emit()
        return Outcome(True, disturbances=tuple(f"push {name}" for name in fallen))

    # Motion and falling -------------------------------------------------------------------------

    def _travel(self, goal: Vector) -> None:
        """Move straight to the goal, with smooth starts and stops."""
        start = np.array(self._gripper)
        way = np.array(goal) - start
        duration = 0.15 + float(np.linalg.norm(way)) / self._speed
        began = self._time
        for moment in np.arange(self.frame_seconds, duration, self.frame_seconds):
            phase = moment / duration
            self._time = began + float(moment)
            self._move_tool(start + way * (phase * phase * (3 - 2 * phase)))
            self._emit()
        self._time = began + duration
        self._move_tool(np.array(goal))

    def _off(self, goal: Vector) -> Vector:
        """Return the goal, or where a clumsy arm ends instead."""
        if self._rng.random() >= self._disturbances.clumsiness:
            return goal
        dx, dy = self._rng.uniform(-OFF, OFF, 2)
        return (goal[0] + float(dx), goal[1] + float(dy), goal[2])

    def _move_tool(self, tool: np.ndarray) -> None:
        shift = tool - np.array(self._gripper)
        self._gripper = (float(tool[0]), float(tool[1]), float(tool[2]))
        if self._held is not None:
            for name in (self._held, *self._load):
                self._positions[name] = moved(self._positions[name], shift)

    def _hover(self, target: str) -> Vector:
        surface = self._by_name[target]
        if surface.cavity is not None and self._held is None:
            return self._over_rim(target)
        held = self._held
        if held is not None and takes(surface, self._items[held]):
            return self._above(*place_in(self.truth(), target, self._items[held]), self._top(target))
        x, y, _ = self._positions[target]
        return self._above(x, y, self._top(target))

    def _above(self, x: float, y: float, height: float) -> Vector:
        """Return where the tool is when the held object, or else the tool, hovers over a point [m]."""
        ox, oy = self._offset_in_hand()
        return (x + ox, y + oy, height + self.clearance)

    def _over_rim(self, target: str) -> Vector:
        """Return a point above a bowl's wall, on the side of the robot's base."""
        x, y, _ = self._positions[target]
        reach = self._by_name[target].size[0] / 2 / max(hypot(x, y), 1e-6)
        return (x - reach * x, y - reach * y, self._top(target) + self.clearance)

    def _offset_in_hand(self) -> tuple[float, float]:
        """Return the offset from the held object to the tool, seen from above [m]."""
        if self._held is None:
            return 0.0, 0.0
        x, y, _ = self._positions[self._held]
        return self._gripper[0] - x, self._gripper[1] - y

    def _drop_held(self, spread: float) -> None:
        """Release the object; it comes down within `spread` [m] of where it is."""
        item = self._held
        assert item is not None
        self._held, self._closed = None, False
        dx, dy = self._rng.normal(0, spread, 2)
        before = np.array(self._positions[item])
        self._fall(item, float(before[0] + dx), float(before[1] + dy))
        for name in self._load:
            self._positions[name] = moved(self._positions[name], np.array(self._positions[item]) - before)
        self._load = []

    def _emit(self) -> None:
        if self.on_frame is not None:
            self.on_frame(self.observe())
        elif self._disturbances.latency:
            self._observer.note(self.truth(), self._time)


def between(start: Vector, goal: Vector, fraction: float) -> Vector:
    """Return the point at a fraction of the way [m]."""
    return moved(start, fraction * (np.array(goal) - np.array(start)))
