"""Plants differences in a call tree, and records the moment and the kind of the first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from trees import Node

from ntp_dsl.traces.comparison.comparison_rules import DivergenceKind

Moment = tuple[float, float]


@dataclass(frozen=True)
class Plant:
    """A difference: its moment among the calls and returns of the first tree, and its kind."""

    moment: Moment
    kind: DivergenceKind
    call: int | None  # the first tree's call at that moment, by its number; None for a return


class Gardener:
    """Edits a copy of a tree. No two edits touch the same call, so none hides another."""

    def __init__(self, run: Node, rng: np.random.Generator) -> None:
        self.run, self.rng = run.copy(), rng
        self.nodes = list(self.run.walk())[1:]
        self.number = {id(node): number for number, node in enumerate(self.nodes)}
        self.above = {id(kid): node for node in self.run.walk() for kid in node.kids}
        self.last = {id(node): self.number[id(list(node.walk())[-1])] for node in self.nodes}
        self.siblings = {id(node): list(node.kids) for node in self.run.walk()}
        self.touched: set[int] = set()
        self.fresh = 0

    def plant(self, kind: str) -> Plant | None:
        """Plant a difference at a random place; return None where the tree has no place for it."""
        edit: Callable[[Node], Plant | None] = getattr(self, f"_{kind}")
        for index in self.rng.permutation(len(self.nodes)):
            if (found := edit(self.nodes[int(index)])) is not None:
                return found
        return None

    def _claim(self, *nodes: Node) -> bool:
        """Whether none of these has been edited; marks them as edited."""
        numbers = {id(node) for node in nodes}
        if numbers & self.touched:
            return False
        self.touched |= numbers
        return True

    def _at_call(self, node: Node, kind: DivergenceKind) -> Plant:
        number = self.number[id(node)]
        return Plant((number, 0), kind, number)

    def _at_return(self, node: Node, kind: DivergenceKind, call: int | None) -> Plant:
        return Plant((self.last[id(node)] + 0.5, -self.number[id(node)]), kind, call)

    def _program(self, node: Node) -> Plant | None:
        if not self._claim(node):
            return None
        node.name = self._new("other")
        return self._at_call(node, DivergenceKind.PROGRAM)

    def _argument(self, node: Node) -> Plant | None:
        if not any(isinstance(a, str) for a in node.arguments) or not self._claim(node):
            return None
        place = next(i for i, a in enumerate(node.arguments) if isinstance(a, str))
        others = (*node.arguments[:place], self._new("object"), *node.arguments[place + 1 :])
        node.arguments = others
        return self._at_call(node, DivergenceKind.ARGUMENT)

    def _scope(self, node: Node) -> Plant | None:
        if node.kind != "program" or not self._claim(node):
            return None
        node.scope = (900, 950) if node.scope is None or self.rng.random() < 0.5 else None
        return self._at_call(node, DivergenceKind.SCOPE)

    def _outcome(self, node: Node) -> Plant | None:
        if not self._claim(node):
            return None
        ways = ("done", "unfinished") if node.kind == "program" else ("achieved", "grasp failed")
        node.outcome = ways[1] if node.outcome == ways[0] else ways[0]
        return self._at_return(node, DivergenceKind.OUTCOME, self.number[id(node)])

    def _too_early(self, node: Node) -> Plant | None:
        """Remove a call and all after it from a program."""
        siblings = self.siblings[id(node)]
        if not siblings or node.kids != siblings:
            return None
        cut = int(self.rng.integers(len(siblings)))
        if not self._claim(node, *siblings[cut:]):
            return None
        del node.kids[cut:]
        return self._at_call(siblings[cut], DivergenceKind.TOO_EARLY)

    def _too_late(self, node: Node) -> Plant | None:
        if node.kind != "program" or not self._claim(node):
            return None
        node.kids.append(Node("program", self._new("more")))
        return self._at_return(node, DivergenceKind.TOO_LATE, None)

    def _inserted(self, node: Node) -> Plant | None:
        """Insert a call before another."""
        if not self._claim(node):
            return None
        caller = self.above[id(node)]
        if node not in caller.kids:
            return None
        caller.kids.insert(caller.kids.index(node), Node("program", self._new("more")))
        return self._at_call(node, DivergenceKind.PROGRAM)

    def _left_out(self, node: Node) -> Plant | None:
        """Remove a call."""
        caller = self.above[id(node)]
        siblings = self.siblings[id(caller)]
        after = siblings[siblings.index(node) + 1 :][:1]
        if not after or after[0].decision == node.decision or node not in caller.kids:
            return None
        if not self._claim(node, after[0]):
            return None
        caller.kids.remove(node)
        kind = DivergenceKind.PROGRAM if after[0].name != node.name else DivergenceKind.ARGUMENT
        return self._at_call(node, kind)

    def _new(self, word: str) -> str:
        self.fresh += 1
        return f"{word}_{self.fresh}"


KINDS = ("program", "argument", "scope", "outcome", "too_early", "too_late", "inserted", "left_out")


def planted(run: Node, kinds: list[str], rng: np.random.Generator) -> tuple[Node, Plant | None]:
    """Return the tree with these differences and the first of them; None where none could be planted."""
    gardener = Gardener(run, rng)
    plants = [plant for kind in kinds if (plant := gardener.plant(kind)) is not None]
    return gardener.run, min(plants, key=lambda plant: plant.moment, default=None)
