"""Perturbed starts, as an arm may find them: partial and wrong towers, buried objects, a full hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ntp_dsl.semantics.containers import contents, takes
from ntp_dsl.semantics.free_space import region_within
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import TOO_WIDE, SceneObject
from ntp_dsl.worlds.protocol import Scene
from ntp_dsl.worlds.scenes import CUBE, Start, movable
from ntp_dsl.worlds.standing import Standing, nests_badly, turned_where_free
from ntp_dsl.worlds.starts import GAP, NOWHERE, REGION, nominal_start, turned_ones

STRAIGHT = 0.6  # of stacked objects that are centred on their support
TOPPLES = 1.6  # times its support's width: such an object is not put on top
CARRIES = 0.024  # how far off its support's centre a cube still rests, along each axis [m]
BESIDE = 0.001  # between objects in one container [m]
IN_CONTAINER, ON_TABLE, OF_HAND = 20, 100, 20  # tries at a place
RESTARTS = 10  # of all places
RISE = 0.05  # of the hand, where what it holds would touch something [m]


def perturbed_start(
    objects: tuple[SceneObject, ...],
    rng: np.random.Generator,
    in_hand: bool = True,
    starts: Mapping[str, Start] | None = None,
    straight: float = STRAIGHT,
) -> Scene:
    """Return a scene with partial and wrong towers, buried objects and, at random, an object in the hand.

    Args:
        straight: how often objects are centred on their support, as an undisturbed arm leaves them.
    """
    rebuilt = _rebuilt(nominal_start(objects, rng, starts), starts or {}, rng, straight)
    standing = rebuilt.standing
    free = [name for name in rebuilt.tops if standing.by_name[name].movable]
    held = str(rng.choice(free)) if rng.random() < 0.3 and in_hand and free else None
    tops = [standing.top(name) for name in free if name != held]
    gripper = _somewhere(tops, rng)
    scene = Scene(objects, standing.positions, rebuilt.yaws, gripper)
    if held is not None:
        for _ in range(OF_HAND):
            if _in_hand(standing, held, gripper) is not None:
                break
            gripper = _somewhere(tops, rng)
        scene = with_in_hand(scene, held, gripper)
    return turned_where_free(scene, turned_ones(starts or {}))


def piled_start(
    objects: tuple[SceneObject, ...],
    rng: np.random.Generator,
    piles: int,
    starts: Mapping[str, Start] | None = None,
) -> Scene:
    """Return a scene of that many piles, of all objects that can stand on others."""
    rebuilt = Rebuilt(nominal_start(objects, rng, starts), starts or {}, rng, straight=1.0)
    try:
        rebuilt.pile_up(piles)
    except Stuck:
        return nominal_start(objects, rng, starts)
    scene = Scene(objects, rebuilt.standing.positions, rebuilt.yaws)
    return turned_where_free(scene, turned_ones(starts or {}))


def with_in_hand(scene: Scene, held: str, gripper: Vector) -> Scene:
    """Return the scene with an object, and what lies in it, in the hand, raised until both are free."""
    standing = Standing(scene.lying, dict(scene.positions))
    while (positions := _in_hand(standing, held, gripper)) is None:
        gripper = gripper[0], gripper[1], gripper[2] + RISE
    return replace(scene, positions=positions, gripper=gripper, held=held)


def in_hand_at(obj: SceneObject, gripper: Vector) -> Vector:
    """Return where a held object is: between the fingers, or a bowl by its wall."""
    x, y, z = gripper
    return (x + obj.size[0] / 2, y, z) if obj.cavity is not None else gripper


def _in_hand(standing: Standing, held: str, gripper: Vector) -> dict[str, Vector] | None:
    """Return the positions with an object and what lies in it in the hand; None where they touch others."""
    taken = standing.by_name[held]
    load = contents(taken, standing.by_name.values(), standing.positions)
    x, y, z = standing.positions[held]
    to_x, to_y, to_z = in_hand_at(taken, gripper)
    moved: dict[str, Vector] = {held: (to_x, to_y, to_z)}
    for name in load:
        at = standing.positions[name]
        moved[name] = at[0] + to_x - x, at[1] + to_y - y, at[2] + to_z - z
    others = Standing(
        standing.by_name, {name: at for name, at in standing.positions.items() if name not in moved}
    )
    is_free = all(others.is_free(name, at) for name, at in moved.items())
    return {**standing.positions, **moved} if is_free and to_z > taken.size[2] / 2 else None


def _somewhere(tops: Sequence[Vector], rng: np.random.Generator) -> Vector:
    """Return a place for the hand: anywhere, over an object's top, or nearly over it."""
    if not tops or rng.random() < 0.3:
        (x0, x1), (y0, y1) = REGION
        x, y = rng.uniform((x0, y0), (x1, y1))
        return (float(x), float(y), float(rng.uniform(0.2, 0.4)))
    x, y, z = tops[int(rng.integers(len(tops)))]
    dx, dy = rng.uniform(-CUBE, CUBE, 2) if rng.random() < 0.6 else (0.0, 0.0)
    return (x + float(dx), y + float(dy), z + float(rng.uniform(0.04, 0.12)))


