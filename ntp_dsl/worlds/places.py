"""The regions of the table where objects may be put down, in every world."""

from __future__ import annotations

from ntp_dsl.semantics.free_space import Region
from ntp_dsl.semantics.observation import TOO_WIDE
from ntp_dsl.worlds.protocol import Scene
from ntp_dsl.worlds.scenes import movable
from ntp_dsl.worlds.starts import REGION, WIDE

BORDER = 0.05  # around the arm's region [m]


def table_regions(scene: Scene) -> tuple[Region, Region]:
    """Return where objects are put down, and what is taken of the table where that is full."""
    region = _region(scene)
    return region, _bounds(region, scene)


def _region(scene: Scene) -> Region:
    """Return the arm's region, extended to where objects stand at the start."""
    (x0, x1), (y0, y1) = WIDE if any(obj.fixed for obj in scene.objects) else REGION
    names = {obj.name for obj in movable(scene.objects)} - {scene.held}
    standing = [place for name, place in scene.positions.items() if name in names]
    xs, ys = ([place[axis] for place in standing] for axis in (0, 1))
    return (min([x0, *xs]), max([x1, *xs])), (min([y0, *ys]), max([y1, *ys]))


def _bounds(region: Region, scene: Scene) -> Region:
    """Return the region and a border around it, and all that bins and trays take up."""
    fixed = [obj for obj in scene.objects if not obj.movable and obj.size[0] <= TOO_WIDE]
    sides = []
    for axis in (0, 1):
        ends = [
            scene.positions[obj.name][axis] + side * obj.size[axis] / 2 for obj in fixed for side in (-1, 1)
        ]
        low, high = region[axis]
        sides.append((min([low - BORDER, *ends]), max([high + BORDER, *ends])))
    return sides[0], sides[1]
