"""What holds of both dispatchers."""

from __future__ import annotations

from dataclasses import replace

import pytest
from one_core_samples import library, shown, the_core, the_model

from ntp_dsl.core.dispatch.dispatcher import Dispatched, Dispatcher, Situation
from ntp_dsl.core.dispatch.learned import LearnedDispatcher
from ntp_dsl.core.dispatch.rule import RuleDispatcher
from ntp_dsl.core.perception.grounding import ground
from ntp_dsl.core.perception.perceived import Perceived
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


def doubted(each: Situation, deviation: float) -> Situation:
    """Return a situation of which the objects' places are known less well."""
    seen = each.state.observation
    deviations = dict.fromkeys(seen.positions, deviation)
    state = Perceived(each.state.registry, replace(seen, deviations=deviations), the_core().grounding)
    state.graded = ground(the_core().grounding, seen)  # of what the network perceives, nothing is in doubt
    return replace(each, state=state)


@pytest.mark.parametrize("name", ["line_up", "sky", "kitting"])
def test_how_well_objects_are_seen_changes_probabilities_and_not_decisions(by: str, name: str) -> None:
    deciding, every = dispatcher(by, name), situations(name, 3)
    lower = 0
    for each, sure in zip(every, deciding.dispatch(every), strict=True):
        (found,) = deciding.dispatch([doubted(each, 0.01)])
        assert found.answer == sure.answer
        probability = found.decision.probability
        assert probability is not None
        lower += probability < (sure.decision.probability or 0) - 0.05
        assert sum(chance for _, chance in found.others) + probability < 1.001
    assert lower


@pytest.mark.parametrize("name", ["line_up", "sky", "kitting"])
def test_where_a_return_is_barred_something_is_called(name: str) -> None:
    """Numbers among arguments hang on where objects are: calls are the same without them."""
    deciding = dispatcher("learned", name)
    for each in situations(name, 3):
        barred = replace(each, barred=frozenset({None}))
        (sure,) = deciding.dispatch([barred])
        (found,) = deciding.dispatch([replace(doubted(each, 0.02), barred=frozenset({None}))])
        assert isinstance(found.answer, Return) == isinstance(sure.answer, Return)


def test_places_that_all_say_otherwise_are_no_certainty(by: str) -> None:
    """A lantern is seen to stand within the limit, and hardly does."""
    deciding = dispatcher(by, "lanterns")
    done = [each for each in situations("lanterns", 3) if each.program == "light"]
    ends = [each for each in done if isinstance(deciding.dispatch([each])[0].answer, Return)]
    assert ends
    for each in ends:
        (found,) = deciding.dispatch([doubted(each, 0.5)])
        assert isinstance(found.answer, Return)
        assert found.achieved < 0.2 and (found.decision.probability or 0) < 0.2
