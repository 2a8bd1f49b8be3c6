"""From a thing of a scene to a body of the cell: its shape, where it starts, whether it ever moves."""

from __future__ import annotations

from math import cos, sin
from pathlib import Path

from kinematics import catalogue
from kinematics.bodies import Body
from kinematics.shapes import Box, Cylinder, Shape
from ntp_dsl.language.diagnostics import NtpError
from ntp_dsl.world import WALL, Scene, Thing

BOWL_WALL = 0.004  # [m]
DENSITY = 800.0  # of a solid thing [kg/m3]
LIGHTEST, HEAVIEST = 0.02, 0.5  # [kg]
MASS = 0.1  # of a box, whatever its size [kg]
COLOURS = (
    (0.86, 0.24, 0.22),
    (0.20, 0.48, 0.78),
    (0.96, 0.76, 0.20),
    (0.30, 0.66, 0.36),
    (0.58, 0.38, 0.72),
    (0.95, 0.53, 0.20),
    (0.35, 0.75, 0.78),
    (0.90, 0.58, 0.72),
    (0.55, 0.43, 0.32),
    (0.62, 0.65, 0.68),
)


def body_of(thing: Thing, number: int, scene: Scene) -> Body:
    """The body of a thing, where the scene has it start."""
    yaw = scene.yaws.get(thing.name, 0.0)
    return Body(
        thing.name,
        shape_of(thing),
        scene.positions[thing.name],
        (0.0, 0.0, sin(yaw / 2), cos(yaw / 2)),
        0.0 if thing.fixed else _mass(thing),
        colour=(*COLOURS[number % len(COLOURS)], 1.0),
    )


def shape_of(thing: Thing) -> Shape:
    """As solid as the arm meets it."""
    length, width, height = thing.size
    if thing.shape == "cylinder":
        return Cylinder(length / 2, height)
    if thing.shape == "bowl":
        return catalogue.bowl(length / 2 - BOWL_WALL, height, BOWL_WALL)
    if thing.shape == "bin":
        return catalogue.tub((length / 2 - WALL, width / 2 - WALL, height - WALL), WALL)
    if thing.shape == "fork":
        return catalogue.fork(length, height)
    if thing.shape == "mesh":
        return catalogue.hull_of_size(_file(thing), thing.size)
    if thing.shape == "urdf":
        return catalogue.compound_from_urdf(_file(thing))
    return Box((length / 2, width / 2, height / 2))


def _file(thing: Thing) -> Path:
    path = Path(thing.file)
    if not path.is_file():
        raise NtpError(f"the {thing.shape} of '{thing.name}' is not there: {path}")
    return path


def _mass(thing: Thing) -> float:
    if thing.shape == "box":
        return MASS
    length, width, height = thing.size
    return min(HEAVIEST, max(LIGHTEST, DENSITY * length * width * height / 2))
