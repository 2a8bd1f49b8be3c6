"""What holds of both dispatchers."""

from __future__ import annotations

from dataclasses import replace

import pytest
from one_core_samples import library, shown, the_core, the_model

from ntp_dsl.core.dispatch.dispatcher import Dispatched, Dispatcher, Situation
from ntp_dsl.core.dispatch.learned import LearnedDispatcher
from ntp_dsl.core.dispatch.rule import RuleDispatcher
from ntp_dsl.policies.expert import Expert, Return


@pytest.fixture(params=["rule", "learned"])
def by(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def dispatcher(by: str, name: str) -> Dispatcher:
    expert = Expert(library(name))
    return RuleDispatcher(expert) if by == "rule" else LearnedDispatcher(expert, the_core().dispatch)


def situations(name: str, seed: int) -> list[Situation]:
    """Return every demonstrated call, at each of four moments."""
    task, demonstration = shown(name, seed)
    source = the_model(task.registry, task.instance.program).read(demonstration)
    scope = 0, len(demonstration)
    call = source.reading(task.instance.program, task.instance.arguments, scope).call
    calls = [each for each in call.walk() if each.name in task.registry.programs]
    moments = [len(demonstration) * part // 4 for part in range(4)]
    return [
        Situation(each.name, each.arguments, source.perceive(source.look(moment)))
        for moment in moments
        for each in calls
    ]


def answered(found: Dispatched) -> tuple[object, ...]:
    return found.answer, [each.value for each in found.decision.callees]


@pytest.mark.parametrize("name", ["block_stacking", "seating", "table_cleanup"])
def test_situations_are_decided_together_as_they_are_alone(by: str, name: str) -> None:
    deciding, every = dispatcher(by, name), situations(name, 3)
    together = deciding.dispatch(every)
    alone = [deciding.dispatch([each])[0] for each in every]
    assert list(map(answered, together)) == list(map(answered, alone))
    for one, other in zip(together, alone, strict=True):
        assert one.decision.probability == pytest.approx(other.decision.probability, abs=2e-4)


def test_nothing_to_decide_is_no_decision(by: str) -> None:
    assert dispatcher(by, "block_stacking").dispatch([]) == []


def test_no_barred_callee_is_called(by: str) -> None:
    deciding, every = dispatcher(by, "block_stacking"), situations("block_stacking", 3)
    called = {getattr(each.answer, "callee", None) for each in deciding.dispatch(every)} - {None}
    assert called
    for callee in called:
        barred = [Situation(each.program, each.arguments, each.state, frozenset({callee})) for each in every]
        assert all(getattr(each.answer, "callee", None) != callee for each in deciding.dispatch(barred))


def test_what_alone_is_left_is_certain(by: str) -> None:
    """The probability of a decision is that among what is not barred."""
    deciding = dispatcher(by, "block_stacking")
    for each in situations("block_stacking", 3):
        barred = frozenset({*each.state.registry.programs, *each.state.registry.apis})
        [found] = deciding.dispatch([replace(each, barred=barred)])
        assert found.decision.probability is not None and found.decision.probability > 0.5
        assert isinstance(found.answer, Return)
