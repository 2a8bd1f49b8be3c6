"""The exact rule of the language, over facts that probably hold."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ntp_dsl.core.dispatch.dispatcher import Dispatched, Situation
from ntp_dsl.core.dispatch.rows import Named, named, unrolled
from ntp_dsl.core.perception.perceived import Believed, Variant
from ntp_dsl.language.registry import Program
from ntp_dsl.policies.evidence import rounded, weighed
from ntp_dsl.policies.expert import Expert, NextCall, Return
from ntp_dsl.policies.left_out import told_evidence
from ntp_dsl.policies.scripted import source_of
from ntp_dsl.semantics.observation import Argument, without_lists
from ntp_dsl.traces.decision import Alternative, Decision, Ranking


class RuleDispatcher:
    """Decides as an expert does. How sure that is, is how sure the facts are that it rests on."""

    def __init__(self, expert: Expert) -> None:
        self.expert = expert

    def dispatch(self, situations: Sequence[Situation]) -> list[Dispatched]:
        return [self._dispatched(each) for each in situations]

    def _dispatched(self, situation: Situation) -> Dispatched:
        arguments, state = situation.arguments, situation.state
        answer = self.expert.decide(situation.program, arguments, state)
        decided = _decided(answer)
        if isinstance(answer, NextCall) and answer.callee in situation.barred:
            answer = Return(False, f"{answer.callee} was of no use")
        row = self.expert.registry.programs[situation.program]
        is_unfinished = isinstance(answer, Return) and not answer.done
        grounds, statements = told_evidence(self.expert, row, arguments, state, is_unfinished)
        facts = weighed(grounds, state.probability)
        sure = min((max(each.probability, 1 - each.probability) for each in facts), default=1.0)
        variants: list[Variant] = [(1.0, state)]
        if state.observation.deviations:
            variants = state.variants(unrolled(row, arguments, state).facts)
        if not row.in_python:
            sure *= sum(w for w, each in variants if self._decides(situation, each) == decided)
        sure = round(sure, 4)
        end = rounded(sum(w * self._end_probability(row, arguments, each) for w, each in variants))
        return Dispatched(
            answer,
            Decision(
                source=source_of(answer) if isinstance(answer, NextCall) else "",
                reason=answer.reason if isinstance(answer, Return) else "",
                scripted=row.in_python,
                callees=(Alternative(answer.callee, sure),) if isinstance(answer, NextCall) else (),
                arguments=_certain(answer, sure) if isinstance(answer, NextCall) else (),
                end_probability=end,
                probability=sure,
                facts=facts,
                statements=statements,
            ),
            end,
            grounds,
        )

    def _decides(self, situation: Situation, state: Believed) -> tuple[str | None, Named]:
        """Return what would be decided in a state."""
        return _decided(self.expert.decide(situation.program, situation.arguments, state))

    def _end_probability(self, row: Program, arguments: tuple[Argument, ...], state: Believed) -> Any:
        """Return how probably all that a program achieves holds."""
        return min(map(state.probability, state.contract(row.name, arguments).achieves), default=1.0)


def _decided(answer: NextCall | Return) -> tuple[str | None, Named]:
    return (answer.callee, named(answer.arguments)) if isinstance(answer, NextCall) else (None, ())


def _certain(call: NextCall, sure: float) -> tuple[Ranking[str | float], ...]:
    """Return the arguments as rankings of one: the statement binds them."""
    return tuple((Alternative(value, sure),) for value in without_lists(call.arguments))
