"""From trials to diagnostics: what went wrong, in which state, and what each statement lacked there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from ntp_dsl.common.text import counted, listed
from ntp_dsl.dynamic.places import Places
from ntp_dsl.dynamic.starts import places_text, scene_text, state_text
from ntp_dsl.dynamic.starving import Starving, starving
from ntp_dsl.dynamic.steps import Undoing, undoing
from ntp_dsl.dynamic.stuck import FEW, MOST, SKIPPED, Stuck, given, stuck
from ntp_dsl.dynamic.trials import Trial
from ntp_dsl.dynamic.watching import Livelock, NondeterministicExpert, Unfinished, source_lines
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Note
from ntp_dsl.language.diagnostics.rendering import shown_path
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax.nodes import Span
from ntp_dsl.policies.expert import Decision, NextCall
from ntp_dsl.semantics.facts import Fact, Literal
from ntp_dsl.semantics.observation import without_lists
from ntp_dsl.semantics.shortfalls import why_not
from ntp_dsl.semantics.state import State

STEPS = 8  # of a cycle that are listed


@dataclass(frozen=True)
class Finding:
    """A trial that shows a mistake of a task or program.

    Args:
        home: the place of the task's run, or of the program.
        file: of its trace, if that is kept.
    """

    name: str
    trial: Trial
    home: Span
    places: Places
    file: Path | None = None

    def livelock(self, livelock: Livelock, code: str = "E605") -> Diagnostic:
        """Return the diagnostic of calls that recur, or of the deadlock or the refused calls among them."""
        apis = self._registry.apis
        if livelock.refused:
            return self._refused(livelock)
        if livelock.deadlocks and not any(each.callee in apis for each in livelock.cycle):
            return self.deadlock(livelock.deadlocks[0], code)
        # A cycle has no beginning: it is listed from a statement that the user can change.
        lines = source_lines(livelock.cycle)
        first = next((n for n, (_, place) in enumerate(lines) if self.places.is_own(place)), 0)
        lines = lines[first:] + lines[:first]
        notes = list(_steps(lines, self._registry))
        unfinished = list({each.what: each for each in livelock.unfinished}.values())
        for ended in unfinished[:FEW]:
            notes += self._unfinished(ended)
        starved = None if unfinished else starving(self.trial.expert, livelock.steps[-len(livelock.cycle) :])
        if starved is not None:
            notes.append(Note(str(starved), starved.call.span))
        undone = None if unfinished or starved else undoing(self._registry, livelock.steps)
        if undone is not None:
            notes.append(Note(str(undone)))
        told = {note.span for note in notes if note.span.line}
        notes += [note for note in self._stuck(self.trial.end) if note.span not in told]
        message = f"'{self.name}' is in a livelock ({self.trial.start} start): the same states recur"
        help = f"{_advice(unfinished, starved, undone)}; or the goals contradict each other"
        return Diagnostic(code, message, self._cause(livelock), (*notes, *self._trace), help)

    def _unfinished(self, found: Unfinished) -> Iterator[Note]:
        """Yield why a program returned unfinished, and which statements it skipped at its last call."""
        program, arguments = found.frame.program, found.frame.arguments
        yield Note(f"{program}({given(arguments)}) returns unfinished: {found.reason}")
        state = State(self._registry, found.seen)
        end = stuck(self.trial.expert, program, arguments, state)
        for fact in end.unmet[:1]:
            told = f"; {name} is told by a function in Python" if (name := self._in_python(fact)) else ""
            yield Note(f"then {why_not(fact, state)}: {places_text(found.seen, sorted(fact.names))}{told}")
        if found.last is None:
            return
        before = stuck(self.trial.expert, program, arguments, State(self._registry, found.last.seen))
        for span, reason in before.reasons:
            if reason.startswith(SKIPPED):
                yield Note(reason, span)

    def _in_python(self, fact: Fact) -> str:
        """Return the name of a fact's predicate where that is in Python, or else nothing."""
        if isinstance(fact, Literal) and ("predicate", fact.predicate) in self._registry.python.functions:
            return fact.predicate
        return ""

    def deadlock(self, deadlock: Stuck, code: str = "E605") -> Diagnostic:
        """Return the diagnostic of a program that has not achieved its contract, but has nothing to do."""
        program, start = deadlock.program, self.trial.start
        way = (*deadlock.way, program.span)
        message = f"'{self.name}' is in a deadlock ({start} start): {deadlock.call} has not achieved "
        message += f"{listed(deadlock.unmet, MOST)}, but no statement is due"
        help = f"give '{program.name}' a statement that achieves it, or let it require what it cannot achieve"
        if not self.places.is_own(program.span):
            help = f"call '{program.name}' only where it can achieve it, or do so before"
        notes = (*self._stuck(deadlock), *self._trace)
        return Diagnostic(code, message, self.places.innermost(way, self.home), notes, help)

    def unreached(self, failed: Sequence[Trial], tried: int) -> Diagnostic:
        """Return the diagnostic of a goal that is not reached, shown by this trial."""
        trial = self.trial
        kinds = ", ".join(dict.fromkeys(each.start for each in failed))
        goal = trial.instance.goal
        wanted = f"; the goal was {listed(goal, MOST)}" if goal else ""
        message = f"the expert of '{self.name}' did not reach its goal from {len(failed)} of {tried} starts "
        message += f"({kinds})"
        notes = (
            Note(f"it started ({trial.start}) with {scene_text(trial.first)}{wanted}"),
            Note(f"it ended ({trial.run}), and {trial.lacking}"),
            *self._stuck(trial.end, trial.unmet),
            *self._trace,
        )
        fails_always = len(failed) == tried  # then it is no start's fault
        if not fails_always and all(each.run.failures and not each.run.gave_up for each in failed):
            named = [name for each in trial.policy.refused for name in each[1][1]]
            return Diagnostic("W603", message, self.places.scene(trial.instance, named), notes)
        return Diagnostic("E603", message, self.home, notes)

    def unkept(self, tried: int) -> Diagnostic:
        """Return the warning of a program that never achieves its contract, shown by this trial."""
        message = f"'{self.name}' did not achieve its contract in any of {tried} perturbed states"
        last = Note(f"the last run ended: {self.trial.run}", self.home)
        return Diagnostic("W605", message, self.home, (last, *self._stuck(self.trial.end), *self._trace))

    def nondeterministic(self, error: NondeterministicExpert) -> Diagnostic:
        """Return the diagnostic of an expert in Python that is not a function of the state."""
        row = self._registry.programs[error.program]
        answers = [_answer(each) for each in error.answers]
        message = f"the expert of '{row.name}' is not a function of the state: {error.how}, it decides "
        message += f"{answers[1]}, not {answers[0]}"
        help = "decide by the arguments and the predicates alone; sort what has no order"
        return Diagnostic("E606", message, row.span, self._trace, help)

    @property
    def _registry(self) -> Registry:
        return self.trial.expert.registry

    @property
    def _trace(self) -> tuple[Note, ...]:
        return (Note(f"its trace: {shown_path(self.file)}"),) if self.file is not None else ()

    def _cause(self, livelock: Livelock) -> Span:
        """Return the first own statement of a cycle, or else the one from which all of it is called."""
        cycle = (call.span for call in livelock.cycle)
        return next(filter(self.places.is_own, cycle), self.places.innermost(livelock.way, self.home))

    def _refused(self, livelock: Livelock) -> Diagnostic:
        """Return the warning of a livelock that is due to failing calls, perhaps not the expert's fault."""
        api, arguments, why = livelock.refused[0]
        place = self.places.scene(self.trial.instance, without_lists(arguments))
        message = f"'{self.name}' makes no progress ({self.trial.start} start): the world refuses "
        message += f"{api}({given(arguments)}): {why}"
        help = "leave more room: fewer or smaller objects, or larger regions; or call something else then"
        state = Note(f"at that moment: {state_text(self.trial.last, map(str, without_lists(arguments)))}")
        return Diagnostic(
            "W603",
            message,
            place,
            (Note("called from here", self._cause(livelock)), state, *self._trace),
            help,
        )

    def _stuck(self, found: Stuck, facts: Sequence[Fact] = ()) -> Iterator[Note]:
        """Yield what a call's state is, what it needs, and what each of its statements lacks.

        Args:
            facts: others that do not hold, whose objects matter.
        """
        needed = [*found.unmet, *found.lacks, *facts]
        instances = [each.instance for each in found.statements if each.instance is not None]
        lacks = [fact for each in instances for fact in sorted(each.lacks, key=str)]
        names = dict.fromkeys(name for fact in [*needed, *lacks] for name in sorted(fact.names))
        yield Note(f"at that moment: {state_text(found.state.observation, names)}")
        if not found.unmet:
            yield Note(f"{found.call} has achieved its contract, and success asks for more")
        elif found.lacks:
            yield Note(f"{found.call} requires {listed(found.lacks, MOST)}, which does not hold")
        elif not found.is_deadlock:
            yield Note(f"{found.call} still needs {listed(found.unmet, MOST)}")
        if found.unmet and found.program.in_python:
            yield Note(f"a function in Python decides for {found.call}")
        reasons = found.reasons
        yield from (Note(reason, span) for span, reason in reasons[:MOST])
        if len(reasons) > MOST:
            yield Note(f"and {counted(len(reasons) - MOST, 'more statement')}")


