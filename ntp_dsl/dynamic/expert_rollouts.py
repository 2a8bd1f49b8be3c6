"""Whether experts arrive: every task, and every program as a root, from all kinds of starts."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ntp_dsl.dynamic.deadlock import Standstill
from ntp_dsl.dynamic.starts import STARTS, told
from ntp_dsl.dynamic.watching import Impure, Livelock, WatchedPolicy, source_lines
from ntp_dsl.execution.interpreter import Interpreter, Limits, Run
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Note
from ntp_dsl.language.registry import Program, Registry
from ntp_dsl.language.syntax.nodes import Span, TaskDeclaration
from ntp_dsl.policies.expert import Decision, Expert, NextCall
from ntp_dsl.policies.random_arguments import random_arguments
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.state import Fact, Literal, State
from ntp_dsl.semantics.value_checks import OutOfRange
from ntp_dsl.tasks.instances import Instance, draw, enough_primitives
from ntp_dsl.traces.phrases import shown
from ntp_dsl.worlds.protocol import World

USUAL, CROWD = 16, 60  # objects of a scene: up to which all trials are made, and from which one
PROGRAM_TRIES = 6  # of every program as a root


@dataclass
class Trial:
    """A run of a task's expert, what success still lacks at its end, and how the world refused."""

    start: str
    run: Run
    lacking: list[Fact]
    seed: int
    scene: str  # what it started from
    goal: str


