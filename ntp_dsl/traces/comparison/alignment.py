"""Aligns two traces as ordered trees: which call of one is which of the other.

A call can only be matched below matched callers, as in Selkow's edit distance (1977): a call tree says who
asked for what, and a call made by another is another call. Up to the first divergence the two traces are
matched step by step, since nothing tells them apart. After it children are matched so that few calls are left
over; equal subtrees are found by their numbers, so what is alike costs nothing.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass

from ntp_dsl.traces.comparison.comparison_rules import Rules
from ntp_dsl.traces.comparison.longest_common_subsequence import common
from ntp_dsl.traces.schema import ROOT, Trace

CELLS = 400_000  # of dynamic programming in one alignment; then pairs are estimated
GAP = 20_000  # cells of one gap between equal siblings; in a larger one only like calls are matched
DEEP = 60  # levels below a pair that are looked at to judge it

Pair = tuple[int | None, int | None]  # numbers of calls: matched, or one of them left over


@dataclass(frozen=True)
class Level:
    """What two callers that stand for each other have called, side by side; `ROOT` is the run itself."""

    caller_a: int
    caller_b: int
    depth: int
    pairs: Sequence[Pair]


def align(a: Trace, b: Trace, rules: Rules) -> list[Level]:
    """A level for each matched pair of callers, the callers' own levels first."""
    return list(_Aligner(a, b, rules).levels())


