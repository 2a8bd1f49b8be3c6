"""From a robot and the shapes of a cell to the two MuJoCo models of the checker.

A small one for collision checks, of which a plan needs thousands, and one for distance queries, which are
rare.
"""

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

import mujoco
import numpy as np

from kinematics.geometry.transforms import Array
from kinematics.robot import models
from kinematics.robot.robot import Robot
from kinematics.shapes.bodies import TABLE
from kinematics.shapes.mujoco_pieces import add_piece
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

MARGIN = 0.004  # up to which clearance is measured [m]
ROBOT, SCENE, GHOST = 1, 2, 4
PARKED = (0.0, 0.0, 50.0)  # where absent bodies are [m]
GHOST_PARKED = (0.0, 0.0, 100.0)  # where the hand without an arm is between queries [m]
TABLE_LOWERED = 1.2e-3  # the table is fixed: fingers may come nearer to it than to movable bodies [m]
CONFIGURATIONS = 200  # random ones, for what is measured over all postures


def held_body_names(shapes: Mapping[str, Shape], fixed: frozenset[str]) -> dict[Shape, str]:
    """Return the name of one body of the model for each shape that can be in the hand."""
    movable = dict.fromkeys(shape for name, shape in shapes.items() if name not in fixed)
    return {shape: f"held_{i}" for i, shape in enumerate(movable)}


def for_planning(
    robot: Robot,
    shapes: Mapping[str, Shape],
    in_hand: Mapping[Shape, str],
    margin: float,
    unchecked: Iterable[tuple[str, str]],
) -> Any:
    """Return arm, table, every body, and a second body in the hand for every shape that can be held.

    Args:
        unchecked: pairs of links whose contacts do not count.
    """
    spec = _with_bodies(robot, shapes, margin)
    for first, second in unchecked:
        spec.add_exclude(bodyname1=first, bodyname2=second)
    tool = spec.body(robot.tool_frame)
    for shape, name in in_hand.items():
        held = tool.add_body(name=name)
        for piece in pieces_of(shape):
            add_piece(spec, held, piece, contype=ROBOT, conaffinity=ROBOT | SCENE, margin=margin)
    return spec.compile()


def for_distances(
    robot: Robot, shapes: Mapping[str, Shape], in_hand: Mapping[Shape, str], margin: float, shrinkage: float
) -> Any:
    """Return a hand without an arm, table, every body, and in the hand, shrunk, all shapes it can hold."""
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
            add_piece(spec, held, _shrunk_piece(piece, shrinkage), contype=0, conaffinity=0)
    return spec.compile()


def _with_bodies(robot: Robot, shapes: Mapping[str, Shape], margin: float) -> Any:
    spec = models.mujoco_spec(robot)
    # One contact point a pair is enough; with several, the least distance is inexact by micrometres.
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_MULTICCD)
    spec.compiler.discardvisual = False  # keep the geoms that only measure distances and never collide
    for geom in spec.geoms:
        geom.contype, geom.conaffinity, geom.margin = ROBOT, ROBOT | SCENE, margin
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    world = spec.worldbody
    world.add_geom(
        name=TABLE, type=plane, size=[0, 0, 1], pos=[0, 0, -TABLE_LOWERED], contype=SCENE, conaffinity=0
    )
    for name, shape in shapes.items():
        body = world.add_body(name=f"body_{name}", mocap=True)
        for piece in pieces_of(shape):
            add_piece(spec, body, piece, contype=SCENE, conaffinity=0)
    return spec


@cache
def lever_arms(robot: Robot) -> Array:
    """Return (dof,) how far any point of the arm moves with each joint [m/rad]; 1 for a sliding joint.

    The largest distance of the links' bounding spheres from the joint's axis, over random configurations.
    """
    model = models.mujoco_model(robot)
    data = mujoco.MjData(model)
    moved = [[g for g in range(model.ngeom) if _is_moved(model, g, joint)] for joint in range(model.njnt)]
    limits = robot.limits
    found = np.zeros(robot.dof)
    for q in np.random.default_rng(0).uniform(limits.lower, limits.upper, (CONFIGURATIONS, robot.dof)):
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


def _shrunk_piece(piece: Piece, by: float) -> Piece:
    return Piece(_shrunk(piece.shape, by), piece.position, piece.quaternion_xyzw)


def _shrunk(shape: Convex, by: float) -> Convex:
    """Return the shape with every face moved inwards [m]; thin shapes keep a tenth."""
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
    """Add a hand without an arm, far away between queries.

    It has a joint, since MuJoCo lets no two bodies collide that are both fixed to the world.
    """
    ghosts: dict[str, Any] = {}
    for link in robot.hand_links:
        original = spec.body(link)
        if not ghosts:
            ghosts[link] = spec.worldbody.add_body(name=f"ghost_{link}", pos=list(GHOST_PARKED))
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
