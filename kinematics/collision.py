"""The collision checker: joint positions in, clearance out; arm, hand, held body and scene, in
MuJoCo.

One model serves as long as the sizes of the bodies stay the same: bodies are moved, never rebuilt.
Every body
of the scene is a mocap body of its own, since a geom moved inside the world body silently loses its
collisions.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco

from kinematics import robot
from kinematics.geometry import Array, Pose, Vector, pose_of, quaternion_from_rotation, wxyz

MARGIN = 0.004  # clearance is measured up to here [m]
TOUCHING = 1e-4  # [m]
_SLIMMER = 1.5e-3  # [m]
_ROBOT, _SCENE, _GHOST = 1, 2, 4
_NOWHERE = (0.0, 0.0, 50.0)
_NOWHERE_ELSE = (0.0, 0.0, 100.0)
_OUTWARD = {"panda_leftfinger": 1.0, "panda_rightfinger": -1.0}


@dataclass(frozen=True)
class Touch:
    """Two geoms nearer than the margin."""

    pair: tuple[int, int]
    names: tuple[str, str]
    distance: float  # negative where they overlap [m]


class CollisionScene:
    """Arm, table and the boxes of a cell, by name."""

    def __init__(self, sizes: Mapping[str, Vector]) -> None:
        self._sizes = dict(sizes)
        self._in_hand_name = {size: f"held_{i}" for i, size in enumerate(dict.fromkeys(sizes.values()))}
        self._model = self._compile()
        self._data = mujoco.MjData(self._model)
        self._mocap = {name: int(self._model.body(f"body_{name}").mocapid[0]) for name in self._sizes}
        self._fingers = {name: self._model.body(name).id for name in robot.FINGER_LINKS}
        self._held_geom = {
            size: (self._model.body(name).id, self._model.geom(name).id)
            for size, name in self._in_hand_name.items()
        }
        self._is_ghost = self._model.geom_contype == _GHOST
        self._tolerated: dict[tuple[int, int], float] = {}
        self.checks = 0
        self._data.qpos[7:10] = _NOWHERE_ELSE
        self.hold(None)

    def place(self, poses: Mapping[str, Pose], absent: frozenset[str] = frozenset()) -> None:
        """Put the bodies where they are; those that are absent, out of the way."""
        for name, index in self._mocap.items():
            if name in absent:
                self._data.mocap_pos[index] = _NOWHERE
            else:
                self._data.mocap_pos[index] = poses[name].position
                self._data.mocap_quat[index] = wxyz(poses[name].quaternion_xyzw)

    def hold(self, name: str | None, tool_to_body: Array | None = None) -> None:
        """The hand holds the body of this name, at this transform of body to tool; or nothing."""
        held = None if name is None else self._sizes[name]
        for size, (body, geom) in self._held_geom.items():
            active = int(size == held)
            self._model.geom_contype[geom] = _ROBOT * active
            self._model.geom_conaffinity[geom] = (_ROBOT | _SCENE) * active
            if active and tool_to_body is not None:
                pose = pose_of(tool_to_body)
                self._model.body_pos[body] = pose.position
                self._model.body_quat[body] = wxyz(pose.quaternion_xyzw)

    def open_fingers(self, opening: float) -> None:
        """Each finger this far from the middle [m]."""
        for name, body in self._fingers.items():
            self._model.body_pos[body][1] = _OUTWARD[name] * opening

    def clearance(self, q: Array) -> float:
        """The least distance at these joint positions, up to `MARGIN`; negative where things
        overlap [m].
        """
        self.checks += 1
        self._data.qpos[:7] = q
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        if self._data.ncon == 0:
            return MARGIN
        if not self._tolerated:
            return float(self._data.contact.dist.min())
        return min((self._beyond_tolerated(touch) for touch in self._touches()), default=MARGIN)

    def is_free(self, q: Array, margin: float = MARGIN) -> bool:
        """Whether nothing is nearer than the margin."""
        return self.clearance(q) >= margin

    def touches(self, q: Array) -> list[Touch]:
        """Everything nearer than `MARGIN`, for the evidence of a failure."""
        self.clearance(q)
        return self._touches()

    def hand_is_free(self, tool: Array, opening: float, margin: float) -> bool:
        """Whether a hand alone, its tool frame there, keeps the margin: no inverse kinematics
        needed.
        """
        self._show_ghost(tool, opening)
        self.checks += 1
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        contact = self._data.contact
        near = contact.dist < margin
        is_free = not bool((near & (self._is_ghost[contact.geom].any(axis=1))).any())
        self._data.qpos[7:10] = _NOWHERE_ELSE
        return is_free

    def tolerate_here(self, *configurations: Array) -> None:
        """What is near at these joint positions may stay as near (not nearer) until
        `tolerate_nothing`.
        """
        tolerated: dict[tuple[int, int], float] = {}
        self._tolerated = {}
        for q in configurations:
            for touch in self.touches(q):
                tolerated[touch.pair] = min(touch.distance, tolerated.get(touch.pair, MARGIN))
        self._tolerated = tolerated

    def tolerate_nothing(self) -> None:
        self._tolerated = {}

    def drop_height(self, q: Array, held: str, below: float) -> float:
        """How far the held body can go straight down before it rests on something, at most `below`
        [m].

        Conservative advancement: the distance to anything is a safe step. The body is slimmed
        meanwhile, so that a neighbour at its side does not stop it.
        """
        self._data.qpos[:7] = q
        mujoco.mj_kinematics(self._model, self._data)
        geom = self._held_geom[self._sizes[held]][1]
        others = [self._model.geom(f"body_{name}").id for name in self._sizes if name != held]
        others.append(self._model.geom("table").id)
        full = self._model.geom_size[geom].copy()
        self._model.geom_size[geom] = full - _SLIMMER
        dropped = self._advance_down(geom, others, below + _SLIMMER)
        self._model.geom_size[geom] = full
        return dropped - _SLIMMER

    def distance(self, a: str, b: str) -> float:
        """Between two bodies that are where they were placed [m]."""
        geoms = [self._model.geom(f"body_{name}").id for name in (a, b)]
        mujoco.mj_kinematics(self._model, self._data)
        return float(mujoco.mj_geomDistance(self._model, self._data, *geoms, 1.0, None))

    def room_of(self, name: str, shifts: Sequence[Array]) -> float:
        """The least distance of a body to all others, were it shifted by any of these [m]."""
        mujoco.mj_kinematics(self._model, self._data)
        geom = self._model.geom(f"body_{name}").id
        others = [self._model.geom(f"body_{other}").id for other in self._sizes if other != name]
        start = self._data.geom_xpos[geom].copy()
        room = math.inf
        for shift in shifts:
            self._data.geom_xpos[geom] = start + shift
            distances = (
                mujoco.mj_geomDistance(self._model, self._data, geom, other, 1.0, None) for other in others
            )
            room = min(room, *distances, math.inf)
        return room

    def _advance_down(self, geom: int, others: list[int], below: float) -> float:
        start = self._data.geom_xpos[geom].copy()
        dropped = 0.0
        for _ in range(200):
            self._data.geom_xpos[geom] = start - (0.0, 0.0, dropped)
            nearest = min(
                mujoco.mj_geomDistance(self._model, self._data, geom, other, 1.0, None) for other in others
            )
            if nearest < TOUCHING or dropped >= below:
                break
            dropped += nearest
        return min(dropped, below)

    def _show_ghost(self, tool: Array, opening: float) -> None:
        hand = tool[:3, 3] - robot.TOOL_FROM_HAND * tool[:3, 2]
        self._data.qpos[7:10] = hand
        self._data.qpos[10:14] = wxyz(quaternion_from_rotation(tool[:3, :3]))
        for name in robot.FINGER_LINKS:
            body = self._model.body(f"ghost_{name}").id
            self._model.body_pos[body][1] = _OUTWARD[name] * opening

    def _beyond_tolerated(self, touch: Touch) -> float:
        tolerated = self._tolerated.get(touch.pair)
        if tolerated is None:
            return touch.distance
        return MARGIN if touch.distance >= tolerated - 1e-3 else touch.distance

    def _touches(self) -> list[Touch]:
        touches = []
        for contact in self._data.contact[: self._data.ncon]:
            first, second = int(contact.geom1), int(contact.geom2)
            names = (self._name(first), self._name(second))
            touches.append(Touch((first, second), names, float(contact.dist)))
        return touches

    def _name(self, geom: int) -> str:
        body = int(self._model.geom_bodyid[geom])
        name: str = self._model.body(body).name
        return name.removeprefix("body_") if body else "table"

    def _compile(self) -> Any:
        spec = robot.mujoco_spec()
        for geom in spec.geoms:
            geom.contype, geom.conaffinity, geom.margin = _ROBOT, _ROBOT | _SCENE, MARGIN
        box, plane = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_PLANE
        spec.worldbody.add_geom(name="table", type=plane, size=[0, 0, 1], contype=_SCENE, conaffinity=0)
        spec.add_exclude(bodyname1="panda_link0", bodyname2="panda_link1")  # neighbours, but fixed
        for name, size in self._sizes.items():
            body = spec.worldbody.add_body(name=f"body_{name}", mocap=True)
            body.add_geom(name=f"body_{name}", type=box, size=list(size), contype=_SCENE, conaffinity=0)
        _add_ghost(spec)
        tool = spec.body(robot.TOOL_FRAME)
        for size, name in self._in_hand_name.items():
            tool.add_body(name=name).add_geom(
                name=name,
                type=box,
                size=list(size),
                contype=_ROBOT,
                conaffinity=_ROBOT | _SCENE,
                margin=MARGIN,
            )
        return spec.compile()


def _add_ghost(spec: Any) -> None:
    """A hand without an arm, far away until it is asked about.

    With a joint, since MuJoCo lets no two bodies collide that are both fixed to the world.
    """
    hand = spec.worldbody.add_body(name="ghost_panda_hand", pos=list(_NOWHERE_ELSE))
    hand.add_freejoint()
    for name in robot.HAND_LINKS:
        original = spec.body(name)
        is_hand = name == "panda_hand"
        ghost = hand if is_hand else hand.add_body(name=f"ghost_{name}")
        if not is_hand:
            ghost.pos, ghost.quat = original.pos, original.quat
        for geom in original.geoms:
            ghost.add_geom(
                type=geom.type,
                meshname=geom.meshname,
                pos=geom.pos,
                quat=geom.quat,
                contype=_GHOST,
                conaffinity=_SCENE,
                margin=MARGIN,
            )
