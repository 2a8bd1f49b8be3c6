"""From a graph to places on a page: callers above what they call, and few lines that cross.

The layered drawing of Sugiyama, Tagawa and Toda (1981): ranks by the longest path, dummy nodes for lines
that pass a rank, order by the mean of the neighbours, then columns likewise.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

SWEEPS = 12
GAP = 28.0  # between neighbours of a rank, in the page's units


@dataclass(frozen=True)
class Placed:
    """Where the middle of each node is, in which rank, and which places each line passes."""

    columns: Mapping[str, float]
    ranks: Mapping[str, int]
    routes: Mapping[tuple[str, str], tuple[str, ...]]  # keys of `columns` and `ranks`, both ends included


def place(widths: Mapping[str, float], edges: Sequence[tuple[str, str]], last: Sequence[str] = ()) -> Placed:
    """Lay out a graph; an edge that leads back up is routed like one that leads down.

    Args:
        widths: of the nodes, in reading order.
        last: those that are below all others.
    """
    downward = _downward(list(widths), edges)
    ranks = _ranks(list(widths), downward, set(last))
    routes = {edge: _route(edge, ranks) for edge in downward}
    for route in routes.values():
        ranks |= {stop: ranks[route[0]] + index for index, stop in enumerate(route)}
    rows: list[list[str]] = [[] for _ in range(max(ranks.values(), default=0) + 1)]
    for node, rank in ranks.items():
        rows[rank].append(node)
    neighbours = _neighbours(routes.values())
    for sweep in range(SWEEPS):
        _order(rows, neighbours, upward=sweep % 2 == 1)
    wide = {node: widths.get(node, 0.0) for node in ranks}
    return Placed(_columns(rows, wide, neighbours), ranks, routes)


def _downward(nodes: list[str], edges: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the edges, with those reversed that lead back to where a depth-first walk came from."""
    callees: dict[str, list[str]] = defaultdict(list)
    for caller, callee in edges:
        callees[caller].append(callee)
    found: list[tuple[str, str]] = []
    above: set[str] = set()
    done: set[str] = set()

    def walk(node: str) -> None:
        if node in done:
            return
        above.add(node)
        for callee in callees[node]:
            if callee in above:
                found.append((callee, node))
            else:
                found.append((node, callee))
                walk(callee)
        above.discard(node)
        done.add(node)

    for node in nodes:
        walk(node)
    return [*dict.fromkeys(found)]


def _ranks(nodes: list[str], edges: Sequence[tuple[str, str]], last: set[str]) -> dict[str, int]:
    ranks = dict.fromkeys(nodes, 0)
    for _ in nodes:
        for caller, callee in edges:
            ranks[callee] = max(ranks[callee], ranks[caller] + 1)
    upper = max((ranks[node] for node in nodes if node not in last), default=-1)
    return {node: upper + 1 if node in last else ranks[node] for node in nodes}


def _route(edge: tuple[str, str], ranks: Mapping[str, int]) -> tuple[str, ...]:
    caller, callee = edge
    between = range(ranks[caller] + 1, ranks[callee])
    return caller, *(f"{caller} > {callee} @ {rank}" for rank in between), callee


Neighbours = Mapping[str, Sequence[str]]


def _neighbours(routes: Iterable[Sequence[str]]) -> tuple[Neighbours, Neighbours]:
    """Return for each place those above, and those below."""
    above: dict[str, list[str]] = defaultdict(list)
    below: dict[str, list[str]] = defaultdict(list)
    for route in routes:
        for upper, lower in pairwise(route):
            above[lower].append(upper)
            below[upper].append(lower)
    return above, below


def _order(rows: list[list[str]], neighbours: tuple[Neighbours, Neighbours], upward: bool) -> None:
    for row in reversed(rows) if upward else rows:
        position = {node: index for other in rows for index, node in enumerate(other)}
        near = neighbours[upward]
        row.sort(key=lambda node: _mean([position[n] for n in near.get(node, ())], position[node]))


def _mean(values: Sequence[float], otherwise: float) -> float:
    return sum(values) / len(values) if values else otherwise


def _columns(
    rows: list[list[str]], widths: Mapping[str, float], neighbours: tuple[Neighbours, Neighbours]
) -> dict[str, float]:
    columns: dict[str, float] = {}
    for row in rows:
        _spread(row, dict.fromkeys(row, 0.0), widths, columns)
    for sweep in range(SWEEPS):
        for row in rows if sweep % 2 == 0 else reversed(rows):
            wanted = {
                node: _mean([columns[n] for side in neighbours for n in side.get(node, ())], columns[node])
                for node in row
            }
            _spread(row, wanted, widths, columns)
    left = min((columns[node] - widths[node] / 2 for row in rows for node in row), default=0.0)
    return {node: column - left for node, column in columns.items()}


def _spread(
    row: Sequence[str],
    wanted: Mapping[str, float],
    widths: Mapping[str, float],
    columns: dict[str, float],
) -> None:
    """Place the nodes of a row near to their wanted columns, in their order and without overlap."""
    apart = [(widths[a] + widths[b]) / 2 + GAP for a, b in pairwise(row)]
    right = [wanted[node] for node in row]
    left = list(right)
    for index, gap in enumerate(apart):
        right[index + 1] = max(right[index + 1], right[index] + gap)
    for index in range(len(apart) - 1, -1, -1):
        left[index] = min(left[index], left[index + 1] - apart[index])
    for node, low, high in zip(row, left, right, strict=True):
        columns[node] = (low + high) / 2
