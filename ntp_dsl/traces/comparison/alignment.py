"""Aligns two traces as ordered trees: matches the calls of one with those of the other.

Calls can only be matched below matched callers, as in Selkow's edit distance (1977): the same callee under
different callers is a different call. Up to the first divergence the traces are matched step by step, since
they are equal. After it children are matched so that few calls are left unmatched; equal subtrees are found
by their numbers, at no cost.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass

from ntp_dsl.traces.comparison.comparison_rules import Rules
from ntp_dsl.traces.comparison.longest_common_subsequence import common_subsequence
from ntp_dsl.traces.schema import ROOT
from ntp_dsl.traces.trace import Trace

MAX_CELLS = 400_000  # of dynamic programming in one alignment; beyond it, costs are estimated
MAX_GAP_CELLS = 20_000  # of one gap; in larger ones only calls of one label are matched
MAX_DEPTH = 60  # levels below a pair that its cost takes into account

Pair = tuple[int | None, int | None]  # numbers of calls: a match, or an unmatched call


@dataclass(frozen=True)
class Level:
    """The aligned children of two matched callers; `ROOT` is the run itself."""

    caller_a: int
    caller_b: int
    depth: int
    pairs: Sequence[Pair]


def align(a: Trace, b: Trace, rules: Rules) -> list[Level]:
    """Return a level for each matched pair of callers, outer levels first."""
    return list(_Aligner(a, b, rules).levels())


class _Aligner:
    """Both traces with labels and subtrees as numbers, so that comparing them is cheap."""

    def __init__(self, a: Trace, b: Trace, rules: Rules) -> None:
        self.a, self.b, self.rules = a, b, rules
        numbers: dict[Hashable, int] = {}
        self.labels_a = [numbers.setdefault(rules.label(call), len(numbers)) for call in a.calls]
        self.labels_b = [numbers.setdefault(rules.label(call), len(numbers)) for call in b.calls]
        trees: dict[Hashable, int] = {}
        self.trees_a, self.sizes_a = self._trees(a, self.labels_a, trees)
        self.trees_b, self.sizes_b = self._trees(b, self.labels_b, trees)
        self.children_a = [[c.id for c in a.children(n)] for n in (*range(len(a.calls)), ROOT)]
        self.children_b = [[c.id for c in b.children(n)] for n in (*range(len(b.calls)), ROOT)]
        self.costs: dict[tuple[int, int], int] = {}
        self.cells = MAX_CELLS

    def _trees(
        self, trace: Trace, labels: list[int], numbers: dict[Hashable, int]
    ) -> tuple[list[int], list[int]]:
        """Return each subtree's number, the same for equal ones, and its size."""
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
        """Yield the levels depth first, without recursion: traces may be deeper than Python's stack."""
        waiting = [(ROOT, ROOT, 0, True)]
        while waiting:
            x, y, depth, first = waiting.pop()
            xs, ys = self.children_a[x], self.children_b[y]
            equal = self._equal_calls(xs, ys) if first else 0
            pairs: list[Pair] = list(zip(xs[:equal], ys[:equal], strict=False))
            pairs += self._siblings(xs[equal:], ys[equal:])
            yield Level(x, y, depth, pairs)
            for place in range(len(pairs) - 1, -1, -1):
                a, b = pairs[place]
                if a is not None and b is not None:
                    waiting.append((a, b, depth + 1, place < equal))

    # Matching two lists of siblings ----------------------------------------------------------

    def _equal_calls(self, xs: list[int], ys: list[int]) -> int:
        """Return how many calls have equal labels, up to and including the first with different subtrees."""
        count = 0
        for x, y in zip(xs, ys, strict=False):
            if not self._same_label(x, y):
                break
            count += 1
            if not self._same_tree(x, y):
                break
        return count

    def _siblings(self, xs: list[int], ys: list[int]) -> Iterator[Pair]:
        """Match equal prefixes and suffixes first, then equal subtrees between them, then the gaps."""
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
        if len(xs) * len(ys) <= MAX_GAP_CELLS:
            yield from self._gap(xs, ys)
            return
        x = y = 0
        for i, j in common_subsequence([self.trees_a[k] for k in xs], [self.trees_b[k] for k in ys]):
            yield from self._gap(xs[x:i], ys[y:j])
            yield xs[i], ys[j]
            x, y = i + 1, j + 1
        yield from self._gap(xs[x:], ys[y:])

    def _gap(self, xs: list[int], ys: list[int]) -> Iterator[Pair]:
        if not xs or not ys:
            yield from ((x, None) for x in xs)
            yield from ((None, y) for y in ys)
        elif len(xs) * len(ys) > MAX_GAP_CELLS:
            yield from self._greedy(xs, ys)
        else:
            yield from self._cheapest(xs, ys)

    def _cheapest(self, xs: list[int], ys: list[int]) -> list[Pair]:
        """Return the cheapest matching by dynamic programming; of equal ones, the earlier."""
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
        """Return table[i][j], the smallest number of unmatched or changed calls in xs[i:] against ys[j:]."""
        last = [0] * (len(ys) + 1)
        for j in range(len(ys) - 1, -1, -1):
            last[j] = last[j + 1] + self.sizes_b[ys[j]]
        table = [last]
        for x in reversed(xs):
            below, row = table[-1], [0] * (len(ys) + 1)
            row[-1] = below[-1] + self.sizes_a[x]
            for j in range(len(ys) - 1, -1, -1):
                unmatched = min(below[j] + self.sizes_a[x], row[j + 1] + self.sizes_b[ys[j]])
                row[j] = min(unmatched, below[j + 1] + self._cost(x, ys[j], depth))
            table.append(row)
        self.cells -= len(xs) * len(ys)
        return table[::-1]

    def _cost(self, x: int, y: int, depth: int) -> int:
        """Return the cost of matching two calls: one where they differ, and the cost of their children."""
        if self._same_tree(x, y):
            return 0
        if not self._same_callee(x, y):
            return self.sizes_a[x] + self.sizes_b[y] + 1  # more than leaving both unmatched
        if (x, y) not in self.costs:
            self.costs[x, y] = self._distance(x, y, depth)
        return self.costs[x, y]

    def _distance(self, x: int, y: int, depth: int) -> int:
        changed = int(not (self._same_label(x, y) and self._same_outcome(x, y)))
        xs, ys = self._trimmed(self.children_a[x], self.children_b[y])
        if not xs or not ys or depth > MAX_DEPTH or self.cells < 0 or len(xs) * len(ys) > MAX_GAP_CELLS:
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
        """Match calls of one label in their order, where a gap is too large for dynamic programming."""
        anchors = common_subsequence([self.labels_a[k] for k in xs], [self.labels_b[k] for k in ys])
        x = y = 0
        for i, j in [*anchors, (len(xs), len(ys))]:
            yield from ((each, None) for each in xs[x:i])
            yield from ((None, each) for each in ys[y:j])
            if i < len(xs):
                yield xs[i], ys[j]
            x, y = i + 1, j + 1

    # Equality of two calls -----------------------------------------------------------------

    def _same_tree(self, x: int, y: int) -> bool:
        return self.trees_a[x] == self.trees_b[y]

    def _same_label(self, x: int, y: int) -> bool:
        return self.labels_a[x] == self.labels_b[y]

    def _same_callee(self, x: int, y: int) -> bool:
        return self.a.calls[x].name == self.b.calls[y].name

    def _same_outcome(self, x: int, y: int) -> bool:
        return self.rules.outcome(self.a.calls[x]) == self.rules.outcome(self.b.calls[y])
