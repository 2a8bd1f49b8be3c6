"""Queries to a learned program and their right answers: the interface between labels and core."""

from __future__ import annotations

from dataclasses import dataclass, field

from ntp_dsl.demonstrations.demonstration import Demonstration, Scope
from ntp_dsl.semantics.observation import Observation


@dataclass(frozen=True)
class Query:
    """The input of a learned program: the observation, the running program, its scope and arguments."""

    program: str
    arguments: tuple[str | float, ...]  # that its caller predicted; lists are never given
    scope: Scope | None
    observation: Observation = field(repr=False)
    demonstration: Demonstration = field(repr=False)


@dataclass(frozen=True)
class Answer:
    """The next call, or the end of the program where `callee` is None: done, or unfinished."""

    callee: str | None
    arguments: tuple[str | float, ...] = ()
    scope: Scope | None = None
    done: bool = True


@dataclass(frozen=True)
class Sample:
    """A query with its answer, as training takes them."""

    query: Query
    answer: Answer
    is_new: bool = False  # about a state that no episode went through
