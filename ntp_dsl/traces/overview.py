"""How an episode ended, in plain words: its verdict, and what its calls and decisions have in common."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from ntp_dsl.common.text import counted, printable
from ntp_dsl.semantics.observation import Argument, Record
from ntp_dsl.traces.aftermath import crowding, never_made_good, objects_of, seen_after, stands
from ntp_dsl.traces.circles import Circle, circle
from ntp_dsl.traces.comparison.comparison_rules import NUMBER_TOLERANCE
from ntp_dsl.traces.library_text import empty_loops, in_python
from ntp_dsl.traces.phrases import conditions, format_argument, format_call, format_invocation
from ntp_dsl.traces.schema import ROOT, Call
from ntp_dsl.traces.trace import Trace
from ntp_dsl.worlds.protocol import UNDISTURBED

OFTEN, SHARE = 5, 0.25  # times that a call is made, and of all primitives, for it to be told
FEW = 3  # elements that a sentence names


def overview(trace: Trace) -> list[str]:
    """Return how an episode ended, as sentences."""
    sentences = [
        _verdict(trace),
        *(_round(trace, found) if (found := circle(trace)) else [*_repeated(trace), *_in_vain(trace)]),
        *_unmet(trace),
        *_absent(trace),
        *_disturbed(trace),
        *_misled(trace),
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


def _round(trace: Trace, found: Circle) -> Iterator[str]:
    """Yield what a run went round in, and what of it is of no avail."""
    calls = ", ".join(f"{format_call(call)}{_at(call)}" for call in found.calls)
    yield f"{format_call(found.caller)} went round {counted(found.rounds, 'time')}: {calls}."
    if found.failing:
        for call in found.failing[:FEW]:
            unmet = f", but not {call.execution.unmet[0]}" if call.execution.unmet else ""
            told = f"{call.outcome}{unmet}{_in_python(trace, call)}"
            yield f"In the last round {format_call(call)} returned: {told}."
        return
    if (undone := found.undone()) is not None:
        fact, achiever, ender = undone
        yield (
            f"{format_call(achiever)}{_at(achiever)} achieves {fact}, and {format_call(ender)}{_at(ender)} "
            "ends that again."
        )
    if (starving := found.starving()) is not None:
        statement, lacks = starving
        starved = format_invocation(statement.callee, statement.arguments)
        lacking = " and ".join(lacks[:FEW])
        yield f"Throughout, line {statement.line}, {starved}, is needed and lacks {lacking}."


def _in_python(trace: Trace, call: Call) -> str:
    """Return that a fact which a call left undone is told by Python, where that is so."""
    facts = call.return_decision.facts if call.return_decision is not None else ()
    for each in facts:
        if each.truth is False and in_python(trace, each.fact.partition("(")[0]):
            return f"; whether {each.fact} holds is told by a function in Python"
    return ""


def _at(call: Call) -> str:
    return f" at {call.decision.source}" if call.decision.source else ""


def _repeated(trace: Trace) -> Iterator[str]:
    """Yield the call that was made again and again, if there is one."""
    calls = _primitives(trace)
    for text, count in Counter(format_call(call) for call in calls if call.arguments).most_common(1):
        if count >= OFTEN and count >= SHARE * len(calls):
            yield f"{count} of its {len(calls)} primitives were {text}."


def _in_vain(trace: Trace) -> Iterator[str]:
    """Yield the program that was called again and again and never succeeded, if there is one."""
    programs = [call for call in trace.calls if call.is_program and call.parent != ROOT]
    done = {format_call(call) for call in programs if call.succeeded}
    tried = Counter(text for call in programs if (text := format_call(call)) not in done)
    for text, count in tried.most_common(1):
        if count >= OFTEN:
            last = [call for call in programs if format_call(call) == text][-1]
            left = f"; after the last time {standing}" if (standing := _standing_after(trace, last)) else ""
            yield f"{text} was called {count} times and never done{left}."


def _standing_after(trace: Trace, call: Call) -> str:
    """Return what the first object of a call stands on after it; empty where that cannot be seen."""
    seen = seen_after(trace, call)
    names = objects_of(call, seen) if seen is not None else []
    return stands(seen, names[0]) if seen is not None and names else ""


def _unmet(trace: Trace) -> Iterator[str]:
    """Yield the primitives that reported success without what they are to achieve."""
    reported = [call for call in _primitives(trace) if call.succeeded]
    broken = [call for call in reported if call.execution.unmet]
    noise = (trace.header.disturbances or UNDISTURBED).noise
    noisy = f"the noise of {1000 * noise:g} mm is too much for it, or " if noise else ""
    for name, count in Counter(call.name for call in broken).most_common(FEW):
        said = counted(sum(call.name == name for call in reported), "time")
        those = [call for call in broken if call.name == name]
        place, _ = Counter(call.decision.source for call in those).most_common(1)[0]
        yield (
            f"{name} reported success {said}, and what it is to achieve did not hold after {count} of them, "
            f"such as {those[0].execution.unmet[0]}{f' (called at {place})' * bool(place)}: {noisy}the "
            "skill, the predicate or a number that it was given is wrong, or something is in the way."
        )
        yield from _crowded(trace, those)


def _crowded(trace: Trace, broken: Sequence[Call]) -> Iterator[str]:
    """Yield what stands right beside what was put down in vain, if that is so more often than not."""
    beside = Counter(found for call in broken if (found := crowding(trace, call)))
    if 2 * beside.total() > len(broken):
        those = ", ".join(f"{name} ({count})" for name, count in beside.most_common(FEW))
        yield (
            f"After {beside.total()} of these {len(broken)} another object stood right beside what was put "
            f"down: {those}. It may be in the way."
        )


def _absent(trace: Trace) -> Iterator[str]:
    """Yield the loops of a failed episode that had no object to go through."""
    if trace.end is not None and trace.end.success is False:
        for type_name, program, line in empty_loops(trace):
            yield f"No object of the scene is a {type_name}, so that line {line} of {program} calls nothing."


def _disturbed(trace: Trace) -> Iterator[str]:
    """Yield how often it was disturbed, by what, and how often that was not made good."""
    disturbed = [call for call in trace.calls if call.execution.disturbances]
    kinds = Counter(each for call in disturbed for each in call.execution.disturbances)
    if not kinds:
        return
    if len(kinds) == 1:
        ways = f" by {printable(next(iter(kinds)))}"
    else:
        most = (f"{printable(name)} ({count})" for name, count in kinds.most_common(FEW))
        ways = f", most often by {', '.join(most)}"
    lost = {call.id for call in never_made_good(trace)}
    left = sum(call.id in lost for call in disturbed)
    good = ""
    if left and not (trace.end and trace.end.success):
        were = "was" if left == 1 else "were"
        good = f"; {left} of the {counted(len(disturbed), 'call')} {were} never made good"
    yield f"It was disturbed {counted(kinds.total(), 'time')}{ways}{good}."


def _misled(trace: Trace) -> Iterator[str]:
    """Yield what a failed episode knew nothing of: it may be the cause of all that went wrong."""
    made = trace.header.disturbances or UNDISTURBED
    if trace.end is not None and trace.end.success is False:
        if made.camera_offset:
            yield (
                f"All objects were seen {1000 * made.camera_offset:g} mm from where they were, which neither "
                "program nor skills knew: that alone may have misled them."
            )
        if made.weak_grip:
            yield (
                f"The hand had {100 * (1 - made.weak_grip):g} % of its force: what it cannot hold, or loses, "
                "may be too heavy for that."
            )


def _mistaken(trace: Trace) -> Iterator[str]:
    """Yield how many decisions rest on a fact that was seen wrongly, or as it was forced to be seen."""
    decisions = [*trace.decisions()]
    for forced, how in ((True, "as it was forced to be seen"), (False, "seen wrongly")):
        wrong = [facts for each in decisions if (facts := [f for f in each.mistaken if f.forced is forced])]
        if wrong:
            kinds = Counter(f.fact if forced else f.fact.partition("(")[0] for facts in wrong for f in facts)
            most = " and ".join(f"'{name}' ({count})" for name, count in kinds.most_common(2))
            yield f"{len(wrong)} of {len(decisions)} decisions rest on a fact {how}, most often {most}."


def _misread(trace: Trace) -> Iterator[str]:
    """Yield where what was read from the demonstration is not the task's goal."""
    for call, read in trace.readings():
        if call.parent != ROOT:
            continue
        if read.explained < read.acts:
            fits = (
                ""
                if 2 * read.explained >= read.acts
                else ": the model or the demonstration does not fit the task"
            )
            yield f"What was read explains {read.explained} of {counted(read.acts, 'act')} of the hand{fits}."
        elements = [each for row in read.lists for each in row.elements]
        goal = trace.header.goal
        lacking = [each for each in goal if not any(_like(each, other) for other in elements)]
        if lacking:
            others = [each for each in elements if not any(_like(each, other) for other in goal)]
            instead = f"; {_few(others)} {_was(others)} read instead" if others else ""
            yield f"Of its goal, {_few(lacking)} {_was(lacking)} not read from the demonstration{instead}."
        return


def _was(elements: Sequence[Argument]) -> str:
    return "was" if len(elements) == 1 else "were"


def _few(elements: Sequence[Argument]) -> str:
    return ", ".join(map(format_argument, elements[:FEW]))


def _like(some: Argument, other: Argument) -> bool:
    """Return whether two elements are the same but for what numbers lose when they are read."""
    if isinstance(some, Record) and isinstance(other, Record):
        pairs = zip(some.fields, other.fields, strict=False)
        return some.type == other.type and all(_like(a, b) for (_, a), (_, b) in pairs)
    if isinstance(some, float) and isinstance(other, float):
        return abs(some - other) <= NUMBER_TOLERANCE
    return some == other
