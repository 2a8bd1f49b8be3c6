"""Simulated people, who show a task by hand: they tremble, pause, miss, think twice, and nudge things."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.free_space import free_places
from ntp_dsl.semantics.geometry import Vector, moved
from ntp_dsl.semantics.observation import Observation
from ntp_dsl.semantics.predicates import covers
from ntp_dsl.worlds.habits import HABITS, RATE, Person
from ntp_dsl.worlds.kinematic import HOME, KinematicWorld, between
from ntp_dsl.worlds.protocol import UNDISTURBED, Disturbances, Outcome, Scene

CORRELATION = 0.05  # time of a tremor [s]
PAUSE = (0.2, 1.5)  # [s]
BEYOND = 0.03  # a goal, at most, where a motion overshoots [m]
LIFT = 0.01  # of a first grasp that is let go again [m]
NUDGE = (0.015, 0.04)  # by which a stray motion pushes an object [m]
NEAR = 0.15  # the way of the hand, seen from above, where the arm pushes objects [m]
AIM = 0.08  # about where the hand is going, seen from above, where it pushes nothing [m]
LIES = 0.002  # above the table, up to which an object lies on it [m]
ROOM = 0.01  # that a nudged object keeps from others [m]


class PersonWorld(KinematicWorld):
    """The kinematic world, in which the tool is moved as a person's hand moves.

    Args:
        rate: frames a second.

    Raises `NtpError` for an unknown person, and for a rate that is none.
    """

    def __init__(self, person: Person = Person.ANYBODY, rate: float = RATE) -> None:
        super().__init__()
        if person not in HABITS:
            raise NtpError(f"expected one of {', '.join(HABITS)}; found {person!r}")
        if not 0 < rate < inf:
            raise NtpError(f"rate: expected frames a second, found {rate}")
        self.habits = HABITS[person]
        self.frame_seconds, self.clearance = 1 / rate, self.habits.clearance

    def reset(self, scene: Scene, seed: int, disturbances: Disturbances = UNDISTURBED) -> None:
        super().reset(scene, seed, disturbances)
        self._person = np.random.default_rng((seed, 5))
        self._tremor = np.random.default_rng((seed, 6))  # of its own: what is done does not hang on the rate
        self._tremble = np.zeros(3)
        self._put: set[str] = set()  # objects that are where they belong
        self._trembled = 0.0

    # Looks --------------------------------------------------------------------------------------

    def _emit(self) -> None:
        if self.on_frame is not None:
            self.on_frame(self._trembling(self.observe()))

    def _trembling(self, seen: Observation) -> Observation:
        """Return a look at the trembling hand, with what it holds."""
        if not self.habits.tremor:
            return seen
        kept = float(np.exp(-(self._time - self._trembled) / CORRELATION))
        self._trembled = self._time
        fresh = self._tremor.normal(0, self.habits.tremor, 3)
        self._tremble = kept * self._tremble + np.sqrt(1 - kept**2) * fresh
        positions = dict(seen.positions)
        for name in (self._held, *self._load) if self._held is not None else ():
            positions[name] = moved(positions[name], self._tremble)
        return replace(seen, positions=positions, gripper=moved(seen.gripper, self._tremble))

    # Motions ------------------------------------------------------------------------------------

    def _does(self, chance: float) -> bool:
        return bool(self._person.random() < chance)

    def _travel(self, goal: Vector) -> None:
        if self._does(self.habits.pauses):
            self._wait(float(self._person.uniform(*PAUSE)))
        if self._does(self.habits.nudges):
            self._nudge(goal)
        if self._does(self.habits.overshoots):
            way = np.array(goal) - np.array(self._gripper)
            length = float(np.linalg.norm(way))
            if length > 2 * BEYOND and abs(way[2]) < 0.5 * length:  # nobody pushes through the table
                super()._travel(moved(goal, way / length * self._person.uniform(0.3, 1) * BEYOND))
        super()._travel(goal)

    def _wait(self, seconds: float) -> None:
        began = self._time
        for moment in np.arange(self.frame_seconds, seconds, self.frame_seconds):
            self._time = began + float(moment)
            self._emit()
        self._time = began + seconds

    def _nudge(self, goal: Vector) -> None:
        """Push an object on the table that lies by the way."""
        start, end = np.array(self._gripper[:2]), np.array(goal[:2])
        near = [
            name
            for name in self._items
            if name not in self._put
            and self._is_loose(name)
            and self._from_way(name, start, end) < NEAR
            and float(np.linalg.norm(np.array(self._positions[name][:2]) - end)) > AIM
        ]
        if not near:
            return
        name = near[int(self._person.integers(len(near)))]
        angle, reach = self._person.uniform(0, 2 * np.pi), self._person.uniform(*NUDGE)
        shift = np.array([reach * np.cos(angle), reach * np.sin(angle), 0.0])
        x, y, _ = moved(self._positions[name], shift)
        if self._within_reach(x, y, (x, y)) == (x, y) and self._has_room(name, x, y):
            begin = self._positions[name]
            for share in (0.25, 0.5, 0.75, 1.0):
                self._positions[name] = moved(begin, share * shift)
                self._time += self.frame_seconds
                self._emit()

    def _is_loose(self, name: str) -> bool:
        """Return whether an object lies on the table, and bears nothing."""
        low = self._positions[name][2] - self._items[name].size[2] / 2
        seen = self.truth()
        bears = any(covers(seen, other, name) for other in self._items)
        return name != self._held and abs(low) < LIES and not bears and not self._contents(name)

    def _from_way(self, name: str, start: np.ndarray, end: np.ndarray) -> float:
        way, at = end - start, np.array(self._positions[name][:2]) - start
        share = float(np.clip(way @ at / max(float(way @ way), 1e-9), 0, 1))
        return float(np.linalg.norm(at - share * way))

    def _has_room(self, name: str, x: float, y: float) -> bool:
        return all(self._overlap(name, (x, y), other) < -ROOM for other in self._solid if other != name)

    # Grasps and placements ----------------------------------------------------------------------

    def _grip(self, target: str) -> Vector:
        x, y, z = super()._grip(target)
        if self._items[target].cavity is not None:
            return x, y, z
        dx, dy = self._person.uniform(-1, 1, 2) * self.habits.off_centre
        return x + float(dx), y + float(dy), z

    def _pick_up(self, target: str, grip: Vector) -> None:
        back = self._gripper
        if self._does(self.habits.regrasps):
            self._travel(grip)
            self._hold(target)
            self._wait(0.3)
            if self._does(0.5):
                super()._travel(moved(grip, (0, 0, LIFT)))
                super()._travel(grip)
            self._let_go()
            self._wait(0.3)
            super()._pick_up(target, grip)
            self._travel(back)
        else:
            super()._pick_up(target, grip)

    def _let_go(self) -> None:
        self._held, self._closed, self._load = None, False, []
        self._emit()

    def _move_to(self, target: str) -> Outcome:
        if target in self._positions and target != self._held:
            if self._held is None and self._does(self.habits.false_starts):
                self._reach_for_another(target)
            elif self._held is not None and self._does(self.habits.second_thoughts):
                self._try_elsewhere(target)
        return super()._move_to(target)

    def _reach_for_another(self, target: str) -> None:
        others = [name for name in self._items if name != target]
        if others:
            other = others[int(self._person.integers(len(others)))]
            self._travel(between(self._gripper, self._hover(other), float(self._person.uniform(0.4, 1))))
            self._wait(float(self._person.uniform(0.1, 0.5)))

    def _try_elsewhere(self, target: str) -> None:
        """Put down what is held where it does not belong, and take it up again."""
        item = self._held
        table = next((o.name for o in self._objects if o.flat and o.name not in self._solid), None)
        if item is None or table is None:
            return
        places = free_places(self.truth(), table, self._regions)
        if not places:
            return
        place = places[int(self._person.integers(min(len(places), 20)))]
        above = self._above(*place, self._top(table))
        self._travel(above)
        x, y, z = self._positions[item]
        down = self._resting_height(item, x, y) - z
        self._travel(moved(self._gripper, (0, 0, down)))
        self._let_go()
        self._travel(above)
        self._wait(0.4)
        if self._does(self.habits.goes_home):
            self._travel(HOME)
        over = self._hover(item)
        self._travel(over)
        self._pick_up(item, self._grip(item))

    def _release(self) -> Outcome:
        if self._held is not None:
            self._put.add(self._held)
        outcome = super()._release()
        if self._does(self.habits.goes_home):
            self._travel(HOME)
        return outcome
