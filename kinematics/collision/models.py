"""From a robot and the shapes of a cell to the two MuJoCo models of the checker.

One is small and is asked thousands of times: is this configuration free? The other answers what is
asked now and then: does a hand alone fit there, how far is this from that.
"""

import itertools
from collections.abc import Mapping
from functools import cache
from typing import Any

import mujoco
import numpy as np

from kinematics.geometry.transforms import Array, pose_of, wxyz
from kinematics.robot import models
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot
from kinematics.shapes.shapes import (
    Box,
    Convex,
    Cylinder,
    Hull,
    Piece,
    Shape,
    Sphere,
    half_extents_of,
    pieces_of,
)

TABLE = "table"
MARGIN = 0.004  # clearance is measured up to here [m]
ROBOT, SCENE, GHOST = 1, 2, 4
NOWHERE = (0.0, 0.0, 50.0)
NOWHERE_ELSE = (0.0, 0.0, 100.0)
LOWER_TABLE = 1.2e-3  # the table is where it is: fingers may come nearer to it than to what may move [m]
ALWAYS = 0.95  # of random configurations in which two links that touch are built that way
SAMPLES = 200


def in_hand_names(shapes: Mapping[str, Shape], fixed: frozenset[str]) -> dict[Shape, str]:
    """One body of the model for each shape that can be in the hand."""
    loose = dict.fromkeys(shape for name, shape in shapes.items() if name not in fixed)
    return {shape: f"held_{i}" for i, shape in enumerate(loose)}


def for_planning(
    robot: Robot, shapes: Mapping[str, Shape], in_hand: Mapping[Shape, str], margin: float
) -> Any:
    """Arm, table, every body, and every shape that can be held once more in the hand."""
    spec = _with_bodies(robot, shapes, margin)
    for first, second in always_touching(robot):
        spec.add_exclude(bodyname1=first, bodyname2=second)
    tool = spec.body(robot.tool_frame)
    for shape, name in in_hand.items():
        held = tool.add_body(name=name)
        for piece in pieces_of(shape):
            _add(spec, held, piece, contype=ROBOT, conaffinity=ROBOT | SCENE, margin=margin)
    return spec.compile()


def for_distances(
    robot: Robot, shapes: Mapping[str, Shape], in_hand: Mapping[Shape, str], margin: float, slimmer: float
) -> Any:
    """A ghost of the hand, the table, every body, and every shape that can be held, slimmer, in the hand."""
    spec = _with_bodies(robot, shapes, margin)
    for geom in spec.geoms:
        if geom.contype == ROBOT:
            geom.contype = geom.conaffinity = 0
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(name=f"{TABLE}_top", type=plane, size=[0, 0, 1], contype=0, conaffinity=0)
    _add_ghost(spec, robot, margin)
    tool = spec.body(robot.tool_frame)
    for shape, name in in_hand.items():
        held = tool.add_body(name=name)
        for piece in pieces_of(shape):
            _add(spec, held, _slimmed(piece, slimmer), contype=0, conaffinity=0)
    return spec.compile()


def _with_bodies(robot: Robot, shapes: Mapping[str, Shape], margin: float) -> Any:
    spec = models.mujoco_spec(robot)
    # One point of contact a pair is enough, and with several its distance is not the least to the micrometre.
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_MULTICCD)
    spec.compiler.discardvisual = False  # what only measures distances collides with nothing, but stays
    for geom in spec.geoms:
        geom.contype, geom.conaffinity, geom.margin = ROBOT, ROBOT | SCENE, margin
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    world = spec.worldbody
    world.add_geom(
        name=TABLE, type=plane, size=[0, 0, 1], pos=[0, 0, -LOWER_TABLE], contype=SCENE, conaffinity=0
    )
    for name, shape in shapes.items():
        body = world.add_body(name=f"body_{name}", mocap=True)
        for piece in pieces_of(shape):
            _add(spec, body, piece, contype=SCENE, conaffinity=0)
    return spec


@cache
def always_touching(robot: Robot) -> tuple[tuple[str, str], ...]:
    """Pairs of links nearer than `MARGIN` at home, or nearly everywhere: neighbours, as they are built.

    And all pairs within the hand, whose joints no path moves.
    """
    spec = models.mujoco_spec(robot)
    for geom in spec.geoms:
        geom.margin = MARGIN
    model = spec.compile()
    data = mujoco.MjData(model)
    for link, transform in gripper_of(robot).link_poses(gripper_of(robot).maximum_opening).items():
        body, pose = model.body(link).id, pose_of(transform)
        model.body_pos[body], model.body_quat[body] = pose.position, wxyz(pose.quaternion_xyzw)
    generator = np.random.default_rng(0)
    limits = robot.limits
    counts: dict[tuple[str, str], int] = {}
    at_home = _pairs(model, data, robot.home)
    for q in generator.uniform(limits.lower, limits.upper, (SAMPLES, robot.dof)):
        for pair in _pairs(model, data, q):
            counts[pair] = counts.get(pair, 0) + 1
    often = {pair for pair, count in counts.items() if count >= ALWAYS * SAMPLES}
    order = sorted(robot.hand_links, key=lambda link: int(model.body(link).id))
    return tuple(sorted(often | at_home | set(itertools.combinations(order, 2))))


