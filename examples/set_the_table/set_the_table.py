"""The functions in Python of `set_the_table.ntp`."""

from itertools import product
from math import dist, hypot

from ntp_dsl.authoring import call, expert, predicate, sampler, skill

WAYS = {"left": (0, 1), "right": (0, -1), "ahead": (1, 0)}  # x leads away from the robot


def _from_place(observation, item, plate, side):
    """Return the distance from a piece's place on that side, 12 cm from the plate's middle [m]."""
    (x, y, _), (px, py, _) = observation.positions[item], observation.positions[plate]
    return hypot(x - px - 0.12 * WAYS[side][0], y - py - 0.12 * WAYS[side][1])


@predicate
def near(observation, item, plate, side):
    return item in observation.positions and _from_place(observation, item, plate, side) < 0.05


@predicate
def beside(observation, piece, plate, side):
    if piece == observation.held or not near(observation, piece, plate, side):
        return False
    return observation.positions[piece][2] < observation.by_name[piece].size[2] / 2 + 0.01


@predicate
def over(observation, hand, plate, side):
    return bool(observation.held) and _from_place(observation, observation.held, plate, side) < 0.03


@skill
def move_beside(world, plate, side, distance):
    x, y, _ = world.observe().positions[plate]
    return world.move_over(x + distance * WAYS[side][0], y + distance * WAYS[side][1])


@skill
def set_aside(world, item, plate, side):
    others = [xy for name, (*xy, _) in world.observe().positions.items() if name not in (item, "table")]
    spots = product((0.62, 0.7), (-0.24, -0.12, 0.0, 0.12, 0.24))
    return world.move_over(*max(spots, key=lambda spot: min(dist(spot, xy) for xy in others)))


@expert
def lay(world, piece, plate, side):
    if any(world.near(other, plate, side) for other in world.objects("Piece") if other != piece):
        return call("make_room", plate, side)
    return call("bring", piece, plate, side) if world.holding(piece) else call("pick", piece)


@sampler
def covers(rng, plates, sides, forks, knives, cups, length, topology, semantics):
    slots = topology.permutation(list(product(plates, sides)))
    chosen = semantics.permutation([*forks, *knives, *cups])[:length]
    return [(piece, *slot) for piece, slot in zip(chosen, slots, strict=False)]
