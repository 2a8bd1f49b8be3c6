"""A question as a picture: the scene from above, and which objects each of the offers names."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from html import escape
from math import atan2, degrees

from ntp_dsl.semantics.observation import Observation, SceneObject

SCALE = 1500  # pixels a metre
MARGIN = 0.06  # around the objects that are named [m]
APART = 5  # pixels between the lines of two offers that name the same objects
KEY = 24  # pixels a line of the key
LETTER = 7.2
COLOURS = ("#0a5cc2", "#bf3989", "#1a7f37", "#9a6700", "#8250df")
ROUND = ("cylinder", "bowl", "sphere")
STYLE = """
text { font: 12px ui-monospace, "DejaVu Sans Mono", monospace; fill: #24292f; }
.page { fill: #ffffff; }
.object { fill: #eaeef2; stroke: #8c959f; }
.name { font-size: 10px; fill: #57606a; text-anchor: middle; }
.way { fill: none; stroke-width: 3; stroke-linejoin: round; }
.number { fill: #ffffff; font-weight: bold; text-anchor: middle; }
@media (prefers-color-scheme: dark) {
text { fill: #e6edf3; }
.page { fill: #0d1117; }
.object { fill: #21262d; stroke: #6e7681; }
.name { fill: #9da7b3; }
.number { fill: #ffffff; }
}
"""

Point = tuple[float, float]
Offer = tuple[Sequence[str], str]  # the names in what may be meant, and its text


def question_picture(seen: Observation, offered: Sequence[Offer], title: str) -> str:
    """Return an SVG of what is around the objects in question, from above; the arm's base lies below it.

    Args:
        offered: what may be meant: the names, of which a line leads along those of objects, in their order,
            from the first, with a large dot; and the text that stands for them in the key.
    """
    offers = [([name for name in names if name in seen.positions], text) for names, text in offered]
    view = _View(seen, {name for names, _ in offers for name in names})
    width = max(view.width, *(LETTER * len(text) + 2 * KEY for _, text in offers))
    top = view.height + KEY  # of the key
    height = top + KEY * (len(offers) + 0.5)
    drawn = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}" role="img">',
        f"<title>{escape(title)} {escape('; '.join(text for _, text in offers))}</title>",
        f"<style>{STYLE}</style>",
        '<rect class="page" width="100%" height="100%"/>',
        *view.objects(),
    ]
    for number, (names, text) in enumerate(offers):
        colour = COLOURS[number % len(COLOURS)]
        drawn += _way([view.place(name) for name in names], number, colour)
        at = top + KEY * number
        drawn += _badge((KEY, at), number, colour)
        drawn.append(f'<text x="{2 * KEY}" y="{at + 4:.0f}">{escape(text)}</text>')
    return "\n".join([*drawn, "</svg>"]) + "\n"


class _View:
    """A moment from above, in pixels: x goes up, y to the left."""

    def __init__(self, seen: Observation, named: Collection[str]) -> None:
        self._seen = seen
        there = [obj for obj in seen.objects if obj.name in seen.positions]
        small = [obj for obj in there if not obj.roomy]
        near = [obj for obj in small if obj.name in named] or small or there
        reach = max(max(obj.size[:2]) / 2 for obj in near)
        xs, ys, _ = zip(*(seen.positions[obj.name] for obj in near), strict=True)
        self._top, self._left = max(xs) + reach + MARGIN, max(ys) + reach + MARGIN
        self.height = SCALE * (self._top - min(xs) + reach + MARGIN)
        self.width = SCALE * (self._left - min(ys) + reach + MARGIN)

    def place(self, name: str) -> Point:
        x, y, _ = self._seen.positions[name]
        return SCALE * (self._left - y), SCALE * (self._top - x)

    def objects(self) -> Iterator[str]:
        """Yield the objects that are on the page, from the lowest up, each with its name."""
        positions = self._seen.positions
        there = [obj for obj in self._seen.objects if obj.name in positions]
        for obj in sorted(there, key=lambda each: positions[each.name][2]):
            x, y = self.place(obj.name)
            if obj.roomy or not (0 < x < self.width and 0 < y < self.height):
                continue
            yield self._outline(obj, x, y)
            below = y + SCALE * obj.size[0] / 2 + 11
            yield f'<text class="name" x="{x:.0f}" y="{below:.0f}">{escape(obj.name)}</text>'

    def _outline(self, obj: SceneObject, x: float, y: float) -> str:
        tall, wide = (SCALE * size for size in obj.size[:2])
        if obj.shape in ROUND:
            across, along = f"{wide / 2:.0f}", f"{tall / 2:.0f}"
            return f'<ellipse class="object" cx="{x:.0f}" cy="{y:.0f}" rx="{across}" ry="{along}"/>'
        turn = f' transform="rotate({-self._yaw(obj.name):.0f} {x:.0f} {y:.0f})"'
        return (
            f'<rect class="object" x="{x - wide / 2:.0f}" y="{y - tall / 2:.0f}" width="{wide:.0f}" '
            f'height="{tall:.0f}" rx="2"{turn}/>'
        )

    def _yaw(self, name: str) -> float:
        """Return how far an object is turned about the vertical, counter-clockwise from above [deg]."""
        x, y, z, w = self._seen.orientation(name)
        return degrees(atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def _way(points: Sequence[Point], number: int, colour: str) -> Iterator[str]:
    """Yield a line along points with its number on the first part, beside the lines of other offers."""
    aside = APART * (number - 1)
    moved = [(x + aside, y + aside) for x, y in points]
    if not moved:
        return
    text = " ".join(f"{x:.0f},{y:.0f}" for x, y in moved)
    yield f'<polyline class="way" stroke="{colour}" points="{text}"/>'
    (ax, ay), (bx, by) = moved[0], moved[1] if len(moved) > 1 else moved[0]
    share = 0.35 + 0.1 * (number % 4)
    yield from _badge((ax + share * (bx - ax), ay + share * (by - ay)), number, colour)
    for place, (x, y) in enumerate(moved):
        yield f'<circle cx="{x:.0f}" cy="{y:.0f}" r="{4 if place else 7}" fill="{colour}"/>'


def _badge(at: Point, number: int, colour: str) -> Iterator[str]:
    x, y = at
    yield f'<circle cx="{x:.0f}" cy="{y:.0f}" r="9" fill="{colour}"/>'
    yield f'<text class="number" x="{x:.0f}" y="{y + 4:.0f}">{number + 1}</text>'