@cache
def reaches(robot: Robot) -> Array:
    """(dof,) how far any point of the arm moves when a joint does [m/rad]; 1 where that one slides.

    The farthest from its axis that spheres around the links were seen, in random configurations.
    """
    model = models.mujoco_model(robot)
    data = mujoco.MjData(model)
    moved = [[g for g in range(model.ngeom) if _is_moved(model, g, joint)] for joint in range(model.njnt)]
    limits = robot.limits
    found = np.zeros(robot.dof)
    for q in np.random.default_rng(0).uniform(limits.lower, limits.upper, (SAMPLES, robot.dof)):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        for joint, geoms in enumerate(moved):
            away = np.cross(data.geom_xpos[geoms] - data.xanchor[joint], data.xaxis[joint])
            far = np.linalg.norm(away, axis=1) + model.geom_rbound[geoms]
            found[joint] = max(found[joint], float(far.max(initial=0.0)))
    found[model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE] = 1.0
    return found


def _is_moved(model: Any, geom: int, joint: int) -> bool:
    body = model.geom_bodyid[geom]
    while body > model.jnt_bodyid[joint]:  # a parent has a lower number
        body = model.body_parentid[body]
    return bool(body == model.jnt_bodyid[joint])


def _pairs(model: Any, data: Any, q: Any) -> set[tuple[str, str]]:
    data.qpos[:] = q
    mujoco.mj_kinematics(model, data)
    mujoco.mj_collision(model, data)
    bodies = model.geom_bodyid[data.contact.geom[: data.ncon]]
    return {(model.body(a).name, model.body(b).name) for a, b in np.sort(bodies, axis=1).tolist()}


def _add(spec: Any, body: Any, piece: Piece, **options: Any) -> None:
    settings: dict[str, Any] = {
        **options,
        "pos": list(piece.position),
        "quat": list(wxyz(piece.quaternion_xyzw)),
    }
    shape = piece.shape
    if isinstance(shape, Hull):
        mesh = spec.add_mesh(name=f"hull_{len(spec.meshes)}", uservert=[c for p in shape.points for c in p])
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name, **settings)
        return
    kind, size = _primitive(shape)
    body.add_geom(type=kind, size=size, **settings)


def _primitive(shape: Box | Cylinder | Sphere) -> tuple[Any, list[float]]:
    if isinstance(shape, Box):
        return mujoco.mjtGeom.mjGEOM_BOX, list(shape.half_extents)
    if isinstance(shape, Cylinder):
        return mujoco.mjtGeom.mjGEOM_CYLINDER, [shape.radius, shape.height / 2, 0.0]
    return mujoco.mjtGeom.mjGEOM_SPHERE, [shape.radius, 0.0, 0.0]


def _slimmed(piece: Piece, by: float) -> Piece:
    return Piece(_slim(piece.shape, by), piece.position, piece.quaternion_xyzw)


def _slim(shape: Convex, by: float) -> Convex:
    """The same shape with every face this much further in; thin ones keep a tenth."""
    if isinstance(shape, Box):
        x, y, z = (max(half - by, 0.1 * half) for half in shape.half_extents)
        return Box((x, y, z))
    if isinstance(shape, Cylinder):
        radius, half = (max(size - by, 0.1 * size) for size in (shape.radius, shape.height / 2))
        return Cylinder(radius, 2 * half)
    if isinstance(shape, Sphere):
        return Sphere(max(shape.radius - by, 0.1 * shape.radius))
    scale = [max(1 - by / half, 0.1) for half in half_extents_of(shape)]
    return Hull(tuple((x * scale[0], y * scale[1], z * scale[2]) for x, y, z in shape.points))


def _add_ghost(spec: Any, robot: Robot, margin: float) -> None:
    """A hand without an arm, far away until it is asked about.

    With a joint, since MuJoCo lets no two bodies collide that are both fixed to the world.
    """
    ghosts: dict[str, Any] = {}
    for link in robot.hand_links:
        original = spec.body(link)
        if not ghosts:
            ghosts[link] = spec.worldbody.add_body(name=f"ghost_{link}", pos=list(NOWHERE_ELSE))
            ghosts[link].add_freejoint()
        else:
            ghosts[link] = ghosts[robot.urdf.parent_joint[link].parent].add_body(name=f"ghost_{link}")
            ghosts[link].pos, ghosts[link].quat = original.pos, original.quat
        for geom in original.geoms:
            ghosts[link].add_geom(
                type=geom.type,
                meshname=geom.meshname,
                size=geom.size,
                pos=geom.pos,
                quat=geom.quat,
                contype=GHOST,
                conaffinity=SCENE,
                margin=margin,
            )
