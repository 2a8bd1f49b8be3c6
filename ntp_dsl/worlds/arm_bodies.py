"""From a scene's objects to the bodies that the arm's simulation holds."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from kinematics.errors import UnusableShape
from kinematics.shapes import catalogue
from kinematics.shapes.bodies import PLAIN_FRICTION, Body, Colour
from kinematics.shapes.shapes import Box, Cylinder, Shape, half_extents_of
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.geometry import about_vertical
from ntp_dsl.semantics.observation import BIN_WALL, BOWL_WALL, TOO_WIDE, SceneObject
from ntp_dsl.worlds.protocol import Scene

DENSITY = 800.0  # of wood [kg/m3]
LIGHTEST, HEAVIEST = 0.05, 0.3  # of plain shapes: lighter ones jump in the fingers [kg]
BOWL_MASS = 0.12  # [kg]
ALIKE = 0.01  # difference between the extents of a file and of the scene [m]
NARROWEST_BOWL, LOWEST_BOWL = 0.05, 0.025  # [m]
COLOUR = "colour"  # the trait that decides an object's colour
MASS, FRICTION = "mass", "friction"  # and those that decide its mass [kg] and its coefficient of friction
PALETTE = (
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
NAMED = dict(
    zip("red blue yellow green purple orange cyan pink brown grey".split(), PALETTE, strict=True)
) | {"white": (0.95, 0.95, 0.93), "black": (0.12, 0.12, 0.13), "gray": PALETTE[-1]}
FIXED_COLOUR, BOWL_COLOUR = (0.70, 0.68, 0.64), (0.93, 0.92, 0.88)

T = TypeVar("T")


def bodies_of(scene: Scene) -> list[Body]:
    """Return the bodies of all objects but the table. Fixed ones have no mass.

    Raises `NtpError` for shapes that cannot be made.
    """
    objects = [obj for obj in scene.objects if obj.size[0] <= TOO_WIDE]
    shapes = [shape_of(obj) for obj in objects]
    colours = _colours(objects)
    bodies = []
    for obj, shape in zip(objects, shapes, strict=True):
        turned = about_vertical(scene.yaws.get(obj.name, 0.0))
        mass = _mass(obj) if obj.movable else 0.0
        at, colour = scene.positions[obj.name], colours[obj.name]
        bodies.append(Body(obj.name, shape, at, turned, mass, colour, _told(obj, FRICTION) or PLAIN_FRICTION))
    return bodies


def with_spread(body: Body, seed: int, spread: float) -> Body:
    """Return a body whose mass and friction are off by a share of at most `spread`, each by the seed."""
    if not spread:
        return body
    generator = np.random.default_rng((seed, 4, zlib.crc32(body.name.encode())))
    mass, friction = (1 + generator.uniform(-spread, spread, 2)).tolist()
    return replace(body, mass=body.mass * mass, friction=body.friction * friction)


def shape_of(obj: SceneObject) -> Shape:
    """Return an object's shape. Raises `NtpError` where it cannot be made."""
    x, y, z = obj.size
    match obj.shape:
        case "box":
            return Box((x / 2, y / 2, z / 2))
        case "cylinder":
            return Cylinder(x / 2, z)
        case "bin" if min(x, y) > 4 * BIN_WALL and z > 2 * BIN_WALL:
            return catalogue.tub((x / 2 - BIN_WALL, y / 2 - BIN_WALL, z - BIN_WALL), BIN_WALL)
        case "bowl" if x >= NARROWEST_BOWL and z >= LOWEST_BOWL:
            return catalogue.bowl(x / 2 - BOWL_WALL, z, BOWL_WALL)
        case "mesh" | "urdf":
            return _from_file(obj)
    measures = " x ".join(f"{100 * each:g}" for each in obj.size)
    least = f"{100 * NARROWEST_BOWL:g} cm wide and {100 * LOWEST_BOWL:g} cm high"
    raise NtpError(
        f"{obj.name} is a {obj.shape} of {measures} cm, which cannot be made for the arm; "
        f"there are boxes, cylinders, bins, bowls from {least}, meshes and URDFs"
    )


def _from_file(obj: SceneObject) -> Shape:
    """Return a mesh scaled to the scene's extents, or a URDF's shape, whose extents must be the scene's."""
    path = Path(obj.file)
    if not path.is_file():
        raise NtpError(f"{obj.name} is made of {path}, and there is no such file")
    try:
        if obj.shape == "mesh":
            return catalogue.hull_of_size(path, obj.size)
        shape = catalogue.compound_from_urdf(path)
    except (UnusableShape, ValueError, RuntimeError) as unexpected:
        raise NtpError(f"{obj.name} cannot be made of {path}: {unexpected}") from unexpected
    extents = [2 * half for half in half_extents_of(shape)]
    if any(abs(a - b) > ALIKE for a, b in zip(extents, obj.size, strict=True)):
        found, given = (", ".join(f"{100 * each:.1f} cm" for each in sizes) for sizes in (extents, obj.size))
        raise NtpError(f"{obj.name}: {path} measures {found}, and the scene gives {given}; take the first")
    return shape


def _mass(obj: SceneObject) -> float:
    x, y, z = obj.size
    if told := _told(obj, MASS):
        return told
    if obj.shape == "bowl":
        return BOWL_MASS
    mass = _from_urdf(obj, catalogue.mass_from_urdf)
    return mass or min(max(DENSITY * x * y * z, LIGHTEST), HEAVIEST)


def _told(obj: SceneObject, trait: str) -> float | None:
    """Return a number that the scene gives an object. Raises `NtpError` where it is not above zero."""
    value = dict(obj.traits).get(trait)
    if not isinstance(value, float):
        return None
    if value <= 0:
        raise NtpError(f"{obj.name}: expected a {trait} above zero, found {value:g}; mend it in the scene")
    return value


def _colours(objects: list[SceneObject]) -> Mapping[str, Colour]:
    """Return each object's colour: by the trait of that name, its first trait or its kind, else the next."""
    values = list(dict.fromkeys(obj.traits[0] for obj in objects if obj.traits))
    own = {obj.name: colour for obj in objects if (colour := _own_colour(obj)) is not None}
    plain = [obj.name for obj in objects if obj.movable and not obj.traits and obj.name not in own]
    found: dict[str, Colour] = {}
    for obj in objects:
        named = NAMED.get(str(dict(obj.traits).get(COLOUR)))
        if named is None and obj.traits:
            named = PALETTE[values.index(obj.traits[0]) % len(PALETTE)]
        elif named is None and obj.name in plain:
            named = PALETTE[plain.index(obj.name) % len(PALETTE)]
        found[obj.name] = (*named, 1.0) if named else own.get(obj.name, (*FIXED_COLOUR, 1.0))
    return found


def _own_colour(obj: SceneObject) -> Colour | None:
    if obj.shape == "bowl":
        return *BOWL_COLOUR, 1.0
    return _from_urdf(obj, catalogue.colour_from_urdf)


def _from_urdf(obj: SceneObject, read: Callable[[Path], T | None]) -> T | None:
    """Return what `read` finds in an object's URDF; None for other shapes."""
    try:
        return read(Path(obj.file)) if obj.shape == "urdf" else None
    except (UnusableShape, ValueError) as unexpected:
        raise NtpError(f"{obj.name} cannot be made of {obj.file}: {unexpected}") from unexpected
