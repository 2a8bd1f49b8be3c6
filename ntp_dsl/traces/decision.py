"""What was decided and by what: the record that a person inspects and a comparison weighs."""

from __future__ import annotations

from typing import Annotated, Generic, TypeVar

from msgspec import Meta, Struct

from ntp_dsl.semantics.observation import Argument

Value = TypeVar("Value")
Count = Annotated[int, Meta(ge=0)]
Frames = tuple[Count, Count]  # of a demonstration [begin, end)
Probability = Annotated[float, Meta(ge=0, le=1)]
Seconds = Annotated[float, Meta(ge=0, lt=1e9)]


class Alternative(Struct, Generic[Value], frozen=True, array_like=True):
    """Something that a decision might have chosen."""

    value: Value
    probability: Probability


Ranking = tuple[Alternative[Value], ...]  # the most probable first


class FactProbability(Struct, frozen=True, omit_defaults=True):
    """A ground fact that a decision rests on: as the policy saw it, and as it truly was."""

    fact: str
    probability: Probability
    truth: bool | None = None  # None where nobody knows


class Answer(Struct, frozen=True, omit_defaults=True):
    """What a policy answered that was only asked; a callee of None is a return."""

    callee: str | None
    is_api: bool = False
    arguments: tuple[Argument, ...] = ()
    scope: Frames | None = None


class Decision(Struct, frozen=True, omit_defaults=True, kw_only=True):
    """A program's decision to make a call or to return.

    A script weighs no alternatives: its probabilities are None, its rankings empty.
    """

    source: str = ""  # file:line of the statement that was followed, or that makes such a call
    reason: str = ""  # of a script's return
    seconds: Seconds = 0.0  # wall time that it took
    probability: Probability | None = None  # of all of it together
    end_probability: Probability | None = None  # of the program's end
    callees: Ranking[str] = ()
    arguments: tuple[Ranking[str | float], ...] = ()  # for each argument; a record's fields in its place
    scopes: Ranking[Frames | None] = ()
    facts: tuple[FactProbability, ...] = ()
    answer: Answer | None = None


NO_DECISION = Decision()
