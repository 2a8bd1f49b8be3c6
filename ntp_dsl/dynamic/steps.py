"""The steps of a run, each with the state that it was decided in, and which of them undo one another."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ntp_dsl.dynamic.stuck import given
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import NextCall
from ntp_dsl.policies.protocol import Frame
from ntp_dsl.semantics.facts import Fact
from ntp_dsl.semantics.observation import Observation
from ntp_dsl.semantics.state import State


@dataclass(frozen=True)
class Step:
    """A call that a program makes.

    Args:
        run: which run of the program it is, by number: of two runs of the same call, each has its own.
        seen: the true state that it was decided in.
    """

    run: int
    frame: Frame
    call: NextCall
    seen: Observation


@dataclass(frozen=True)
class Undoing:
    """A fact that one call of a program brings about and a later one ends, so that the first is due again."""

    fact: Fact
    achieved_by: NextCall
    ended_by: NextCall

    def __str__(self) -> str:
        achieved, ended = (
            f"{each.callee}({given(each.arguments)})" for each in (self.achieved_by, self.ended_by)
        )
        return f"{achieved} achieves {self.fact}, and {ended} ends that again"

    @property
    def is_in_order(self) -> bool:
        """Whether the call that brings it about is written first, in one body."""
        first, second = self.achieved_by.span, self.ended_by.span
        return first.path == second.path and first.line < second.line


def undoing(registry: Registry, steps: Sequence[Step]) -> Undoing | None:
    """Return what a program's calls undo, of the run of a program that makes most of the steps."""
    runs: defaultdict[int, list[Step]] = defaultdict(list)
    for step in steps:
        runs[step.run].append(step)
    longest = max(runs.values(), key=len, default=[])
    return next(_undone(registry, longest), None)


def _undone(registry: Registry, steps: Sequence[Step]) -> Iterator[Undoing]:
    """Yield what calls of one run of a program undo, where the same call is made again.

    What the later call requires is left out: it is there to be used up.
    """
    states = [State(registry, each.seen) for each in steps]
    for first, step in enumerate(steps[:-2]):
        row = registry[step.call.callee]
        for fact in states[first + 1].literals(row.achieves, row.bind(step.call.arguments)):
            if states[first].holds(fact) or not states[first + 1].holds(fact):
                continue
            end = next((n for n in range(first + 2, len(steps)) if not states[n].holds(fact)), None)
            if end is None or not any(later.call == step.call for later in steps[end:]):
                continue
            ender = steps[end - 1].call
            user = registry[ender.callee]
            if fact not in states[end - 1].literals(user.requires, user.bind(ender.arguments)):
                yield Undoing(fact, step.call, ender)
