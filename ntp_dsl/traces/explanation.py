"""Why a call was made, and what came of it, in plain words: from what its trace says."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from msgspec.structs import replace as with_fields

from ntp_dsl.common.text import counted, enumerated, printable
from ntp_dsl.semantics.observation import without_lists
from ntp_dsl.traces.aftermath import NAME, aftermath, at_the_end, never_made_good
from ntp_dsl.traces.circles import circle
from ntp_dsl.traces.decision import Decision, Dispatch, FactProbability, Option, StatementStatus, Status
from ntp_dsl.traces.failure_attribution import attribute_call
from ntp_dsl.traces.phrases import (
    format_argument,
    format_asked,
    format_call,
    format_doubt,
    format_invocation,
    format_measurement,
    format_option,
    format_scope,
)
from ntp_dsl.traces.schema import ROOT, Call, Ending
from ntp_dsl.traces.sources import statement
from ntp_dsl.traces.trace import Trace

NOT = "not "  # with which the text of a fact begins that is to be false
MOST, FEW = 6, 3  # facts or statements that a sentence names, and a line
LONG = 300  # characters of a measurement
Quoted = Callable[[int], str]  # the text of a statement at a line; empty where it is unknown
SURE, LEAST = 0.995, 0.005  # probabilities that are not worth telling: from the one, and below the other


def explanation(trace: Trace, call: Call) -> list[str]:
    """Return why a call was made, what its program read and did, and what came of it: a paragraph each."""
    told = [
        [_head(trace, call)],
        [*_reasons(trace, call)],
        [*_reading(trace, call)],
        [*_outcome(trace, call)],
    ]
    return [printable(" ".join(sentences)) for sentences in told if sentences]


def reasons(decision: Decision) -> list[str]:
    """Return what a decision rests on, as sentences: the facts that it saw, and what was due."""
    because = [f"Because: {decision.reason}."] if decision.reason else []
    found = [*because, *_seen(decision), *_statements(decision.statements, _unquoted)]
    return found or ["All that it saw held."]


def brief(call: Call) -> str:
    """Return why a call was made in a line: what did not hold, and what was seen wrongly."""
    decision = call.decision
    lacking = [each for each in decision.facts if each.probability <= 0.5][:FEW]
    parts = [f"it saw that {_facts(lacking)} did not hold"] if lacking else []
    if wrong := decision.mistaken[:FEW]:
        parts.append(f"it was wrong about {_facts(wrong)}")
    return printable("; ".join(parts))


def interesting(trace: Trace) -> Call | None:
    """Return the call that one would ask about.

    Of a run that says that it is done and is not, that is the task's program, which read what to do. Of one
    that goes round in a circle, it is the call of it that does not succeed, or whose effect another undoes.
    Of any other that failed, it is the last primitive that went wrong and was not made good, narrowed, as
    long as any remain, to those with a visible aftermath, undisturbed, of the failure's attribution, and
    about its objects. Where none went wrong, it is the innermost program that found nothing left to do, of
    those that had done something. Of a run that succeeded it is the first that failed, or else the least
    probable.
    """
    failed = [call for call in trace.calls if _went_wrong(trace, call)]
    end = trace.end
    if end is not None and end.success is False:
        roots = trace.children(ROOT)
        if not failed or end.ending is Ending.DONE:
            return roots[-1] if roots else None
        if found := circle(trace):
            undone = found.undone()
            return next(iter(found.failing), undone[1] if undone else found.calls[0])
        bad = never_made_good(trace)
        if not bad:
            return _dead_end(trace, roots) or failed[-1]
        about = set(NAME.findall(end.verdict))
        for is_telling in (
            lambda each: aftermath(trace, each),
            lambda each: not each.execution.disturbances,
            lambda each: attribute_call(each) is end.attributed_to,
            lambda each: not about.isdisjoint(map(str, without_lists(each.arguments))),
        ):
            bad = [each for each in bad if is_telling(each)] or bad
        return bad[-1]
    if failed:
        return failed[0]
    made = [call for call in trace.calls if call.parent != ROOT]
    return min(made, key=_sureness, default=None)


def _dead_end(trace: Trace, roots: Sequence[Call]) -> Call | None:
    """Return the innermost of the last calls that returned unfinished although each had called something."""
    found = None
    below: Sequence[Call] = [each for each in roots if trace.children(each.id)]
    while below and below[-1].is_program and not below[-1].succeeded:
        found = below[-1]
        below = [each for each in trace.children(found.id) if trace.children(each.id)]
    return found


def _sureness(call: Call) -> float:
    return 1.0 if call.decision.probability is None else call.decision.probability


def _went_wrong(trace: Trace, call: Call) -> bool:
    if call.succeeded:
        return bool(call.execution.unmet)
    return all(below.succeeded for below in trace.children(call.id))


def _head(trace: Trace, call: Call) -> str:
    number = f"call {call.id}, {format_call(call)},"
    if call.parent == ROOT:
        what = "is the task's own program" if call.is_program else "was tried by itself"
        return f"{number} {what}.{_told(trace)}"
    caller = trace.calls[call.parent]
    place = call.decision.source
    text = statement(trace, place)
    where = f", at {place}" + (f", `{text}`" if text else "") if place else ""
    return f"{number} was made by call {caller.id}, {format_call(caller)}{where}."


def _told(trace: Trace) -> str:
    """Return by which sentences the lists were told, and how sure that is; nothing where none were said."""
    header = trace.header
    if not header.said:
        return ""
    sentences = enumerated([f"'{each}'" for each in header.said])
    return f" It was told {sentences}, which was understood with a probability of {header.understood:.0%}."


def _reasons(trace: Trace, call: Call) -> Iterator[str]:
    """Yield what its caller saw, which statement was due, and how sure that was."""
    decision = call.decision
    if call.parent == ROOT:
        return
    if not decision.facts and not decision.statements and not decision.scripted:
        yield "The trace does not say what that rested on."
    yield from _seen(decision)
    yield from _statements(decision.statements, _of(trace, trace.calls[call.parent].name))
    if decision.scripted:
        yield "A function in Python decided."
    if decision.answer is not None:
        step = Option(decision.answer.callee, decision.answer.arguments, decision.probability or 0.0)
        yield f"Asked in a replay, the policy would {format_option(step)}{_percent(decision)}."
    elif decision.probability is not None:
        others = enumerated([*_others(call, decision)])
        yield f"The decision was {decision.probability:.0%} probable{f' ({others})' * bool(others)}."
    if decision.asked is not None:
        yield f"Somebody was asked: {format_asked(decision.asked)}."


def _percent(decision: Decision) -> str:
    return "" if decision.probability is None else f" ({decision.probability:.0%})"


def _others(call: Call, decision: Decision) -> Iterator[str]:
    """Yield what was decided against: other callees, other arguments, and to return."""
    for each in decision.callees:
        if each.value != call.name and each.probability >= LEAST:
            yield f"{each.value} {each.probability:.0%}"
    given = without_lists(call.arguments)
    for ranking, own in zip(decision.arguments, given, strict=False):
        for other in ranking:
            if other.value != own and other.probability >= LEAST:
                yield f"{other.value} for {own} {other.probability:.0%}"
    if decision.end_probability is not None and decision.end_probability >= LEAST:
        yield f"to return {decision.end_probability:.0%}"


def _seen(decision: Decision) -> Iterator[str]:
    lacking = [each for each in decision.facts if each.probability <= 0.5]
    unwanted = [each for each in lacking if _is_negated(each.fact)]
    if absent := [each for each in lacking if each not in unwanted][:MOST]:
        yield f"It was seen that {_facts(absent)} did not hold."
    if unwanted:
        those = [
            with_fields(each, fact=each.fact.removeprefix(NOT), probability=1 - each.probability)
            for each in unwanted[:MOST]
        ]
        yield f"It was seen that {_facts(those)} held."
    doubtful = [each for each in decision.facts if 0.5 < each.probability < SURE][:MOST]
    if doubtful:
        yield f"Uncertain: {_facts(doubtful)}."
    wrong = decision.mistaken
    surely = [each for each in wrong if each.probability >= SURE][:MOST]
    if surely:
        yield f"It was seen that {_facts(surely)} held."
    for each in wrong[:MOST]:
        why = "forced" if each.forced else "wrong"
        yield f"That was {why}: {each.fact} {'held' if each.truth else 'did not hold'} in truth."


def _is_negated(fact: str) -> bool:
    """Return whether a fact is the negation of one literal, and no longer condition."""
    return fact.startswith(NOT) and fact.endswith(")") and fact.count("(") == 1


def _facts(facts: Sequence[FactProbability]) -> str:
    return enumerated(
        [
            f"{each.fact} ({each.probability:.0%})" if LEAST <= each.probability < SURE else each.fact
            for each in facts
        ]
    )


def _statements(statements: Sequence[StatementStatus], quoted: Quoted) -> Iterator[str]:
    """Yield what became of each statement of a program: those that were due first."""
    for status, words in (
        (Status.DUE, "Due"),
        (Status.VAIN, "Would do nothing"),
        (Status.PASSED, "Passed over, as nothing that is needed comes of it"),
        (Status.ACHIEVED, "Done already"),
        (Status.ABSENT, "Left out, as its condition does not hold, or holds of nothing"),
    ):
        those = [each for each in statements if each.status is status]
        if those:
            named = [_named(each, quoted) for each in those[:MOST]]
            more = [f"{len(those) - MOST} more"] if len(those) > MOST else []
            yield f"{words}: {'; '.join([*named, *more])}."


def _named(each: StatementStatus, quoted: Quoted) -> str:
    text = f"line {each.line}"
    if each.callee:
        text += f" {format_invocation(each.callee, each.arguments)}"
    elif written := quoted(each.line):
        text += f" {written}"
    if each.why:
        return f"{text} ({each.why})"
    if each.status is Status.DUE and each.lacks:
        text += f", which lacked {enumerated(each.lacks[:MOST])}"
    return text


def _of(trace: Trace, program: str) -> Quoted:
    """Return what quotes a program's statements from the source that a trace carries."""
    from ntp_dsl.traces.library_text import statement_text  # the parser, which few explanations need

    return partial(statement_text, trace, program)


