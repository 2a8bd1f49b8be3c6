"""From a robot and the bodies of a cell to a MuJoCo model with motors, contacts and friction.

An arm's joints have position controllers with velocity feed-forward and carry their own weight, as a real
arm's controller sees to. Fingers are coupled by joint equalities.

MuJoCo takes the larger of two friction coefficients, where a cell's bodies multiply theirs. Robot and table
have nearly none of their own here, so that what touches them brings its own, as times one.
"""

from collections.abc import Sequence
from typing import Any

import mujoco

from kinematics.errors import UnusableRobot, UnusableShape, unforeseen_is_unusable
from kinematics.geometry.transforms import wxyz
from kinematics.planning.trajectory import TIME_STEP
from kinematics.robot import models
from kinematics.robot.gripper import Gripper, gripper_of
from kinematics.robot.robot import Robot
from kinematics.shapes.bodies import TABLE, Body
from kinematics.shapes.mujoco_pieces import add_piece
from kinematics.shapes.shapes import Cylinder, Hull, Piece, Sphere, pieces_of, volume_of

SUBSTEPS = 3  # of a cell's step: a held body would drift where the hand moves along a curve
STIFFNESS, DAMPING = 10000.0, 200.0  # of an arm joint's controller [N m/rad], [N m s/rad]
ARMATURE = 0.1  # of an arm joint: its motor's inertia behind the gears [kg m2]
FINGER_STIFFNESS, FINGER_DAMPING = 8000.0, 200.0  # at the finger's pad [N/m], [N s/m]
FINGER_ARMATURE = 0.05  # at the finger's pad [kg]
TORSION, ROLLING = 3e-3, 1e-4  # friction against turning on the spot and against rolling [m]
ROUND_ROLLING = 2e-3  # of bodies that roll, as on a tablecloth [m]
_ROBOT, _MOVABLE, _FIXED = 1, 2, 4  # which geoms meet: the robot not itself, nor fixed bodies each other
_LIGHTEST = (1e-6, 1e-10)  # mass and moment that MuJoCo can do with [kg], [kg m2]
_TABLE = [50.0, 50.0, 0.5]  # half extents [m]
_NOTHING = 1e-5  # the least friction that MuJoCo takes
_CONTACT = (2 * TIME_STEP / SUBSTEPS, 1.0)  # time constant and damping ratio: as hard as the time step admits
_IMPEDANCE = (0.95, 0.99, 0.001)  # of contacts, and the depth at which it rises [1], [m]: pads give half a mm
_GEAR = (0.004, 1.0)  # time constant and damping ratio of what couples the fingers


def cell_model(robot: Robot, bodies: Sequence[Body]) -> Any:
    """Return arm, table and bodies; movable bodies have free joints, fixed ones their pose.

    Joints, actuators and bodies are called as the URDF's joints and links, and as the bodies themselves.
    """
    with unforeseen_is_unusable(robot.urdf.path):
        spec = models.mujoco_spec_of(models.for_dynamics(robot), robot)
        _set_options(spec)
        _set_links(spec)
        _add_motors(spec, robot)
    _add_table(spec)
    for body in bodies:
        _add_body(spec, body)
    for geom in spec.geoms:
        geom.solref, geom.solimp[:3] = _CONTACT, _IMPEDANCE
    try:
        return models.compiled(spec, robot)
    except UnusableRobot as unexpected:
        if not bodies:
            raise
        raise UnusableShape(f"bodies that MuJoCo cannot make: {unexpected.__cause__}") from unexpected


def name_of(body: str) -> str:
    """Return the name of a cell's body in the model, which no link has."""
    return f"body/{body}"


def _set_options(spec: Any) -> None:
    option = spec.option
    option.timestep = TIME_STEP / SUBSTEPS
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10.0  # a held body creeps out of the hand otherwise
    option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP  # what rests costs no time
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET  # what flies apart is to be noticed
    spec.compiler.boundmass, spec.compiler.boundinertia = _LIGHTEST


