"""From a graph of calls to one self-contained SVG, for light and dark themes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from itertools import pairwise
from textwrap import wrap

from ntp_dsl.graph.calls import CallGraph, Node
from ntp_dsl.graph.layers import Placed, place

LETTER, LINE, PAD, DROP, MARGIN = 6.7, 16, 10, 96, 28  # of a letter, a line, a box, between ranks
WIDEST, LABEL = 46, 34  # letters on a line of a box, and of an edge's label
BESIDE = 16  # how far right of the middle a recursive call goes back up
STYLE = """
text { font: 11px ui-monospace, "DejaVu Sans Mono", monospace; fill: #24292f; }
.page { fill: #ffffff; }
.box { stroke-width: 1.3; }
.task { fill: #fff4d6; stroke: #9a6700; }
.program { fill: #e3f0ff; stroke: #0a5cc2; }
.api { fill: #e6f6e8; stroke: #1a7f37; }
.title { font-weight: bold; font-size: 12px; }
.soft { fill: #57606a; }
.line { fill: none; stroke: #7d8590; stroke-width: 1.3; }
.back { stroke: #bf3989; stroke-dasharray: 5 3; }
.label { fill: #57606a; font-size: 10px; stroke: #ffffff; stroke-width: 6; paint-order: stroke; }
.head { fill: #7d8590; }
.head.back { fill: #bf3989; stroke: none; }
@media (prefers-color-scheme: dark) {
text { fill: #e6edf3; }
.page { fill: #0d1117; }
.task { fill: #3b2e07; stroke: #d4a72c; }
.program { fill: #0c2545; stroke: #58a6ff; }
.api { fill: #0b2a14; stroke: #3fb950; }
.soft { fill: #9da7b3; }
.line { stroke: #8b949e; }
.label { fill: #9da7b3; stroke: #0d1117; }
.head { fill: #8b949e; }
.back { stroke: #f778ba; }
.head.back { fill: #f778ba; }
}
"""


class _Page:
    """The layout: the boxes' lines, sizes and places."""

    def __init__(self, graph: CallGraph) -> None:
        self.graph = graph
        self.lines = {node.key: _lines(node) for node in graph.nodes}
        widths = {key: _width(lines) for key, lines in self.lines.items()}
        last = [node.key for node in graph.nodes if node.kind == "api"]
        edges = list(dict.fromkeys((a, b) for a, b, _ in graph.edges if a != b))
        self.placed: Placed = place(widths, edges, last)
        self.widths = widths
        heights = {key: len(lines) * LINE + PAD for key, lines in self.lines.items()}
        ranks = self.placed.ranks
        tallest = [
            max([heights[k] for k in heights if ranks[k] == rank] or [0])
            for rank in range(max(ranks.values(), default=0) + 1)
        ]
        self.tops = [MARGIN + sum(tallest[:rank]) + DROP * rank for rank in range(len(tallest))]
        self.bottoms = [top + height for top, height in zip(self.tops, tallest, strict=True)]
        self.heights = heights

    def x(self, key: str) -> float:
        return self.placed.columns[key] + MARGIN

    def top(self, key: str) -> float:
        return self.tops[self.placed.ranks[key]]

    def bottom(self, key: str) -> float:
        """Return the bottom of a box; a line that only passes leaves at the bottom of the rank."""
        return self.top(key) + self.heights[key] if key in self.heights else self.below(key)

    def below(self, key: str) -> float:
        return self.bottoms[self.placed.ranks[key]]

    @property
    def width(self) -> float:
        right = [self.x(key) + self.widths[key] / 2 for key in self.widths]
        for caller, callee, label in self.graph.edges:
            x, _, anchor = _label_place(self, caller, callee)
            letters = min(len(label), LABEL) * LETTER
            right.append(x + letters / (1 if anchor == "start" else 2))
        return max(right, default=0.0) + MARGIN

    @property
    def height(self) -> float:
        return max(self.bottoms, default=0.0) + MARGIN


def draw(graph: CallGraph) -> str:
    """Return the SVG: tasks above, then programs, then apis; recursion is dashed."""
    page = _Page(graph)
    size = f'{page.width:.0f}" height="{page.height:.0f}"'
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size} '
        f'viewBox="0 0 {page.width:.0f} {page.height:.0f}" role="img">'
    )
    title = f"<title>Who calls whom in {escape(graph.name)}</title>"
    paper = '<rect class="page" width="100%" height="100%"/>'
    drawn = [head, title, f"<style>{STYLE}</style>", paper, *_edges(page), *_boxes(page)]
    return "\n".join([*drawn, *_labels(page), "</svg>"]) + "\n"


def _lines(node: Node) -> list[tuple[str, str]]:
    """Return the lines of a box, each with its class."""
    kind = "task " if node.kind == "task" else ""
    found = [("title", line) for line in _folded(kind + node.signature)]
    for clause in node.contract:
        found += [("", line) for line in _folded(clause)]
    return found + [("soft", line) for line in wrap(node.summary, WIDEST)]


def _folded(text: str) -> list[str]:
    return wrap(text, WIDEST, subsequent_indent="    ", break_long_words=False) or [text]


def _width(lines: Sequence[tuple[str, str]]) -> float:
    return max(len(line) * LETTER * (1.1 if kind == "title" else 1) for kind, line in lines) + 2 * PAD


def _boxes(page: _Page) -> Iterator[str]:
    for node in page.graph.nodes:
        width, x = page.widths[node.key], page.x(node.key) - page.widths[node.key] / 2
        y, height = page.top(node.key), page.heights[node.key]
        yield (
            f'<rect class="box {node.kind}" x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" '
            f'height="{height:.1f}" rx="6"><title>{escape(node.docstring)}</title></rect>'
        )
        for number, (kind, line) in enumerate(page.lines[node.key], start=1):
            indent = (len(line) - len(line.lstrip())) * LETTER
            place = f'x="{x + PAD + indent:.1f}" y="{y + number * LINE:.1f}"'
            yield f'<text class="{kind}" {place}>{escape(line.strip())}</text>'


def _edges(page: _Page) -> Iterator[str]:
    for caller, callee, _ in page.graph.edges:
        if caller == callee:
            yield from _loop(page, caller)
        elif (caller, callee) in page.placed.routes:
            yield f'<path class="line" d="{_path(page, page.placed.routes[caller, callee], 0)}"/>'
            yield _arrow(page.x(callee), page.top(callee), "head")
        else:
            path = _path(page, page.placed.routes[callee, caller], BESIDE)
            yield f'<path class="line back" d="{path}"/>'
            yield _arrow(page.x(callee) + BESIDE, page.bottom(callee), "head back", up=True)


def _path(page: _Page, route: Sequence[str], aside: float) -> str:
    path = f"M{page.x(route[0]) + aside:.1f} {page.bottom(route[0]):.1f}"
    for upper, lower in pairwise(route):
        left, right = page.x(upper) + aside, page.x(lower) + aside
        start, end = page.below(upper), page.top(lower)
        bend = (end - start) / 2
        path += f" L{left:.1f} {start:.1f} C{left:.1f} {start + bend:.1f}"
        path += f" {right:.1f} {end - bend:.1f} {right:.1f} {end:.1f}"
    return path


def _loop(page: _Page, key: str) -> Iterator[str]:
    """Draw a call of itself, at the right side of the box."""
    x, y = page.x(key) + page.widths[key] / 2, page.top(key) + page.heights[key] / 2
    path = f"M{x:.1f} {y + 10:.1f} C{x + 30:.1f} {y + 10:.1f} {x + 30:.1f} {y - 10:.1f} {x:.1f} {y - 10:.1f}"
    yield f'<path class="line back" d="{path}"/>'
    points = f"{x:.1f},{y - 10:.1f} {x + 8:.1f},{y - 14:.1f} {x + 8:.1f},{y - 6:.1f}"
    yield f'<polygon class="head back" points="{points}"/>'


def _arrow(x: float, y: float, kind: str, up: bool = False) -> str:
    base = y + 8 if up else y - 8
    points = f"{x:.1f},{y:.1f} {x - 4:.1f},{base:.1f} {x + 4:.1f},{base:.1f}"
    return f'<polygon class="{kind}" points="{points}"/>'


def _labels(page: _Page) -> Iterator[str]:
    """Write loops and conditions where the line leaves its caller."""
    for caller, callee, label in page.graph.edges:
        x, y, anchor = _label_place(page, caller, callee)
        for number, line in enumerate(wrap(label, LABEL)):
            place = f'x="{x:.1f}" y="{y + 12 * number:.1f}" text-anchor="{anchor}"'
            yield f'<text class="label" {place}>{escape(line)}</text>'


def _label_place(page: _Page, caller: str, callee: str) -> tuple[float, float, str]:
    if caller == callee:
        right = page.x(caller) + page.widths[caller] / 2
        return right + 26, page.top(caller) + page.heights[caller] / 2 + 4, "start"
    if route := page.placed.routes.get((caller, callee)):
        middle = (page.x(route[0]) + page.x(route[1])) / 2
        return middle, (page.below(route[0]) + page.top(route[1])) / 2, "middle"
    upper, lower = page.placed.routes[callee, caller][-2:]
    return page.x(lower) + BESIDE + 8, page.top(lower) - 22, "start"
