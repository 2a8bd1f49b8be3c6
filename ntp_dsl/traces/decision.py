"""Decisions: the choice that was made, its alternatives and its probability."""

from __future__ import annotations

from typing import Annotated, Generic, TypeVar

from msgspec import Meta, Struct

from ntp_dsl.common.decoding import Count
from ntp_dsl.semantics.observation import Argument

Value = TypeVar("Value")
Frames = tuple[Count, Count]  # of a demonstration [begin, end)
Probability = Annotated[float, Meta(ge=0, le=1)]
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
    callees: Ranking[str] = ()
    arguments: tuple[Ranking[str | float], ...] = ()  # one for each argument or field of a record
    scopes: Ranking[Frames | None] = ()
    facts: tuple[FactProbability, ...] = ()
    answer: Answer | None = None


NO_DECISION = Decision()
