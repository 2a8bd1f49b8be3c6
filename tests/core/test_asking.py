"""Decisions that are in doubt are left to whoever runs a program; and in doubt, the program looks again."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import pytest
from one_core_samples import DOMAINS

from ntp_dsl.core.asking import Asking, Question, Repeated
from ntp_dsl.core.one_core import shipped_core
from ntp_dsl.core.policy import LOOKS, OneShotPolicy
from ntp_dsl.evaluation.episodes import Episode, Evaluator, Plan
from ntp_dsl.policies.protocol import Barred, Choice, Frame
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.traces.decision import Asked, Option
from ntp_dsl.worlds.protocol import Disturbances, World

NOWHERE = Observation((), {}, (0.0, 0.0, 0.5), False)


def question(*options: Option, program: str = "light_all") -> Question:
    return Question(program, (), NOWHERE, options, options[0].callee is None)


def call(callee: str | None, probability: float) -> Option:
    return Option(callee, (), probability)


class Noted:
    """Whoever is asked: takes note of the questions, and of each the same option."""

    def __init__(self, answer: int) -> None:
        self.answer = answer
        self.questions: list[Question] = []

    def __call__(self, question: Question) -> int:
        self.questions.append(question)
        return min(self.answer, len(question.options) - 1)


def test_only_what_is_less_probable_than_wanted_is_asked() -> None:
    noted = Noted(1)
    asking = Asking(noted, 0.8, 0.6)
    assert asking.advise(question(call(None, 0.9), call("light", 0.1))) is None
    assert asking.advise(question(call(None, 0.7))) is None  # there is nothing to choose from
    assert asking.advise(question(call("light", 0.7), call(None, 0.3))) is None
    assert not noted.questions
    assert asking.advise(question(call(None, 0.7), call("light", 0.3))) == 1
    assert asking.advise(question(call("pick", 0.55), call(None, 0.45), program="light")) == 1
    assert len(noted.questions) == 2


def test_a_replay_says_what_was_said_in_the_same_state() -> None:
    asked = Asked((call(None, 0.6), call("light", 0.4)), 1)
    repeated = Repeated([("light_all", (), NOWHERE, asked)])
    doubtful = question(call("light", 0.5), call(None, 0.5))
    assert repeated.advise(doubtful) == 0  # what was said, wherever it is offered
    assert repeated.advise(question(call(None, 0.6))) is None
    assert repeated.advise(replace(doubtful, program="light")) is None
    assert repeated.advise(replace(doubtful, seen=replace(NOWHERE, closed=True))) is None


def episode(noise: float, below: float, noted: Noted, seed: int = 10) -> Episode:
    plan = Plan(
        DOMAINS / "lanterns", "in_doubt", shipped_core(), seed=seed, disturbances=Disturbances(noise=noise)
    )
    evaluator = Evaluator(plan)
    recorded, _ = evaluator.demonstration(evaluator.instance(0), 0)
    policy = evaluator.policy(recorded)
    assert isinstance(policy, OneShotPolicy)
    policy.adviser = Asking(noted, below)
    return evaluator.episode(0, recorded, policy=policy)


def test_somebody_is_asked_whether_all_is_done() -> None:
    """Of what is offered the first is what would have been done: so it makes no difference."""
    noted = Noted(0)
    found = episode(0.012, 0.8, noted)
    assert found.success and noted.questions
    (ends,) = noted.questions
    assert ends.is_end and ends.program == "light_all" and ends.options[0].probability < 0.8
    assert {each.callee for each in ends.options[1:]} == {"light"}


def test_a_question_is_put_once_while_nothing_changes() -> None:
    """A program ends when it has said so twice."""
    noted = Noted(0)
    assert episode(0.012, 1.0, noted).success
    assert sum(each.is_end for each in noted.questions) == 1


def test_what_somebody_says_is_done_is_done() -> None:
    """Where it does not look so, the program would go on, or give up."""

    def returning(question: Question) -> int:
        return next((n for n, each in enumerate(question.options) if each.callee is None), 0)

    plan = Plan(
        DOMAINS / "lanterns", "in_doubt", shipped_core(), seed=6, disturbances=Disturbances(noise=0.02)
    )
    evaluator = Evaluator(plan)
    recorded, _ = evaluator.demonstration(evaluator.instance(0), 0)
    policy = evaluator.policy(recorded)
    assert isinstance(policy, OneShotPolicy)
    policy.adviser = Asking(returning, 1.0, 1.0)
    found = evaluator.episode(0, recorded, policy=policy)
    assert found.confidence == pytest.approx(0.5, abs=0.02)  # of the bay that was read, unasked


def test_what_somebody_says_is_done() -> None:
    more = episode(0.012, 0.8, Noted(1))
    assert more.success and more.primitives > episode(0.012, 0.8, Noted(0)).primitives


def test_nothing_is_asked_where_nothing_is_in_doubt() -> None:
    noted = Noted(1)
    assert episode(0.0, 0.8, noted).success and not noted.questions


class Looking:
    """A policy of which the looks at the world are counted, for each decision."""

    def __init__(self, policy: OneShotPolicy) -> None:
        self.kind = policy.kind
        self._policy = policy
        self.looks: list[tuple[int, float]] = []  # and how probable the decision is

    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame:
        return self._policy.root(program, arguments)

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        eye = Eye(world)
        choice = self._policy.decide(frame, cast(World, eye), barred)  # it only looks
        self.looks.append((eye.looks, choice.decision.probability or 0.0))
        return choice


class Eye:
    def __init__(self, world: World) -> None:
        self._world = world
        self.looks = 0

    def observe(self) -> Observation:
        self.looks += 1
        return self._world.observe()


def looks(noise: float) -> list[tuple[int, float]]:
    """Return how often each decision of an episode looked, and how probable it was."""
    evaluator = Evaluator(
        Plan(DOMAINS / "lanterns", "lanterns", shipped_core(), disturbances=Disturbances(noise=noise))
    )
    recorded, _ = evaluator.demonstration(evaluator.instance(0), 0)
    policy = evaluator.policy(recorded)
    assert isinstance(policy, OneShotPolicy)
    looking = Looking(policy)
    assert evaluator.episode(0, recorded, policy=looking).success
    return looking.looks


def test_in_doubt_a_program_looks_again() -> None:
    found = looks(0.012)
    counts = {count for count, _ in found}
    assert 1 in counts and max(counts) <= 1 + LOOKS and len(counts) > 2
    assert min(chance for count, chance in found if 1 < count <= LOOKS) > 0.9  # it stopped as it was sure


def test_what_is_seen_exactly_is_looked_at_once() -> None:
    assert {count for count, _ in looks(0.0)} == {1}