def _unquoted(line: int) -> str:
    return ""


def _reading(trace: Trace, call: Call) -> Iterator[str]:
    """Yield what a program read of its part of the demonstration."""
    for caller, read in trace.readings():
        if caller.id != call.id:
            continue
        for each in read.lists:
            elements = f"[{', '.join(map(format_argument, each.elements))}]"
            yield f"From {format_scope(call.scope)} it read {each.parameter} = {elements}."
        yield f"That explains {read.explained} of {counted(read.acts, 'act')} of the hand."
        for doubt in read.doubts:
            yield f"Uncertain: {format_doubt(doubt)}."


def _outcome(trace: Trace, call: Call) -> Iterator[str]:
    """Yield what came of a call, and what its failure is attributed to."""
    if call.outcome is None:
        yield f"{'The run was stopped' if trace.end is not None else 'The trace ends'} before it returned."
        return
    made = trace.children(call.id)
    after = f"After {counted(len(made), 'call')} it" if made else "It"
    cause = attribute_call(call)
    blamed = f", which is attributed to {cause}" if cause and not call.succeeded else ""
    yield f"{after} returned: {str(call.outcome).replace('_', ' ')}{blamed}."
    if call.execution.unmet:
        yield f"It reported success, but {enumerated(call.execution.unmet[:MOST])} did not hold."
    if where := aftermath(trace, call):
        yield f"Seen afterwards: {where}."
    if call.parent == ROOT and call.succeeded and trace.end is not None and trace.end.success is False:
        if where := at_the_end(trace, call, trace.end.verdict):
            yield f"At its end: {where}."
    failed = [each for each in made if not each.succeeded]
    if failed:
        texts = [f"call {each.id}, {format_call(each)}" for each in failed[:MOST]]
        yield f"Of its calls, {enumerated(texts)} did not succeed."
    for name, value in list(call.execution.evidence.items())[:MOST]:
        yield f"{format_measurement(name, value)[:LONG]}."
    if call.execution.disturbances:
        yield f"Disturbed by {enumerated(call.execution.disturbances)}."
    returned = call.return_decision
    if returned is not None:
        if returned.probability is not None and returned.answer is None:
            yield f"To return was {returned.probability:.0%} probable."
        if returned.reason:
            yield f"Its reason: {returned.reason}."
        if made and not call.succeeded and not returned.statements:
            yield from _skipped(trace, call, made[-1])
        yield from _seen(returned)
        yield from _statements(returned.statements, _of(trace, call.name))
        yield from _against_the_rule(trace, call, returned)
        if returned.asked is not None:
            yield f"Somebody was asked: {format_asked(returned.asked)}."


def _against_the_rule(trace: Trace, call: Call, returned: Decision) -> Iterator[str]:
    """Yield that a learned policy returned although a call was due that had never failed."""
    if returned.probability is None or call.succeeded or trace.header.dispatch is Dispatch.RULE:
        return
    failed = {(each.name, each.arguments) for each in trace.calls if not each.succeeded}
    due = [each for each in returned.statements if each.status is Status.DUE and not each.lacks]
    if due and all((each.callee, each.arguments) not in failed for each in due):
        yield (
            f"By the declaration it would have called {format_invocation(due[0].callee, due[0].arguments)}: "
            "the network decided otherwise. Where `--dispatch rule` succeeds, the model does not fit."
        )


def _skipped(trace: Trace, call: Call, last: Call) -> Iterator[str]:
    """Yield which statements a program had skipped when it made its last call."""
    skipped = [each for each in last.decision.statements if each.status in (Status.ABSENT, Status.PASSED)]
    if skipped:
        told = " ".join(_statements(skipped, _of(trace, call.name)))
        yield f"When it made its last call, {format_call(last)}: {told}"
