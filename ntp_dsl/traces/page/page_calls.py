"""The calls of a trace for a page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import starmap
from typing import Any

from ntp_dsl.common.text import printable
from ntp_dsl.semantics.observation import without_lists
from ntp_dsl.traces import decision as traced
from ntp_dsl.traces.aftermath import seen_after
from ntp_dsl.traces.decision import Answer, Decision
from ntp_dsl.traces.failure_attribution import attribute_call
from ntp_dsl.traces.page.document import PageCall, PageDecision, PageFact, PageStatement, Ranking, Text
from ntp_dsl.traces.phrases import format_argument, format_invocation, format_measurement, format_option
from ntp_dsl.traces.schema import Call
from ntp_dsl.traces.sources import statement
from ntp_dsl.traces.times import Times
from ntp_dsl.traces.trace import Trace

MAX_EVIDENCE = 300  # [characters]


class Texts:
    """The texts of a document, each once: the same facts come up in many decisions."""

    def __init__(self) -> None:
        self._numbers: dict[str, Text] = {}

    def number(self, text: str) -> Text:
        """Return the number of a text."""
        return self._numbers.setdefault(text, len(self._numbers))

    @property
    def all(self) -> list[str]:
        """Return the texts by their numbers."""
        return list(self._numbers)


def page_call(trace: Trace, call: Call, times: Times, texts: Texts) -> PageCall:
    """Return a call for the page."""
    source = call.decision.source
    given = without_lists(call.arguments)
    return PageCall(
        name=call.name,
        program=call.is_program,
        arguments=", ".join(map(format_argument, call.arguments)),
        names=[name for name in dict.fromkeys(map(str, given)) if name in trace.states[call.state].positions],
        scope=call.scope,
        outcome=call.outcome or "",
        probability=call.decision.probability,
        times=(round(times.deciding, 5), round(times.planning, 5), round(times.moving, 5)),
        frame=call.frame,
        end_frame=call.end_frame,
        source=source,
        statement=statement(trace, source),
        attributed_to=attribute_call(call) or "",
        disturbances=call.execution.disturbances,
        unmet=call.execution.unmet,
        evidence=_evidence(call.execution.evidence),
        holds=[texts.number(fact) for fact in sorted(map(str, trace.states[call.state].facts))],
        became=[*_became(trace, call)],
        made=_decision(call.decision, [*_made(call.decision)], texts),
        returned=_returned(call.return_decision, texts),
    )


def _became(trace: Trace, call: Call) -> Iterator[str]:
    """Yield the facts of the state that came about during a call, and those that ceased to hold."""
    before, after = trace.states[call.state].facts, seen_after(trace, call)
    if after is not None:
        yield from sorted(map(str, after.facts - before))
        yield from sorted(f"not {fact}" for fact in before - after.facts)


def _evidence(measurements: Mapping[str, Any]) -> str:
    return "; ".join(starmap(format_measurement, measurements.items()))[:MAX_EVIDENCE]


def _returned(decision: Decision | None, texts: Texts) -> PageDecision | None:
    return None if decision is None else _decision(decision, [*_ended(decision)], texts)


def _decision(decision: Decision, alternatives: list[tuple[str, Ranking]], texts: Texts) -> PageDecision:
    return PageDecision(
        notes=[*_notes(decision)],
        alternatives=alternatives,
        facts=[
            PageFact(texts.number(each.fact), round(each.probability, 3), each.truth)
            for each in decision.facts
        ],
        statements=[
            PageStatement(
                texts.number(format_invocation(each.callee, each.arguments) if each.callee else ""),
                each.line,
                str(each.status),
                [texts.number(fact) for fact in each.lacks],
            )
            for each in decision.statements
        ],
    )


def _notes(decision: Decision) -> Iterator[str]:
    """Yield what else is worth telling: who decided, for which reason, and what was read."""
    if decision.scripted:
        yield "A function in Python decided."
    if decision.reason:
        yield printable(decision.reason)
    if (read := decision.read) is not None:
        for each in read.lists:
            yield printable(f"read {each.parameter} = [{', '.join(map(format_argument, each.elements))}]")
        yield f"that explains {read.explained} of {read.acts} acts of the hand"


def _made(decision: Decision) -> Iterator[tuple[str, Ranking]]:
    """Yield the alternatives of a decision to call: callees, arguments, scopes, and the caller's end."""
    yield from _doubts(decision, "as its caller read it")
    yield from _ranking("callee", decision.callees)
    for number, ranking in enumerate(decision.arguments, 1):
        yield from _ranking(f"argument {number}", ranking)
    yield from _ranking("scope", decision.scopes)
    if decision.end_probability is not None:
        yield "or to return", [("end of the caller", decision.end_probability)]
    yield from _asked(decision)
    if decision.answer is not None:
        yield "answered", [(_answer(decision.answer), decision.probability or 0.0)]


def _ended(decision: Decision) -> Iterator[tuple[str, Ranking]]:
    """Yield the alternatives of a decision to return."""
    yield from _doubts(decision, "as it read it")
    if decision.end_probability is not None:
        yield "its own end", [("end", decision.end_probability)]
    if decision.achieved is not None:
        yield "that all is achieved", [("achieved", decision.achieved)]
    yield from _asked(decision)


def _doubts(decision: Decision, who: str) -> Iterator[tuple[str, Ranking]]:
    for doubt in decision.read.doubts if decision.read is not None else ():
        yield (
            f"element {doubt.number + 1} of {doubt.parameter}, {who}",
            [(format_argument(element), chance) for element, chance in doubt.offered],
        )
        if doubt.answer is not None:
            yield "as somebody answered", [(format_argument(doubt.answer), 1.0)]


def _asked(decision: Decision) -> Iterator[tuple[str, Ranking]]:
    if (asked := decision.asked) is not None:
        yield "somebody was asked", [(format_option(each), each.probability) for each in asked.options]
        yield "and answered", [(format_option(asked.taken), 1.0)]


def _answer(answer: Answer) -> str:
    return "return" if answer.callee is None else format_invocation(answer.callee, answer.arguments)


def _ranking(title: str, ranking: traced.Ranking[Any]) -> Iterator[tuple[str, Ranking]]:
    if ranking:
        yield title, [(_alternative(each.value), each.probability) for each in ranking]


def _alternative(value: object) -> str:
    if value is None:
        return "none"
    return f"frames {value[0]} – {value[1]}" if isinstance(value, tuple) else str(value)
