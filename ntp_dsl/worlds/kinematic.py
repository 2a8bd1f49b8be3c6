"""The kinematic world: no forces, but things rest, fall, slip and topple; thousands of episodes a minute."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import hypot

import numpy as np

from ntp_dsl import predicates
from ntp_dsl.predicates import FREE_GAP
from ntp_dsl.world import (
    ACHIEVED,
    TOO_WIDE,
    UNDISTURBED,
    Argument,
    Disturbances,
    Failure,
    Observation,
    Outcome,
    Scene,
    Thing,
    Vector,
)
from ntp_dsl.worlds.scenes import CUBE, movable
from ntp_dsl.worlds.starts import CENTRE, NESTED, REGION, WIDE

HOVER = 0.10  # the tool's height over a target's top [m]
HOME: Vector = (0.42, 0.0, 0.45)
PLACEMENT_ERROR = 0.0007  # standard deviation of where a released thing ends up [m]
FRAME = 0.1  # [s]
REACH = 0.035  # from where the hand closes around a thing below it, seen from above [m]
OFF = 0.035  # from where a clumsy motion should end, along each axis [m]
BESIDE = 0.06  # from an edge's thing to where what falls off it lands, beside half its width [m]
BELOW_RIM = 0.013  # of a bowl, where it is grasped [m]
HEAP = 0.1  # of its height, by which a thing lies higher for each that is in the bin before it
SLIVER = 0.008  # of an overlap that neither carries a thing nor keeps it from going down [m]


class KinematicWorld:
    """Positions only. A held thing follows the tool; a thing let go falls on what is below it."""

    starts_holding = True

    def __init__(self, placement_error: float = PLACEMENT_ERROR) -> None:
        self._placement_error = placement_error
        self.on_frame: Callable[[Observation], None] | None = None
        self.disturbed: set[str] = set()
        self.skills: dict[str, Callable[..., Outcome]] = {
            "move_to": self._move_to,
            "grasp": self._grasp,
            "release": self._release,
        }

    def reset(
        self, scene: Scene, seed: int, disturbances: Disturbances = UNDISTURBED
    ) -> None:
        self._rng = np.random.default_rng(seed)
        self._noise_rng = np.random.default_rng((seed, 1))
        self._things = scene.things
        self._by_name = scene.by_name
        self._items: dict[str, Thing] = {thing.name: thing for thing in movable(scene.things)}
        self._solid = {t.name: t for t in scene.things if t.size[0] <= TOO_WIDE}  # on the table
        self._region = REGION if len(self._solid) == len(self._items) else WIDE
        self._positions = dict(scene.positions)
        self._disturbances = disturbances
        self._gripper = scene.gripper or HOME
        self._held, self._closed = scene.held, scene.held is not None
        self._load: list[str] = []  # what is in the bowl that is held
        self._time = 0.0
        self._speed = float(self._rng.uniform(0.2, 0.6))  # of the tool [m/s]
        self.disturbed = set()

    # What is seen -------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        return self._time

    def truth(self) -> Observation:
        return Observation(self._things, dict(self._positions), self._gripper, self._closed)

    def observe(self) -> Observation:
        sigma = self._disturbances.noise
        if not sigma:
            return self.truth()
        noisy = {
            name: _moved(position, self._noise_rng.normal(0, sigma, 3))
            for name, position in self._positions.items()
        }
        return Observation(self._things, noisy, self._gripper, self._closed)

    def supported(self, item: str, support: str) -> bool:
        return predicates.on(self.truth(), item, support, predicates.ACCEPTED)

    def settle(self, seconds: float) -> None:
        self._time += seconds

    # Primitives ---------------------------------------------------------------------------------

    def call(self, api: str, arguments: tuple[Argument, ...]) -> Outcome:
        outcome = self.skills[api](*arguments)
        self._emit()
        return outcome

    def _move_to(self, target: str) -> Outcome:
        if target not in self._positions:
            return Outcome(False, Failure.MISSING_OBJECT, {"target": target})
        if target == self._held:
            return Outcome(False, Failure.NOT_READY, {"in hand": target})
        surface = self._by_name[target]
        if surface.roomy and surface.cavity is None and self._room_on(target) <= FREE_GAP:
            return Outcome(False, Failure.NO_PATH, {"no free place on": target})
        goal = self._off(self._hover(target))
        lost = self._held
        if lost is None or self._rng.random() >= self._disturbances.slips:
            self._travel(goal)
            return ACHIEVED
        self._travel(_between(self._gripper, goal, float(self._rng.uniform(0.1, 0.95))))
        self._drop_held(spread=0.03)
        self.disturbed.add(lost)
        return Outcome(
            False, Failure.OBJECT_DROPPED, {"dropped": lost}, disturbances=(f"slip {lost}",)
        )

    def _grasp(self, target: str) -> Outcome:
        if target not in self._positions:
            return Outcome(False, Failure.MISSING_OBJECT, {"target": target})
        if self._held is not None:
            return Outcome(False, Failure.NOT_READY, {"in hand": self._held})
        x, y, z = self._grip(target)
        over = hypot(self._gripper[0] - x, self._gripper[1] - y) < REACH
        blocked = [other for other in self._items if self._on_top_of(other, target)]
        if not over or blocked:
            evidence = {"target": target, "blocked by": blocked, "above": over}
            return Outcome(False, Failure.NOT_READY, evidence)
        back = self._gripper
        self._travel((x, y, z))
        self._held, self._closed = target, True
        self._load = self._contents(target)
        self._emit()
        self._travel(back)
        return ACHIEVED

    def _grip(self, target: str) -> Vector:
        """Where the hand closes: around the middle, or at the nearest place of a bowl's wall."""
        x, y, z = self._positions[target]
        thing = self._items[target]
        if thing.cavity is None:
            return x, y, z
        dx, dy = self._gripper[0] - x, self._gripper[1] - y
        reach = thing.size[0] / 2 / max(hypot(dx, dy), 1e-6)
        return x + reach * dx, y + reach * dy, z + thing.size[2] / 2 - BELOW_RIM

    def _contents(self, container: str) -> list[str]:
        """What goes along where a bowl goes."""
        if self._by_name[container].cavity is None:
            return []
        seen = self.truth()
        return [
            name for name in self._items if name != container and predicates.inside(seen, name, container)
        ]

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
        """After a placement, perhaps, an impulse that topples what was built."""
        tower = self._tower_below(item)
        if len(tower) < 2 or self._rng.random() >= self._disturbances.pushes:
            return ACHIEVED
        fallen = tower[: int(self._rng.integers(1, len(tower)))]
        for name in fallen:
            angle, reach = self._rng.uniform(0, 2 * np.pi), self._rng.uniform(0.06, 0.12)
            x, y, _ = self._positions[name]
            self.disturbed.add(name)
            self._fall(name, x + reach * np.cos(angle), y + reach * np.sin(angle))
        self._drop_unsupported()
        self._emit()
        return Outcome(True, disturbances=tuple(f"push {name}" for name in fallen))

    # Motion and falling -------------------------------------------------------------------------

    def _travel(self, goal: Vector) -> None:
        """Straight to the goal, with smooth starts and stops, a frame every tenth of a second."""
        start = np.array(self._gripper)
        way = np.array(goal) - start
        duration = 0.15 + float(np.linalg.norm(way)) / self._speed
        began = self._time
        for moment in np.arange(FRAME, duration, FRAME):
            phase = moment / duration
            self._time = began + float(moment)
            self._move_tool(start + way * (phase * phase * (3 - 2 * phase)))
            self._emit()
        self._time = began + duration
        self._move_tool(np.array(goal))

    def _off(self, goal: Vector) -> Vector:
        """The goal, or where a clumsy arm ends instead."""
        if self._rng.random() >= self._disturbances.clumsiness:
            return goal
        dx, dy = self._rng.uniform(-OFF, OFF, 2)
        return (goal[0] + float(dx), goal[1] + float(dy), goal[2])

    def _move_tool(self, tool: np.ndarray) -> None:
        shift = tool - np.array(self._gripper)
        self._gripper = (float(tool[0]), float(tool[1]), float(tool[2]))
        if self._held is not None:
            for name in (self._held, *self._load):
                self._positions[name] = _moved(self._positions[name], shift)

    def _hover(self, target: str) -> Vector:
        surface = self._by_name[target]
        if surface.cavity is not None and self._held is None:
            return self._over_rim(target)
        if surface.roomy or self._takes(target):
            x, y, _ = self._clearest_place(self._held, surface)
            ox, oy = self._offset_in_hand()
            return (x + ox, y + oy, self._top(target) + HOVER)
        x, y, z = self._positions[target]
        ox, oy = self._offset_in_hand()  # the held thing, not the tool, is to be over the target
        return (x + ox, y + oy, z + surface.size[2] / 2 + HOVER)

    def _takes(self, target: str, item: str | None = None) -> bool:
        """Whether what is held (or an item) would be dropped into the target, rather than put on it."""
        item = item or self._held
        container = self._by_name[target].cavity
        return container is not None and item is not None and self._items[item].cavity is None

    def _over_rim(self, target: str) -> Vector:
        """Above the wall of a bowl, on the side of the robot's base."""
        x, y, _ = self._positions[target]
        reach = self._by_name[target].size[0] / 2 / max(hypot(x, y), 1e-6)
        return (x - reach * x, y - reach * y, self._top(target) + HOVER)

    def _room_on(self, target: str) -> float:
        """How far what is held would be from everything else on a table or tray [m]."""
        return self._clearest_place(self._held, self._by_name[target])[2]

    def _offset_in_hand(self) -> tuple[float, float]:
        """From the held thing to the tool, seen from above."""
        if self._held is None:
            return 0.0, 0.0
        x, y, _ = self._positions[self._held]
        return self._gripper[0] - x, self._gripper[1] - y

    def _clearest_place(
        self, item: str | None, surface: Thing | None = None
    ) -> tuple[float, float, float]:
        """The point of a 2 cm lattice that is farthest from all but the item, and how far; ties by nearness.

        On a tray it lies within the tray; on the table, within the arm's region.
        """
        size = self._items[item].size if item else (CUBE, CUBE, CUBE)
        lattice = self._lattice(surface, size)
        except_for = {item, surface.name if surface else None}
        others = []
        for name, (x, y, _) in self._others(item):
            if name not in except_for:
                width, depth, _ = self._solid[name].size
                others.append((x, y, (size[0] + width) / 2, (size[1] + depth) / 2))
        if not others:
            x, y = CENTRE if surface is None or surface.size[0] > TOO_WIDE else lattice.mean(0)
            return float(x), float(y), np.inf
        table = np.array(others)
        apart = np.abs(lattice[:, None] - table[None, :, :2]) - table[None, :, 2:]
        room = apart.max(-1).min(1)
        liked = np.minimum(room + CUBE, 0.11) - 0.01 * np.linalg.norm(lattice - self._gripper[:2], axis=1)
        best = int(liked.argmax())
        return float(lattice[best, 0]), float(lattice[best, 1]), float(room[best])

    def _lattice(self, surface: Thing | None, size: Vector) -> np.ndarray:
        """(N, 2): where the centre of a thing of that size may come to rest."""
        if surface is None or surface.size[0] > TOO_WIDE:
            (x0, x1), (y0, y1) = self._region
        elif surface.cavity is not None:
            x, y, _ = self._positions[surface.name]
            dx, dy = (max(0.005, half - 0.03) for half in surface.cavity[:2])
            (x0, x1), (y0, y1) = (x - dx, x + dx), (y - dy, y + dy)
        else:
            x, y, _ = self._positions[surface.name]
            dx, dy = (max(0.005, (surface.size[axis] - size[axis]) / 2) for axis in (0, 1))
            (x0, x1), (y0, y1) = (x - dx, x + dx), (y - dy, y + dy)
        return np.array([(x, y) for x in np.arange(x0, x1, 0.02) for y in np.arange(y0, y1, 0.02)])

    def _drop_held(self, spread: float) -> None:
        """Let go; the thing comes down within `spread` [m] of where it is."""
        item = self._held
        assert item is not None
        self._held, self._closed = None, False
        dx, dy = self._rng.normal(0, spread, 2)
        before = np.array(self._positions[item])
        self._fall(item, float(before[0] + dx), float(before[1] + dy))
        for name in self._load:
            self._positions[name] = _moved(self._positions[name], np.array(self._positions[item]) - before)
        self._load = []

    def _fall(self, item: str, x: float, y: float) -> None:
        """Down to what is below; off the edge of what does not carry its centre."""
        if self._unsteady_edge(item, x, y) is not None:
            self.disturbed.add(item)
        for _ in range(20):
            x, y = self._within_reach(x, y)
            edge = self._unsteady_edge(item, x, y)
            if edge is None:
                break
            ex, ey, _ = self._positions[edge]
            angle = np.arctan2(y - ey, x - ex) + self._rng.normal(0, 0.3)
            reach = BESIDE + max(self._solid[edge].size[:2]) / 2
            x, y = ex + reach * float(np.cos(angle)), ey + reach * float(np.sin(angle))
        else:
            x, y, _ = self._clearest_place(item)
        self._positions[item] = (x, y, self._resting_height(item, x, y))

    def _within_reach(self, x: float, y: float) -> tuple[float, float]:
        (x0, x1), (y0, y1) = self._region
        return min(max(x, x0 - 0.05), x1 + 0.05), min(max(y, y0 - 0.05), y1 + 0.05)

    def _drop_unsupported(self) -> None:
        """What leant on something that is gone comes down as well, the lowest first."""
        standing: list[tuple[str, Vector]] = []
        loose: dict[str, Vector] = {}
        for name, place in sorted(self._others(None), key=lambda each: each[1][2]):
            if name not in self._items or self._carried(name, place, standing):
                standing.append((name, place))
            else:
                loose[name] = self._positions.pop(name)
        for name, (x, y, _) in loose.items():
            self.disturbed.add(name)
            self._fall(name, x, y)

    def _carried(self, item: str, place: Vector, standing: list[tuple[str, Vector]]) -> bool:
        bottom = place[2] - self._items[item].size[2] / 2
        if bottom < 0.005 or self._container_below(item, place[0], place[1]) is not None:
            return True  # by the table, or in a bowl
        return any(
            self._overlap(item, place, name) > 0 and abs(bottom - self._top(name)) < 0.01
            for name, _ in standing
        )

    def _overlap(self, item: str, place: tuple[float, ...], other: str) -> float:
        """How far two things overlap seen from above, along the axis where they do least [m]."""
        px, py, _ = self._positions[other]
        a, b = self._solid[item].size, self._solid[other].size
        return min((a[0] + b[0]) / 2 - abs(place[0] - px), (a[1] + b[1]) / 2 - abs(place[1] - py))

    def _unsteady_edge(self, item: str, x: float, y: float) -> str | None:
        """The topmost thing below that overlaps without carrying the item's centre."""
        below = self._below(item, x, y)
        if not below or self._container_below(item, x, y) is not None:
            return None
        top = max(self._top(name) for name in below)
        tops = [name for name in below if self._top(name) > top - 0.01]
        return None if any(self._carries(name, x, y) for name in tops) else tops[0]

    def _carries(self, name: str, x: float, y: float) -> bool:
        """Whether a point lies over the thing."""
        px, py, _ = self._positions[name]
        width, depth, _ = self._solid[name].size
        return abs(x - px) < width / 2 and abs(y - py) < depth / 2

    def _resting_height(self, item: str, x: float, y: float) -> float:
        """Of the item's middle: on what is below, or on the heap in a container."""
        height = self._items[item].size[2]
        container = self._container_below(item, x, y)
        if container is not None:
            cavity = self._by_name[container].cavity
            assert cavity is not None
            floor = self._top(container) - self._by_name[container].size[2] + cavity.floor
            heap = HEAP * height * len([n for n in self._contents(container) if n != item])
            return min(floor + height / 2 + heap, self._top(container))
        nested = NESTED if self._items[item].shape == "bowl" else 0.0
        tops = (
            self._top(name) - (nested if self._by_name[name].shape == "bowl" else 0.0)
            for name in self._below(item, x, y)
        )
        return max(tops, default=0.0) + height / 2

    def _container_below(self, item: str, x: float, y: float) -> str | None:
        """The bin or bowl that an item falls into when it is let go there: the highest."""
        found = [
            name
            for name, (px, py, _) in self._others(item)
            if (cavity := self._by_name[name].cavity) is not None
            if abs(x - px) <= cavity.half_x and abs(y - py) <= cavity.half_y and self._takes(name, item)
        ]
        return max(found, key=self._top, default=None)

    def _below(self, item: str, x: float, y: float) -> list[str]:
        return [
            name
            for name, _ in self._others(item)
            if self._overlap(item, (x, y), name) > SLIVER
        ]

    def _others(self, item: str | None) -> Iterator[tuple[str, Vector]]:
        for name in self._solid:
            if name not in (item, self._held, *self._load) and name in self._positions:
                yield name, self._positions[name]

    def _top(self, name: str) -> float:
        return self._positions[name][2] + self._by_name[name].size[2] / 2

    def _on_top_of(self, item: str, support: str) -> bool:
        if item in (support, self._held):
            return False
        return predicates.covers(self.truth(), item, support)

    def _tower_below(self, item: str) -> list[str]:
        """The item and what it stands on, from the top down."""
        x, y, z = self._positions[item]
        tower = [
            (pz, name)
            for name, (px, py, pz) in self._others(None)
            if name in self._items and hypot(px - x, py - y) < CUBE / 2 and pz <= z
        ]
        return [name for _, name in sorted(tower, reverse=True)]

    def _emit(self) -> None:
        if self.on_frame is not None:
            self.on_frame(self.observe())


def _moved(position: Vector, shift: np.ndarray) -> Vector:
    return (position[0] + float(shift[0]), position[1] + float(shift[1]), position[2] + float(shift[2]))


def _between(start: Vector, goal: Vector, fraction: float) -> Vector:
    return _moved(start, fraction * (np.array(goal) - np.array(start)))


