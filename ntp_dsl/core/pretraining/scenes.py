"""Made-up moments: random objects, piled up and handled at random. No library is needed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.geometry import Vector, moved
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.perturbed_starts import perturbed_start
from ntp_dsl.worlds.protocol import Disturbances
from ntp_dsl.worlds.random_handling import handle_at_random
from ntp_dsl.worlds.scenes import TABLE, TABLE_SIZE

PRIMITIVES = 8  # of a scene
LOOKS = 8  # at a scene
FURNITURE = SceneObject(TABLE, "Table", TABLE_SIZE, fixed=True)


def moments(rng: np.random.Generator) -> list[Observation]:
    """Return some moments of one random scene."""
    world = KinematicWorld(placement_error=float(rng.choice([0.0007, 0.0025])))
    try:
        scene = perturbed_start(random_objects(rng), rng, straight=float(rng.choice([0.4, 0.8])))
    except NtpError:  # there was no room for so many
        return []
    clumsy = float(rng.choice([0.0, 0.3]))
    world.reset(scene, int(rng.integers(2**31)), Disturbances(0.1, 0.2, 0.0, clumsy))
    frames = [world.truth()]
    world.on_frame = lambda seen: frames.append(world.truth())
    for _ in range(PRIMITIVES):
        handle_at_random(world, rng)
        frames += [world.truth()] * 3  # decisions are made between primitives
    chosen = rng.choice(len(frames), size=min(LOOKS, len(frames)), replace=False)
    return [frames[index] for index in sorted(chosen)]


def random_objects(rng: np.random.Generator) -> tuple[SceneObject, ...]:
    """Return a table and two to twelve objects of random shapes and sizes, some of them fixed."""
    found = [FURNITURE]
    shares = NESTING if rng.random() < NESTED else SHARES
    for index in range(int(rng.integers(2, 13))):
        kind = int(rng.choice(len(KINDS), p=shares))
        shape, size, fixed = KINDS[kind](rng)
        found.append(SceneObject(f"o{index}", "Object", size, shape, fixed=fixed))
    return tuple(found)


def _box(rng: np.random.Generator) -> tuple[str, Vector, bool]:
    if rng.random() < 0.4:
        side = float(rng.uniform(0.012, 0.07))
        return "box", (side, side, side), False
    x, y, z = rng.uniform((0.012, 0.012, 0.006), (0.08, 0.2 if rng.random() < 0.2 else 0.08, 0.1)).tolist()
    return "box", (x, y, z), bool(rng.random() < 0.1)


def _cylinder(rng: np.random.Generator) -> tuple[str, Vector, bool]:
    width, height = rng.uniform((0.012, 0.01), (0.08, 0.1)).tolist()
    return "cylinder", (width, width, height), bool(rng.random() < 0.1)


def _bin(rng: np.random.Generator) -> tuple[str, Vector, bool]:
    x, y, z = rng.uniform((0.05, 0.05, 0.025), (0.24, 0.24, 0.1)).tolist()
    return "bin", (x, y, z), bool(rng.random() < 0.6)


def _bowl(rng: np.random.Generator) -> tuple[str, Vector, bool]:
    width, height = rng.uniform((0.05, 0.025), (0.18, 0.08)).tolist()
    return "bowl", (width, width, height), bool(rng.random() < 0.2)


def _tray(rng: np.random.Generator) -> tuple[str, Vector, bool]:
    x, y, z = rng.uniform((0.121, 0.121, 0.004), (0.5, 0.5, 0.03)).tolist()
    return "box", (x, y, z), True


def _pad(rng: np.random.Generator) -> tuple[str, Vector, bool]:
    x, y, z = rng.uniform((0.03, 0.03, 0.004), (0.12, 0.12, 0.03)).tolist()
    return "box", (x, y, z), True


KINDS = (_box, _cylinder, _bin, _bowl, _tray, _pad)
SHARES = (0.4, 0.2, 0.1, 0.1, 0.08, 0.12)
NESTED, NESTING = 0.3, (0.15, 0.1, 0.4, 0.35, 0.0, 0.0)  # of the scenes, and there: hollows in hollows


def shaken(seen: Observation, rng: np.random.Generator) -> Observation:
    """Return the moment with everything movable moved by millimetres, so that facts are close calls."""
    size = float(rng.uniform(0.003, 0.02))
    positions = {
        name: moved(at, rng.normal(0, size, 3)) if seen.by_name[name].movable else at
        for name, at in seen.positions.items()
    }
    x, y, z = np.array(seen.gripper) + rng.normal(0, size, 3)
    return replace(seen, positions=positions, gripper=(float(x), float(y), float(z)))


def closed_on(truth: Observation, rng: np.random.Generator) -> Observation:
    """Return the moment with the hand closed somewhere about an object: other hands grasp otherwise."""
    solid = [obj.name for obj in truth.objects if obj.movable and obj.cavity is None]
    known = [name for name in solid if name in truth.positions]
    if not known:
        return truth
    name = str(rng.choice(known))
    aside = float(rng.choice([0.0003, 0.003, 0.02]))
    rise = rng.uniform(-0.6, 0.6) * truth.by_name[name].size[2] + rng.normal(0, 0.015)
    by = np.array([*rng.normal(0, aside, 2), rise])
    return replace(truth, gripper=moved(truth.positions[name], by), closed=True)


def looked_at(truth: Observation, rng: np.random.Generator) -> Observation:
    """Return what a tracker makes of a moment: each object with its own doubt, and off by as much."""
    sigma = float(rng.uniform(0, 0.02)) if rng.random() < 0.7 else 0.0
    if not sigma:
        return truth
    deviations = {name: sigma * float(rng.uniform(0.25, 1.0)) for name in truth.positions}
    positions = {name: moved(at, rng.normal(0, deviations[name], 3)) for name, at in truth.positions.items()}
    return replace(truth, positions=positions, deviations=deviations)