def _advice(unfinished: Sequence[Unfinished], starved: Starving | None, undone: Undoing | None) -> str:
    """Return what to do about a livelock, as the beginning of a sentence."""
    if starved is not None:
        fact, callee = starved.lacks[0], starved.call.callee
        return (
            f"write a statement before '{callee}' that provides {fact}, see why the one that does is "
            "skipped, or let the task begin with it"
        )
    if unfinished:
        name = unfinished[0].frame.program
        return (
            f"'{name}' ends without what it achieves: a statement is missing, or is skipped and should not "
            "be; or an api, or a predicate, does not do what it says"
        )
    if undone is not None and undone.is_in_order:
        first, second = undone.achieved_by.callee, undone.ended_by.callee
        if first == second:
            return f"a call of '{first}' ends what another achieves: see whether their arguments are meant"
        return (
            f"'{second}' ends what '{first}' achieves: see whether its arguments are meant, and whether it "
            f"brings about what is needed then; or let '{second}' require that, so that '{first}' is due "
            "only until then"
        )
    return (
        "one of these calls undoes what another achieves: write it before that one, or under a 'when'; "
        "or an api does not bring about what is asked for"
    )


def _steps(lines: Sequence[tuple[NextCall, Span]], registry: Registry) -> Iterator[Note]:
    """Yield the calls of a cycle; of a long one the first of its programs."""
    steps = [each for each in lines if len(lines) <= STEPS or each[0].callee in registry.programs] or lines
    for number, (call, place) in enumerate(steps[:STEPS], start=1):
        yield Note(f"{number}. {call.callee}({given(call.arguments)})", place)
    more = f"{len(steps) - STEPS} more, then " if len(steps) > STEPS else ""
    call = steps[0][0]
    number = min(len(steps), STEPS) + 1
    yield Note(f"{number}. {more}{call.callee}({given(call.arguments)}) again, and so on")


def _answer(answer: Decision) -> str:
    if isinstance(answer, NextCall):
        return f"{answer.callee}({given(answer.arguments)})"
    return "done" if answer.done else "unfinished"