class Rehearsal:
    """Tries the experts of one registry in one world."""

    def __init__(self, registry: Registry, world: World, seed: int) -> None:
        self.registry, self.world, self.seed = registry, world, seed
        self.expert = Expert(registry)

    # Tasks --------------------------------------------------------------------------------------

    def check_task(self, task: TaskDeclaration) -> Iterator[Diagnostic]:
        """What is wrong with the task or its expert; the first livelock or impurity ends it."""
        trials: list[Trial] = []
        shown: list[bool] = []  # for each nominal start, whether anything is left to be done
        untold: set[str] = set()  # what of the goals holds before anything is done
        objects = len(self._instance(task, 0)[0].objects)
        for start, (_, count) in STARTS.items():
            for number in range(_affordable(count, start, objects)):
                try:
                    trials.append(self._trial(task, start, number, untold, shown))
                except Livelock as livelock:
                    yield _livelock(livelock, self.registry.apis, task.name, start, task.name_span)
                    return
                except Impure as impure:
                    yield _impure(impure, self.registry)
                    return
        yield from _judged(task, trials)
        if shown and not any(shown):
            message = f"the goal of '{task.name}' holds before anything is done: nothing can be shown"
            yield Diagnostic("E602", message, _success_span(task))
        elif untold:
            told = ", ".join(sorted(untold)[:3])
            message = f"part of the goal of '{task.name}' holds before anything is done: {told}"
            help = "a demonstration shows only what is not so from the start"
            yield Diagnostic("W602", message, _success_span(task), (), help)
        elif not any(trial.lacking for trial in trials if trial.start == "nominal"):
            yield from self._check_broken(task, trials)

    def _instance(self, task: TaskDeclaration, number: int) -> tuple[Instance, np.random.Generator]:
        rng = np.random.default_rng((self.seed, number))
        return draw(self.registry, task, rng), rng

    def _trial(
        self,
        task: TaskDeclaration,
        start: str,
        number: int,
        untold: set[str],
        shown: list[bool],
        limit: int | None = None,
    ) -> Trial:
        instance, rng = self._instance(task, number)
        self.world.reset(STARTS[start][0](instance, rng), number)
        scene = told(self.world.truth())
        if start == "nominal":
            lacking = self._lacking(instance)
            shown.append(bool(lacking))
            untold |= {
                str(fact)
                for fact in self._facts(instance)
                if fact not in lacking and _is_of_an_element(fact, instance)
            }
        policy = WatchedPolicy(self.expert)
        limits = Limits(primitives=limit or enough_primitives(instance), retries=1)
        interpreter = Interpreter(self.registry, policy, self.world, limits=limits, watch=policy.watch)
        run = interpreter.run(instance.program, instance.arguments)
        goal = ", ".join(map(str, instance.goal))
        return Trial(start, run, self._lacking(instance), number, scene, goal)

    def _facts(self, instance: Instance) -> list[Fact]:
        return instance.literals(self.registry, self.world.truth())

    def _lacking(self, instance: Instance) -> list[Fact]:
        state = State(self.registry, self.world.truth())
        return [fact for fact in self._facts(instance) if not state.holds(fact)]

    def _check_broken(self, task: TaskDeclaration, trials: Sequence[Trial]) -> Iterator[Diagnostic]:
        """A success test that an expert passes who stops half-way asks for too little."""
        tidy = [trial for trial in trials if trial.start == "nominal" and trial.run.primitives > 1]
        halves = [
            self._trial(task, "nominal", trial.seed, set(), [], trial.run.primitives // 2) for trial in tidy
        ]
        if halves and not any(trial.lacking for trial in halves):
            message = f"'{task.name}' counts as done when its expert has only come half-way"
            help = f"ask in 'success' for all that '{task.run.callee if task.run else '?'}' achieves"
            yield Diagnostic("E604", message, _success_span(task), (), help)

    # Programs -----------------------------------------------------------------------------------

    def check_program(self, program: Program, instances: Sequence[Instance]) -> Iterator[Diagnostic]:
        """As a root, with arguments at random: it comes to an end."""
        reasons: list[str] = []
        livelocks: list[Livelock] = []
        for number in range(PROGRAM_TRIES):
            rng = np.random.default_rng((self.seed, 1, number))
            instance = instances[number % len(instances)]
            self.world.reset(instance.perturbed_start(rng, straight=1.0), number)
            state = State(self.registry, self.world.truth())
            arguments = random_arguments(program.parameters, state, rng)
            if arguments is None:
                return
            policy = WatchedPolicy(self.expert)
            limits = Limits(primitives=enough_primitives(instance), retries=1)
            try:
                run = Interpreter(self.registry, policy, self.world, limits=limits, watch=policy.watch).run(
                    program.name, arguments
                )
            except Livelock as livelock:
                livelocks.append(livelock)
                continue
            except Impure as impure:
                yield _impure(impure, self.registry)
                return
            except OutOfRange:  # of a number at random, which the program need not take
                continue
            scope = dict(zip((p.name for p in program.parameters), arguments, strict=True))
            able = all(state.holds(fact) for fact in state.literals(program.requires, scope))
            if able and not run.done:
                reasons.append(run.reason)
            elif able:
                return
        if len(livelocks) > 1:
            yield _livelock(livelocks[0], self.registry.apis, program.name, "perturbed", program.span, "W604")
        elif len(reasons) > 1:
            tried = f"{len(reasons)} perturbed states"
            message = f"'{program.name}' did not achieve its contract in any of {tried}"
            note = Note(f"the last one ended so: {reasons[-1]}", program.span)
            yield Diagnostic("W605", message, program.span, (note,))


def _affordable(count: int, start: str, objects: int) -> int:
    """Fewer trials of scenes with many objects, which take the longer."""
    if objects > CROWD:
        return int(start == "perturbed")
    return max(1, round(count * min(1.0, (USUAL / objects) ** 2)))


def _is_of_an_element(fact: Fact, instance: Instance) -> bool:
    """Whether a fact says of the objects of one element of the goal how they stand to each other."""
    if not isinstance(fact, Literal):
        return False
    rows = [{value for _, value in row.fields} for row in instance.goal]
    return any(len(row & set(fact.arguments)) >= min(2, len(row)) for row in rows)


def _judged(task: TaskDeclaration, trials: Sequence[Trial]) -> Iterator[Diagnostic]:
    """The kinds of starts from which the goal is not reached; of a lost object only an end is asked."""
    failed = [trial for trial in trials if trial.lacking and trial.start != "lost"]
    if not failed:
        return
    tried = sum(trial.start != "lost" for trial in trials)
    refused = all(trial.run.failures and not trial.run.reason.startswith("unfinished") for trial in failed)
    kinds = ", ".join(dict.fromkeys(trial.start for trial in failed))
    example = failed[0]
    notes = [Note(f"{example.lacking[0]} does not hold in the end; the run ended so: {example.run.reason}")]
    notes.append(Note(f"it began ({example.start}) with {example.scene}; the goal was {example.goal}"))
    assert task.run is not None
    message = f"the expert of '{task.name}' did not reach its goal from {len(failed)} of {tried} starts"
    message += f" ({kinds})"
    yield Diagnostic("W603" if refused else "E603", message, task.run.span, tuple(notes))


def _livelock(
    livelock: Livelock, apis: Container[str], name: str, start: str, home: Span, code: str = "E605"
) -> Diagnostic:
    lines = source_lines(livelock.cycle)
    # The circle has no beginning: it is told from the library at hand on, not from one that it uses.
    first = next((n for n, (_, place) in enumerate(lines) if place.path == home.path), 0)
    lines = lines[first:] + lines[:first]
    call, span = lines[0]
    message = f"'{name}' goes round in a circle ({start} start): the same state comes again and again"
    notes = [
        Note(f"{number}. {each.callee}({_given(each.arguments)})", place)
        for number, (each, place) in enumerate(lines, start=1)
    ]
    if livelock.refused:
        return _refused(livelock, name, start, span)
    if livelock.still and not any(each.callee in apis for each in livelock.cycle):
        return _stands(livelock.still[0], name, start, span, code)
    notes.append(Note(f"{len(lines) + 1}. {call.callee}({_given(call.arguments)}) again, and so on"))
    for program, arguments, reason in dict.fromkeys(livelock.gave_up):
        notes.append(Note(f"{program}({_given(arguments)}) returns unfinished: {reason}"))
    help = "what one statement achieves another undoes: require it, or order them otherwise"
    return Diagnostic(code, message, span, tuple(notes), help)


def _stands(still: Standstill, name: str, start: str, span: Span, code: str) -> Diagnostic:
    """Not undone by anything: nothing is done, since in some program no statement is due."""
    call = f"{still.program}({_given(still.arguments)})"
    lacks = ", ".join(map(str, still.lacks[:3]))
    message = f"'{name}' comes no further ({start} start): {call} lacks {lacks}, and no statement is due"
    notes = [
        Note(f"{number}. passed over: {reason}", statement.span)
        for number, (statement, reason) in enumerate(still.passed_over, start=1)
    ]
    help = f"give '{still.program}' a statement that achieves it, or let it require what it cannot achieve"
    return Diagnostic(code, message, span, tuple(notes), help)


def _refused(livelock: Livelock, name: str, start: str, span: Span) -> Diagnostic:
    """Round in a circle since the world does not do what it is asked: not by the expert's fault, perhaps."""
    said = dict.fromkeys(f"{api}({_given(arguments)}): {why}" for api, arguments, why in livelock.refused)
    message = f"'{name}' comes no further ({start} start): the world refuses {next(iter(said))}"
    help = "leave more room: fewer or smaller objects, or wider regions; or call something else then"
    return Diagnostic("W603", message, span, (), help)


def _given(arguments: Sequence[Argument]) -> str:
    return ", ".join("..." if isinstance(each, tuple) else shown(each) for each in arguments)


def _impure(impure: Impure, registry: Registry) -> Diagnostic:
    row = registry.programs[impure.program]
    told = [_answer(each) for each in impure.answers]
    message = f"the expert of '{row.name}' is no function of the state: {impure.how}, it says "
    message += f"{told[1]}, not {told[0]}"
    help = "decide by the arguments and the predicates alone; sort what has no order of its own"
    return Diagnostic("E606", message, row.span, (), help)


def _answer(answer: Decision) -> str:
    if isinstance(answer, NextCall):
        return f"{answer.callee}({_given(answer.arguments)})"
    return "done" if answer.done else "unfinished"


def _success_span(task: TaskDeclaration) -> Span:
    assert task.success is not None
    return task.success.span