def _set_links(spec: Any) -> None:
    """Give the links their weights, which are compensated, and their contacts."""
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    for body in spec.bodies:
        body.gravcomp = 1.0
        _take_moments_from_shapes(body)
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = _ROBOT, 0
        geom.friction = [_NOTHING, TORSION, ROLLING]
        geom.condim = 4


def _add_motors(spec: Any, robot: Robot) -> None:
    for name, effort in zip(robot.arm_joints, robot.limits.effort, strict=True):
        spec.joint(name).armature = ARMATURE
        spec.joint(name).actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE  # the motor has the limit
        _add_servo(spec, name, STIFFNESS, DAMPING, float(effort))
    gripper = gripper_of(robot)
    first = robot.finger_joints[0].name
    for joint, rate in zip(robot.finger_joints, gripper.rates, strict=True):
        lever = abs(rate)  # [1] or [rad/m]
        spec.joint(joint.name).armature = FINGER_ARMATURE / lever**2
        spec.joint(joint.name).actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
        spec.joint(joint.name).solref_limit, spec.joint(joint.name).solimp_limit[:3] = _CONTACT, _IMPEDANCE
        _add_servo(spec, joint.name, FINGER_STIFFNESS / lever**2, FINGER_DAMPING / lever**2, 1.0)
        if joint.name != first:
            _couple(spec, joint.name, first, gripper)


def _take_moments_from_shapes(link: Any) -> None:
    """Keep a link's mass, spread over its shapes, as PyBullet does: many a URDF has moments made up."""
    geoms = list(link.geoms)
    if geoms and link.mass > 0:
        for geom in geoms:
            geom.mass = link.mass / len(geoms)


def _add_servo(spec: Any, joint: str, stiffness: float, damping: float, force: float) -> None:
    """Add a controller of a joint's position; its set point leads by the velocity times damping/stiffness."""
    servo = spec.add_actuator(name=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint)
    servo.gaintype, servo.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    servo.gainprm[0] = stiffness
    servo.biasprm[:3] = [0.0, -stiffness, -damping]
    servo.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
    servo.forcerange = [-force, force]


def _couple(spec: Any, joint: str, first: str, gripper: Gripper) -> None:
    """Make a finger joint a linear function of the first one."""
    closed, opened = gripper.values(0.0), gripper.values(gripper.maximum_opening)
    ratio = (opened[joint] - closed[joint]) / (opened[first] - closed[first])
    gear = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1=joint, name2=first)
    gear.data = [closed[joint] - ratio * closed[first], ratio, *[0.0] * 10]
    gear.solref = list(_GEAR)


def _add_table(spec: Any) -> None:
    """Add the table as a box: on a plane, a cylinder that stands upright to the last bit may jump."""
    spec.worldbody.add_geom(
        name=TABLE,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=_TABLE,
        pos=[0, 0, -_TABLE[2]],
        contype=_FIXED,
        conaffinity=_ROBOT | _MOVABLE,
        friction=[_NOTHING, TORSION, ROLLING],
        condim=4,
    )


def _add_body(spec: Any, body: Body) -> None:
    made = spec.worldbody.add_body(name=name_of(body.name))
    if body.is_fixed:
        made.pos, made.quat = body.position, wxyz(body.quaternion_xyzw)
    else:
        made.add_freejoint(name=name_of(body.name))
    pieces = pieces_of(body.shape)
    volumes = [volume_of(piece.shape) for piece in pieces]
    for piece, volume in zip(pieces, volumes, strict=True):
        geom = add_piece(spec, made, piece)
        geom.contype = _FIXED if body.is_fixed else _MOVABLE
        geom.conaffinity = _ROBOT | _MOVABLE
        geom.mass = body.mass * volume / sum(volumes)
        geom.friction = [body.friction, TORSION, ROUND_ROLLING if _rolls(piece) else ROLLING]
        geom.condim = 6 if _rolls(piece) else 4


def _rolls(piece: Piece) -> bool:
    return isinstance(piece.shape, Sphere | Cylinder | Hull)
