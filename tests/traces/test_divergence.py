"""The first divergence of two traces is found; an independent tree edit distance is the judge."""

from __future__ import annotations

from collections import Counter
from time import process_time

import numpy as np
import pytest
import zss
from planting import KINDS, planted
from trees import HERE, Node, events, prefix, recorded, tree, written

from ntp_dsl.language.registry import Registry
from ntp_dsl.traces.comparison.alignment import align
from ntp_dsl.traces.comparison.comparison import Comparison
from ntp_dsl.traces.comparison.comparison_rules import DivergenceKind, Rules, overlap
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.reader import parse_trace
from ntp_dsl.traces.schema import MAX_DEPTH
from ntp_dsl.traces.trace import Trace

PARTS = 10  # of the planted pairs, so that they can run side by side
PAIRS = 1000
SMALL = 90  # calls: the distance of the judge takes cubic time
FEW = 6  # trees that it is asked about where they are compared whole


@pytest.fixture(scope="module")
def grown(stacking: Registry) -> list[Node]:
    """Return trees of real episodes, small enough for the judge."""
    trees = [tree(parse_trace(recorded(stacking, seed), HERE)) for seed in range(24)]
    return [run for run in trees if 10 < len(list(run.walk())) <= SMALL]


def judged(a: Node, b: Node) -> int:
    """Return how many calls must be changed, removed or added to turn one tree into the other."""
    return int(zss.simple_distance(a, b, lambda n: n.kids, _label, lambda x, y: int(x != y)))


def _label(node: Node) -> tuple[object, ...]:
    return (*node.decision, node.scope, node.outcome)


def cost(comparison: Comparison) -> int:
    """Return the number of calls that the alignment leaves unmatched or changed."""
    a, b = comparison.a, comparison.b
    matched = [(x, y) for level in comparison.levels for x, y in level.pairs if None not in (x, y)]
    rules = Rules.between(a, b)
    changed = 0
    for x, y in matched:
        assert x is not None and y is not None
        one, other = a.calls[x], b.calls[y]
        same = rules.label(one) == rules.label(other) and one.scope == other.scope
        changed += not (same and one.outcome == other.outcome)
    return changed + len(a.calls) + len(b.calls) - 2 * len(matched)


