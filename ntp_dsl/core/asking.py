"""Questions about decisions: where they are in doubt, whoever runs a program may be asked what to do."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from ntp_dsl.semantics.observation import Argument, Observation, without_lists
from ntp_dsl.traces.decision import Asked, Option, Step


@dataclass(frozen=True)
class Question:
    """What a running program may do now."""

    program: str
    arguments: tuple[Argument, ...]
    seen: Observation
    options: tuple[Option, ...]  # the first is what it does unless it is told otherwise
    is_end: bool  # whether that is to say that all is done

    @property
    def who(self) -> Step:
        """Return the program and its arguments."""
        return self.program, without_lists(self.arguments)


class Adviser(Protocol):
    """Someone who may say what is to be done."""

    def advise(self, question: Question) -> int | None:
        """Return the number of the option that is to be taken, from 0; None where nothing was asked."""


class Asking:
    """Asks about decisions that are less probable than is wanted.

    A wrong call is mended at the next look, a wrong end is not: they have thresholds of their own.

    Args:
        ask: returns the number of the option that a person takes, from 0.
        ends_below: probability of the end of all, below which is asked whether all is done.
        calls_below: probability of other decisions, below which is asked what is to be done.
    """

    def __init__(self, ask: Callable[[Question], int], ends_below: float, calls_below: float = 0.0) -> None:
        self._ask, self._ends_below, self._calls_below = ask, ends_below, calls_below

    def advise(self, question: Question) -> int | None:
        threshold = self._ends_below if question.is_end else self._calls_below
        if len(question.options) < 2 or question.options[0].probability >= threshold:
            return None
        return self._ask(question)


Said = tuple[str, tuple[Argument, ...], Observation, Asked]  # by which program, and in which state


class Repeated:
    """Says what was said before, in the same states: for replays."""

    def __init__(self, said: Sequence[Said]) -> None:
        self._said: dict[Step, list[tuple[Observation, Asked]]] = defaultdict(list)
        for program, arguments, seen, asked in said:
            self._said[program, without_lists(arguments)].append((seen, asked))

    def advise(self, question: Question) -> int | None:
        steps = [each.step for each in question.options]
        here = [asked for seen, asked in self._said.get(question.who, ()) if seen == question.seen]
        same = [asked for asked in here if [each.step for each in asked.options] == steps]
        for asked in (*same, *here):
            if asked.taken.step in steps:
                return steps.index(asked.taken.step)
        return None
