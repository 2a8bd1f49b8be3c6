"""Decisions: the choice that was made, its alternatives and its probability."""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum
from typing import Annotated, Generic, TypeVar

from msgspec import Meta, Struct

from ntp_dsl.common.decoding import Count
from ntp_dsl.semantics.observation import Argument, without_lists

Value = TypeVar("Value")
Frames = tuple[Count, Count]  # of a demonstration [begin, end)
Probability = Annotated[float, Meta(ge=0, le=1)]
Step = tuple[str | None, tuple[str | float, ...]]  # a callee, or None for a return, and its arguments
Seconds = Annotated[float, Meta(ge=0, lt=1e9)]


class Alternative(Struct, Generic[Value], frozen=True, array_like=True):
    """An alternative of a decision."""

    value: Value
    probability: Probability


Ranking = tuple[Alternative[Value], ...]  # most probable first


class FactProbability(Struct, frozen=True, omit_defaults=True):
    """A ground fact that a decision rests on: its probability by the policy, and its true value."""

    fact: str
    probability: Probability
    truth: bool | None = None  # None where unknown
    forced: bool = False  # by whoever supervised the run, whatever was the case


class Dispatch(StrEnum):
    """How the one core finds the next call: by the language's rule, or by what was learnt under doubt."""

    RULE = "rule"
    LEARNED = "learned"


class Status(StrEnum):
    """What became of a statement when its program decided."""

    DUE = "due"
    ACHIEVED = "achieved"
    VAIN = "in vain"  # all that it would call would return at once
    PASSED = "passed over"  # nothing that is needed comes of it
    ABSENT = "absent"  # its `when` is false


class StatementStatus(Struct, frozen=True, omit_defaults=True, kw_only=True):
    """A statement of a program's body at a decision: the call that it stood for, and what that lacked.

    Where its program returns unfinished, `why` says why it leads to no call, in words.
    """

    line: Count
    status: Status
    callee: str = ""
    arguments: tuple[Argument, ...] = ()
    lacks: tuple[str, ...] = ()
    why: str = ""


class ReadList(Struct, frozen=True):
    """A list of a program's arguments, as it was read from the demonstration."""

    parameter: str
    elements: tuple[Argument, ...]


class Other(Struct, frozen=True):
    """An element that a list may have instead of one that was read."""

    element: Argument
    probability: Probability


class Doubt(Struct, frozen=True, omit_defaults=True):
    """An element that may be another, as far as the demonstration shows."""

    parameter: str
    number: Count  # in its list
    element: Argument
    probability: Probability
    others: tuple[Other, ...]
    answer: Argument | None = None  # of whoever was asked which is meant

    @property
    def offered(self) -> Iterator[tuple[Argument, Probability]]:
        """Yield all elements that may be meant, each with its probability."""
        yield self.element, self.probability
        yield from ((each.element, each.probability) for each in self.others)


class Reading(Struct, frozen=True, omit_defaults=True):
    """What a program reads from its scope of the demonstration, and how much that explains."""

    lists: tuple[ReadList, ...]
    explained: Count  # acts of the hand,
    acts: Count  # of so many
    doubts: tuple[Doubt, ...] = ()


class Option(Struct, frozen=True):
    """What a program may do: a call, or a return where the callee is None."""

    callee: str | None
    arguments: tuple[Argument, ...]
    probability: Probability

    @property
    def step(self) -> Step:
        """Return what it stands for, without lists."""
        return self.callee, without_lists(self.arguments)


class Asked(Struct, frozen=True):
    """What somebody was asked about a decision, and which of the options was taken, from 0."""

    options: tuple[Option, ...]
    answer: Count

    def __post_init__(self) -> None:
        if self.answer >= len(self.options):
            raise ValueError(f"expected an answer below {len(self.options)}, found {self.answer}")

    @property
    def taken(self) -> Option:
        """Return the option that was taken."""
        return self.options[self.answer]


class Answer(Struct, frozen=True, omit_defaults=True):
    """The call that a policy would make in a replay; a callee of None is a return."""

    callee: str | None
    is_api: bool = False
    arguments: tuple[Argument, ...] = ()
    scope: Frames | None = None


class Decision(Struct, frozen=True, omit_defaults=True, kw_only=True):
    """A program's decision to make a call or to return.

    The scripted expert weighs no alternatives: its probabilities are None, its rankings empty.
    """

    source: str = ""  # file:line of the statement that was followed, or of the one that makes such a call
    reason: str = ""  # why the expert returned
    seconds: Seconds = 0.0  # wall time
    probability: Probability | None = None  # of the whole decision
    end_probability: Probability | None = None  # that the program is at its end
    achieved: Probability | None = None  # of a return: that all holds that the program is to achieve
    callees: Ranking[str] = ()
    arguments: tuple[Ranking[str | float], ...] = ()  # one for each argument or field of a record
    scopes: Ranking[Frames | None] = ()
    facts: tuple[FactProbability, ...] = ()
    statements: tuple[StatementStatus, ...] = ()
    read: Reading | None = None  # at a program's first decision, if it takes lists
    scripted: bool = False  # by a function in Python that no body or learnt row stands for
    asked: Asked | None = None  # where the decision was left to somebody
    answer: Answer | None = None

    @property
    def mistaken(self) -> list[FactProbability]:
        """Return the facts that it was wrong about."""
        return [
            each for each in self.facts if each.truth is not None and (each.probability > 0.5) != each.truth
        ]


NO_DECISION = Decision()