@pytest.mark.parametrize("part", range(PARTS))
def test_the_first_of_planted_differences_is_found_with_its_kind(
    grown: list[Node], part: int, soak: bool
) -> None:
    kinds: Counter[str] = Counter()
    for number in range(part, PAIRS if soak else PAIRS // 50, PARTS):
        rng = np.random.default_rng((number, 7))
        run = grown[int(rng.integers(len(grown)))]
        others = rng.choice(KINDS, int(rng.integers(5)))  # of one to five edits
        other, plant = planted(run, [KINDS[number // PARTS % len(KINDS)], *others], rng)
        assert plant is not None
        comparison = compare(written(run), written(other))
        first = comparison.first
        assert first is not None
        assert (first.kind, first.a) == (plant.kind, plant.call), number
        _agrees(run, other, comparison, plant.moment)
        kinds[plant.kind] += 1
    assert not soak or set(kinds) == {*DivergenceKind} - {DivergenceKind.CUT_OFF}


def _agrees(run: Node, other: Node, comparison: Comparison, moment: tuple[float, float]) -> None:
    """Assert that the judge finds the first difference at the moment, and no more than the alignment."""
    numbers = {id(node): number for number, node in enumerate(list(run.walk())[1:])}
    last = {id(node): numbers[id(list(node.walk())[-1])] for node, _ in events(run)}
    at = next(
        place
        for place, (node, returns) in enumerate(events(run))
        if moment == ((last[id(node)] + 0.5, -numbers[id(node)]) if returns else (numbers[id(node)], 0))
    )
    assert judged(prefix(run, at), prefix(other, at)) == 0
    assert judged(prefix(run, at + 1), prefix(other, at + 1)) > 0
    assert 0 < judged(run, other) <= cost(comparison)


def test_a_trace_does_not_differ_from_itself(grown: list[Node]) -> None:
    for run in grown[:FEW]:
        comparison = compare(written(run), written(run))
        assert comparison.first is None and cost(comparison) == judged(run, run) == 0


def test_no_alignment_is_cheaper_than_the_edit_distance(grown: list[Node]) -> None:
    """The edit distance is a lower bound: it may match calls below unmatched callers."""
    for a, b in zip(grown[:FEW], grown[1:], strict=False):
        comparison = compare(written(a), written(b))
        everything = len(list(a.walk())) + len(list(b.walk()))
        assert judged(a, b) <= cost(comparison) < everything


def test_every_call_is_in_an_alignment_once_and_in_order(grown: list[Node]) -> None:
    for a, b in zip(grown, grown[1:], strict=False):
        comparison = compare(written(a), written(b))
        for side, trace in ((0, comparison.a), (1, comparison.b)):
            found = [pair[side] for level in comparison.levels for pair in level.pairs]
            present = [number for number in found if number is not None]
            assert len(present) == len(set(present)) and set(present) <= set(range(len(trace.calls)))
            for level in comparison.levels:
                inside = [pair[side] for pair in level.pairs if pair[side] is not None]
                caller = (level.caller_a, level.caller_b)[side]
                assert inside == [call.id for call in trace.children(caller)]


# Large ones ----------------------------------------------------------------------------------------


def large(rng: np.random.Generator, calls: int, flat: bool) -> Node:
    """Return a tree like that of an episode of many placements: at most five levels, much of it equal."""
    run = Node("run", "run", kids=[Node("program", "build")])
    nodes = [run.kids[0]]
    while len(nodes) < calls:
        above = nodes[0] if flat or rng.random() < 0.3 else nodes[int(rng.integers(len(nodes)))]
        if above.kind == "program":
            kind = "api" if rng.random() < 0.5 else "program"
            obj = f"block_{int(rng.integers(8))}"
            node = Node(kind, f"{kind}_{int(rng.integers(4))}", (obj,))
            above.kids.append(node)
            nodes.append(node)
    return run


def mutated(run: Node, rng: np.random.Generator, share: float) -> Node:
    other = run.copy()
    for node in list(other.walk()):
        if node is not other:
            node.kids = [kid for kid in node.kids if rng.random() > share]
        if node.arguments and rng.random() < share:
            node.arguments = ("object",)
    return other


@pytest.mark.parametrize("flat", [False, True])
@pytest.mark.parametrize("share", [0.0002, 0.02, 0.5])
def test_ten_thousand_calls_are_aligned_in_two_seconds(flat: bool, share: float) -> None:
    rng = np.random.default_rng(3)
    run = large(rng, 10_000, flat)
    a, b = written(run), written(mutated(run, rng, share))
    start = process_time()
    levels = align(a, b, Rules.between(a, b))
    assert process_time() - start < 2
    assert sum(len(level.pairs) for level in levels) > 0


def test_two_unrelated_trees_of_ten_thousand_calls_are_aligned_in_two_seconds() -> None:
    a, b = (written(large(np.random.default_rng(seed), 10_000, bool(seed % 2))) for seed in (1, 3))
    start = process_time()
    align(a, b, Rules.between(a, b))
    assert process_time() - start < 2


def test_a_trace_as_deep_as_it_is_long_is_compared() -> None:
    def chain(length: int, end: str) -> Trace:
        run = node = Node("run", "run")
        for number in range(length):
            node.kids = [Node("program", f"p{number % 3}" if number < length - 1 else end)]
            node = node.kids[0]
        return written(run)

    first = compare(chain(MAX_DEPTH - 1, "x"), chain(MAX_DEPTH - 1, "y")).first
    assert first is not None and (first.kind, first.a) == (DivergenceKind.PROGRAM, MAX_DEPTH - 2)


# The rules -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "a, b, shared",
    [
        ((0, 10), (0, 10), 1.0),
        (None, None, 1.0),
        (None, (0, 10), 0.0),
        ((0, 10), (5, 15), 1 / 3),
        ((0, 10), (20, 30), 0.0),
        ((5, 5), (5, 5), 1.0),
    ],
)
def test_scopes_overlap_by_their_frames(
    a: tuple[int, int] | None, b: tuple[int, int] | None, shared: float
) -> None:
    assert overlap(a, b) == pytest.approx(shared) == overlap(b, a)


def test_lists_and_unfinished_returns_do_not_count_for_a_learned_program() -> None:
    """Learned programs are not given lists, and primitives read no demonstration."""
    goal = ()
    call = Node("program", "build", (goal,), (0, 50), "unfinished", [Node("api", "go", ("a",), (0, 9))])
    other = Node("program", "build", (), (0, 48), "done", [Node("api", "go", ("a",), (30, 39))])
    runs = [Node("run", "run", kids=[node]) for node in (call, other)]
    assert compare(written(runs[0]), written(runs[1], "learned")).first is None
    assert compare(written(runs[0]), written(runs[1])).first is not None
