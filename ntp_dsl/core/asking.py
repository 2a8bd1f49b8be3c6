"""Questions about decisions: where they are in doubt, whoever runs a program may be asked what to do."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import Argument, Observation, without_lists
from ntp_dsl.traces.decision import Asked, Option

Given = tuple[str | float, ...]  # arguments, without lists
Done = tuple[str | None, Given]  # a callee and its arguments; no callee is a return


@dataclass(frozen=True)
class Question:
    """What a running program may do now."""

    program: str
    arguments: tuple[Argument, ...]
    seen: Observation
    options: tuple[Option, ...]  # the first is what it does unless it is told otherwise
    is_end: bool  # whether that is to say that all is done

    @property
    def who(self) -> Done:
        """Return the program and its arguments."""
        return self.program, without_lists(self.arguments)


class Person(Protocol):
    """Someone who may say what is to be done."""

    def advise(self, question: Question) -> int | None:
        """Return the number of the option that is to be taken, from 0; None where nothing was asked."""


class Asking:
    """Asks about decisions that are less probable than is wanted, once while nothing changes.

    A wrong call is mended at the next look, a wrong end is not: they have thresholds of their own.

    Args:
        ends_below: probability of the end of all, below which is asked whether all is done.
        calls_below: probability of other decisions, below which is asked what is to be done.
        ask: returns the number of the option that a person takes, from 0.
    """

    def __init__(
        self, registry: Registry, ask: Callable[[Question], int], ends_below: float, calls_below: float = 0.0
    ) -> None:
        self._registry, self._ask = registry, ask
        self._ends_below, self._calls_below = ends_below, calls_below
        self._answered: dict[Done, Done] = {}  # what a program is to do, until a primitive is called

    def advise(self, question: Question) -> int | None:
        done = [of_option(each) for each in question.options]
        answer: int | None = None
        if (wanted := self._answered.get(question.who)) in done:
            answer = done.index(wanted)
        elif len(done) > 1 and question.options[0].probability < self._threshold(question):
            answer = self._ask(question)
            self._answered[question.who] = done[answer]
        callee, _ = done[answer or 0]
        if callee in self._registry.apis:
            self._answered.clear()
        return answer

    def _threshold(self, question: Question) -> float:
        return self._ends_below if question.is_end else self._calls_below


Said = tuple[str, tuple[Argument, ...], Observation, Asked]  # by which program, and in which state


class Repeated:
    """Says what was said before, in the same states: for replays."""

    def __init__(self, said: Sequence[Said]) -> None:
        self._said: dict[Done, list[tuple[Observation, Asked]]] = defaultdict(list)
        for program, arguments, seen, asked in said:
            self._said[program, without_lists(arguments)].append((seen, asked))

    def advise(self, question: Question) -> int | None:
        done = [of_option(each) for each in question.options]
        for seen, asked in self._said.get(question.who, ()):
            wanted = of_option(asked.options[asked.answer])
            if seen == question.seen and wanted in done:
                return done.index(wanted)
        return None


def of_option(option: Option) -> Done:
    """Return what an option stands for."""
    return option.callee, without_lists(option.arguments)