class _Aligner:
    """What is compared of both traces, as numbers."""

    def __init__(self, a: Trace, b: Trace, rules: Rules) -> None:
        self.a, self.b, self.rules = a, b, rules
        numbers: dict[Hashable, int] = {}
        self.labels_a = [numbers.setdefault(rules.label(call), len(numbers)) for call in a.calls]
        self.labels_b = [numbers.setdefault(rules.label(call), len(numbers)) for call in b.calls]
        trees: dict[Hashable, int] = {}
        self.trees_a, self.sizes_a = self._trees(a, self.labels_a, trees)
        self.trees_b, self.sizes_b = self._trees(b, self.labels_b, trees)
        self.kids_a = [[c.id for c in a.children(n)] for n in (*range(len(a.calls)), ROOT)]
        self.kids_b = [[c.id for c in b.children(n)] for n in (*range(len(b.calls)), ROOT)]
        self.costs: dict[tuple[int, int], int] = {}
        self.cells = CELLS

    def _trees(
        self, trace: Trace, labels: list[int], numbers: dict[Hashable, int]
    ) -> tuple[list[int], list[int]]:
        """The number of each subtree, equal ones alike, and its size. A call comes before what it calls."""
        below: list[list[int]] = [[] for _ in trace.calls]
        trees, sizes = [0] * len(trace.calls), [1] * len(trace.calls)
        for call in reversed(trace.calls):
            key = (labels[call.id], self.rules.outcome(call), tuple(reversed(below[call.id])))
            trees[call.id] = numbers.setdefault(key, len(numbers))
            if call.parent != ROOT:
                below[call.parent].append(trees[call.id])
                sizes[call.parent] += sizes[call.id]
        return trees, sizes

    def levels(self) -> Iterator[Level]:
        """Depth first, with a stack of one's own: traces may be deeper than Python's."""
        waiting = [(ROOT, ROOT, 0, True)]
        while waiting:
            x, y, depth, first = waiting.pop()
            xs, ys = self.kids_a[x], self.kids_b[y]
            together = self._together(xs, ys) if first else 0
            pairs: list[Pair] = list(zip(xs[:together], ys[:together], strict=False))
            pairs += self._siblings(xs[together:], ys[together:])
            yield Level(x, y, depth, pairs)
            for place in range(len(pairs) - 1, -1, -1):
                a, b = pairs[place]
                if a is not None and b is not None:
                    waiting.append((a, b, depth + 1, place < together))

    # One list of siblings against another ----------------------------------------------------------

    def _together(self, xs: list[int], ys: list[int]) -> int:
        """How many calls were made alike, up to and with the first that did not go alike."""
        count = 0
        for x, y in zip(xs, ys, strict=False):
            if not self._same_label(x, y):
                break
            count += 1
            if not self._same_tree(x, y):
                break
        return count

    def _siblings(self, xs: list[int], ys: list[int]) -> Iterator[Pair]:
        """Equal beginnings and ends first, then what is equal between them, then the gaps."""
        begin = 0
        while begin < min(len(xs), len(ys)) and self._same_tree(xs[begin], ys[begin]):
            begin += 1
        yield from zip(xs[:begin], ys[:begin], strict=True)
        xs, ys = xs[begin:], ys[begin:]
        end = 0
        while end < min(len(xs), len(ys)) and self._same_tree(xs[-1 - end], ys[-1 - end]):
            end += 1
        cut_x, cut_y = len(xs) - end, len(ys) - end
        yield from self._middle(xs[:cut_x], ys[:cut_y])
        yield from zip(xs[cut_x:], ys[cut_y:], strict=True)

    def _middle(self, xs: list[int], ys: list[int]) -> Iterator[Pair]:
        if len(xs) * len(ys) <= GAP:
            yield from self._gap(xs, ys)
            return
        x = y = 0
        for i, j in common([self.trees_a[k] for k in xs], [self.trees_b[k] for k in ys]):
            yield from self._gap(xs[x:i], ys[y:j])
            yield xs[i], ys[j]
            x, y = i + 1, j + 1
        yield from self._gap(xs[x:], ys[y:])

    def _gap(self, xs: list[int], ys: list[int]) -> Iterator[Pair]:
        if not xs or not ys:
            yield from ((x, None) for x in xs)
            yield from ((None, y) for y in ys)
        elif len(xs) * len(ys) > GAP:
            yield from self._greedy(xs, ys)
        else:
            yield from self._cheapest(xs, ys)

    def _cheapest(self, xs: list[int], ys: list[int]) -> list[Pair]:
        """By dynamic programming. Of equal ways the one that matches earlier."""
        table = self._table(xs, ys, 0)
        pairs: list[Pair] = []
        i, j = 0, 0
        while i < len(xs) and j < len(ys):
            if table[i][j] == table[i + 1][j + 1] + self._cost(xs[i], ys[j], 0):
                pairs.append((xs[i], ys[j]))
                i, j = i + 1, j + 1
            elif table[i][j] == table[i + 1][j] + self.sizes_a[xs[i]]:
                pairs.append((xs[i], None))
                i += 1
            else:
                pairs.append((None, ys[j]))
                j += 1
        return [*pairs, *((x, None) for x in xs[i:]), *((None, y) for y in ys[j:])]

    def _table(self, xs: list[int], ys: list[int], depth: int) -> list[list[int]]:
        """table[i][j]: how many calls are left over or changed in xs[i:] against ys[j:], at the least."""
        last = [0] * (len(ys) + 1)
        for j in range(len(ys) - 1, -1, -1):
            last[j] = last[j + 1] + self.sizes_b[ys[j]]
        table = [last]
        for x in reversed(xs):
            below, row = table[-1], [0] * (len(ys) + 1)
            row[-1] = below[-1] + self.sizes_a[x]
            for j in range(len(ys) - 1, -1, -1):
                left_over = min(below[j] + self.sizes_a[x], row[j + 1] + self.sizes_b[ys[j]])
                row[j] = min(left_over, below[j + 1] + self._cost(x, ys[j], depth))
            table.append(row)
        self.cells -= len(xs) * len(ys)
        return table[::-1]

    def _cost(self, x: int, y: int, depth: int) -> int:
        """Of matching two calls: one where they differ, and what their children differ in."""
        if self._same_tree(x, y):
            return 0
        if not self._same_callee(x, y):
            return self.sizes_a[x] + self.sizes_b[y] + 1  # more than to leave both over
        if (x, y) not in self.costs:
            self.costs[x, y] = self._distance(x, y, depth)
        return self.costs[x, y]

    def _distance(self, x: int, y: int, depth: int) -> int:
        changed = int(not (self._same_label(x, y) and self._same_outcome(x, y)))
        xs, ys = self._trimmed(self.kids_a[x], self.kids_b[y])
        if not xs or not ys or depth > DEEP or self.cells < 0 or len(xs) * len(ys) > GAP:
            left = sum(self.sizes_a[k] for k in xs), sum(self.sizes_b[k] for k in ys)
            return changed + (sum(left) if not xs or not ys else max(left))
        return changed + self._table(xs, ys, depth + 1)[0][0]

    def _trimmed(self, xs: list[int], ys: list[int]) -> tuple[list[int], list[int]]:
        begin, end, shorter = 0, 0, min(len(xs), len(ys))
        while begin < shorter and self._same_tree(xs[begin], ys[begin]):
            begin += 1
        while end < shorter - begin and self._same_tree(xs[-1 - end], ys[-1 - end]):
            end += 1
        return xs[begin : len(xs) - end], ys[begin : len(ys) - end]

    def _greedy(self, xs: list[int], ys: list[int]) -> Iterator[Pair]:
        """Where a gap is too large for more: calls of one label, in their order."""
        anchors = common([self.labels_a[k] for k in xs], [self.labels_b[k] for k in ys])
        x = y = 0
        for i, j in [*anchors, (len(xs), len(ys))]:
            yield from ((each, None) for each in xs[x:i])
            yield from ((None, each) for each in ys[y:j])
            if i < len(xs):
                yield xs[i], ys[j]
            x, y = i + 1, j + 1

    # What two calls have in common -----------------------------------------------------------------

    def _same_tree(self, x: int, y: int) -> bool:
        return self.trees_a[x] == self.trees_b[y]

    def _same_label(self, x: int, y: int) -> bool:
        return self.labels_a[x] == self.labels_b[y]

    def _same_callee(self, x: int, y: int) -> bool:
        return self.a.calls[x].name == self.b.calls[y].name

    def _same_outcome(self, x: int, y: int) -> bool:
        return self.rules.outcome(self.a.calls[x]) == self.rules.outcome(self.b.calls[y])