def _rebuilt(scene: Scene, starts: Mapping[str, Start], rng: np.random.Generator, straight: float) -> Rebuilt:
    """Return a perturbed scene; where no place is left for some object, another draw, or the scene itself."""
    for _ in range(RESTARTS):
        rebuilt = Rebuilt(scene, starts, rng, straight)
        try:
            rebuilt.perturb()
        except Stuck:
            continue
        return rebuilt
    rebuilt = Rebuilt(scene, starts, rng, straight)
    rebuilt.leave()
    return rebuilt


class Stuck(Exception):
    """No place is left for an object: another draw may have one."""


class Rebuilt:
    """A scene whose objects are put elsewhere one by one: each onto what has its place already."""

    def __init__(
        self, scene: Scene, starts: Mapping[str, Start], rng: np.random.Generator, straight: float
    ) -> None:
        self._nominal, self._starts, self.yaws = scene.positions, starts, scene.yaws
        self._by_name = scene.lying
        self._rng, self._straight = rng, straight
        names = [obj.name for obj in movable(scene.objects)]
        self._order = [names[index] for index in rng.permutation(len(names))]
        on_others = {name for name in names if self._support(name)}
        # Those on the table are in the way until it is their turn; those on others are put back only then.
        places = {name: place for name, place in scene.positions.items() if name not in on_others}
        self.standing = Standing(scene.lying, places)
        self.tops = [obj.name for obj in scene.objects if obj.fixed]  # on which the next may be put
        self._waiting: dict[str, list[str]] = {}  # objects that stay on another, until that has its place

    def _support(self, name: str) -> str:
        """Return what an object starts on or in; nothing for a table."""
        surface = self._starts.get(name, NOWHERE).surface
        below = self._by_name.get(surface)
        return "" if below is None or below.size[0] > TOO_WIDE else surface

    def perturb(self) -> None:
        """Put about half of the objects on others; the rest stay where they are, or with their support."""
        placed: set[str] = set()
        for name in self._order:
            below = self._support(name)
            if self.tops and self._rng.random() < 0.5 and self.put_on_any(name):
                self._settle(name, placed)
            elif below in self._order and below not in placed:
                self._waiting.setdefault(below, []).append(name)
            else:
                self._stay(name)
                self._settle(name, placed)

    def leave(self) -> None:
        """Leave everything where it starts."""
        self.standing.positions.update(self._nominal)
        carriers = self.standing.carriers()
        self.tops = [name for name in self._order if name not in carriers]

    def pile_up(self, piles: int) -> None:
        """Put all objects but the lowest onto so many piles in turn, as far as they can stand there."""
        low = [name for name in self._order if self._is_low(name)]
        bases = [*low, *(name for name in self._order if name not in low)][:piles]
        for name in bases:
            if name in low:
                self._stay(name)
            else:
                self.put_aside(name)
        tops = [name for name in bases if name in self.tops]
        for number, name in enumerate(name for name in self._order if name not in bases):
            for offset in range(len(tops)):
                pile = (number + offset) % len(tops)
                if self.put_on(name, tops[pile]):
                    tops[pile] = name if name in self.tops else tops[pile]
                    break
            else:
                self.put_aside(name)

    def _is_low(self, name: str) -> bool:
        """Return whether an object starts on the table, or on a fixed object."""
        below = self._by_name.get(self._support(name))
        return below is None or (below.fixed and not takes(below, self._by_name[name]))

    def _settle(self, name: str, placed: set[str]) -> None:
        """Put back what has waited for an object to have its place."""
        placed.add(name)
        for waiting in self._waiting.pop(name, []):
            self._stay(waiting)
            self._settle(waiting, placed)

    def _stay(self, name: str) -> None:
        """Leave an object where it starts, or on its support where that is now; elsewhere if it is taken."""
        below = self._support(name)
        if not below:
            self.tops.append(name)
            return
        (x, y, _), (bx, by, _) = self._nominal[name], self._nominal[below]
        at = self.standing.positions[below]
        place = self.standing.on(below, name, at[0] + x - bx, at[1] + y - by)
        if below in self.tops and self.standing.is_free(name, place):
            self._put(name, place, below)
        else:
            self.put_aside(name)

    def put_aside(self, name: str) -> None:
        """Put an object at a free place of the table, or on another where there is none."""
        (x0, x1), (y0, y1) = REGION
        for _ in range(ON_TABLE):
            x, y = self._rng.uniform((x0, y0), (x1, y1))
            place = (float(x), float(y), self._by_name[name].size[2] / 2)
            if self.standing.is_free(name, place, GAP):
                self.standing.positions[name] = place
                self.tops.append(name)
                return
        for index in self._rng.permutation(len(self.tops)):
            if self.put_on(name, self.tops[index]):
                return
        raise Stuck

    def put_on_any(self, name: str) -> bool:
        """Put an object on a top that is drawn; return whether it can stand there."""
        return self.put_on(name, self.tops[int(self._rng.integers(len(self.tops)))])

    def put_on(self, name: str, below: str) -> bool:
        """Put an object on or in another, if it can stand there."""
        item, support = self._by_name[name], self._by_name[below]
        place = self._drawn_place(item, support)
        if item.size[0] > TOPPLES * support.size[0] or nests_badly(support, item):
            return False
        if takes(support, item):
            for _ in range(IN_CONTAINER):
                if self.standing.is_free(name, place, beside=BESIDE):
                    break
                place = self._drawn_place(item, support)
            else:
                return False
        else:  # an object that overhangs its support needs room beside it
            gap = GAP if support.roomy or item.size[0] > support.size[0] else 0.0
            if not self.standing.is_free(name, place, gap):
                return False
        self._put(name, place, below)
        return True

    def _put(self, name: str, place: Vector, below: str) -> None:
        """Place an object; what is below can carry others only if it has room for several."""
        item, support = self._by_name[name], self._by_name[below]
        self.standing.positions[name] = place
        if takes(support, item):
            return  # in the container, which others may still be put on
        if support.roomy:
            self.tops.append(name)
        else:
            self.tops[self.tops.index(below)] = name

    def _drawn_place(self, item: SceneObject, below: SceneObject) -> Vector:
        """Return a place on top: centred, or as far off as is just stable, where decisions are hardest."""
        rng = self._rng
        x, y, _ = self.standing.positions[below.name]
        if below.cavity is not None and takes(below, item):
            dx, dy = (float(rng.uniform(-half, half)) / 2 for half in below.cavity[:2])
            (x0, x1), (y0, y1) = region_within(below, (x, y), item.size)
            return self.standing.on(below.name, item.name, min(max(x + dx, x0), x1), min(max(y + dy, y0), y1))
        reach = CARRIES if below.size[:2] == (CUBE, CUBE) else max(0.0, min(below.size[:2]) / 2 - 0.001)
        centred = rng.random() < (min(self._straight, STRAIGHT) if below.roomy else self._straight)
        dx, dy = rng.normal(0, 0.001, 2) if centred else rng.uniform(-reach, reach, 2)
        return self.standing.on(below.name, item.name, x + float(dx), y + float(dy))
