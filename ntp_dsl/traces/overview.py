"""How an episode ended, in plain words: its verdict, and what its calls and decisions have in common."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from ntp_dsl.common.text import counted, printable
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.phrases import conditions, format_argument, format_call
from ntp_dsl.traces.schema import ROOT, Call
from ntp_dsl.traces.trace import Trace

OFTEN, SHARE = 5, 0.25  # times that a call is made, and of all primitives, for it to be told
FEW = 3  # elements that a sentence names


def overview(trace: Trace) -> list[str]:
    """Return how an episode ended, as sentences."""
    sentences = [
        _verdict(trace),
        *_repeated(trace),
        *_unmet(trace),
        *_disturbed(trace),
        *_mistaken(trace),
        *_misread(trace),
    ]
    return [printable(each) for each in sentences]


def _verdict(trace: Trace) -> str:
    under = f" ({under})" if (under := conditions(trace.header)) else ""
    who = f"The episode by the {trace.header.policy or 'unknown'} policy{under}"
    end = trace.end
    if end is None:
        return f"{who} was cut off."
    said = end.verdict or end.reason
    if end.success is None:
        return f"{who} was {end.ending}{f': {said}' * bool(said)}."
    if end.success:
        return f"{who} succeeded."
    cause = f", which is attributed to {end.attributed_to}" if end.attributed_to else ""
    return f"{who} failed{cause}: {said or end.ending}."


def _primitives(trace: Trace) -> list[Call]:
    return [call for call in trace.calls if not call.is_program]


def _repeated(trace: Trace) -> Iterator[str]:
    """Yield the call that was made again and again, if there is one."""
    calls = _primitives(trace)
    for text, count in Counter(format_call(call) for call in calls if call.arguments).most_common(1):
        if count >= OFTEN and count >= SHARE * len(calls):
            yield f"{count} of its {len(calls)} primitives were {text}."


def _unmet(trace: Trace) -> Iterator[str]:
    """Yield the primitives that reported success without what they are to achieve."""
    reported = [call for call in _primitives(trace) if call.succeeded]
    broken = [call for call in reported if call.execution.unmet]
    for name, count in Counter(call.name for call in broken).most_common(FEW):
        said = counted(sum(call.name == name for call in reported), "time")
        fact = next(call.execution.unmet[0] for call in broken if call.name == name)
        yield (
            f"{name} reported success {said}, and what it is to achieve did not hold after {count} of them, "
            f"such as {fact}: the skill, the predicate or a number that it was given is wrong, or something "
            "is in the way."
        )


def _disturbed(trace: Trace) -> Iterator[str]:
    count = sum(len(call.execution.disturbances) for call in trace.calls)
    if count:
        yield f"It was disturbed {counted(count, 'time')}."


def _mistaken(trace: Trace) -> Iterator[str]:
    """Yield how many decisions rest on a fact that was seen wrongly."""
    decisions = [*trace.decisions()]
    wrong = [(each, found) for each in decisions if (found := each.mistaken)]
    if wrong:
        kinds = Counter(fact.fact.partition("(")[0] for _, facts in wrong for fact in facts)
        most = " and ".join(f"{name} ({count})" for name, count in kinds.most_common(2))
        yield f"{len(wrong)} of {len(decisions)} decisions rest on a fact seen wrongly, most often {most}."


def _misread(trace: Trace) -> Iterator[str]:
    """Yield where what was read from the demonstration is not the task's goal."""
    for call, read in trace.readings():
        if call.parent != ROOT:
            continue
        if read.explained < read.acts:
            yield f"What was read explains {read.explained} of {counted(read.acts, 'act')} of the hand."
        elements = {each for row in read.lists for each in row.elements}
        lacking = [each for each in trace.header.goal if each not in elements]
        if lacking:
            others = [each for row in read.lists for each in row.elements if each not in trace.header.goal]
            instead = f"; {_listed(others)} was read instead" if others else ""
            yield f"Of its goal, {_listed(lacking)} was not read from the demonstration{instead}."
        return


def _listed(elements: Sequence[Argument]) -> str:
    return ", ".join(map(format_argument, elements[:FEW]))
