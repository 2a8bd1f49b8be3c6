"""Rollouts of experts: every task, and every program as the root, from all kinds of starts."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ntp_dsl.dynamic.deadlock import Deadlock
from ntp_dsl.dynamic.starts import STARTS, scene_text
from ntp_dsl.dynamic.watching import Livelock, NondeterministicExpert, WatchedPolicy, source_lines
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
from ntp_dsl.traces.phrases import format_argument
from ntp_dsl.worlds.protocol import World

MAX_OBJECTS_FOR_ALL_TRIALS, MIN_OBJECTS_FOR_ONE_TRIAL = 16, 60
PROGRAM_TRIALS = 6  # of every program as the root


@dataclass
class Trial:
    """A run of a task's expert, with the conditions of success that do not hold at its end."""

    start: str
    run: Run
    unmet: list[Fact]
    seed: int
    scene: str  # at the start
    goal: str
    deadlock: Deadlock | None = None  # in which it ended unfinished


class ExpertRollouts:
    """Tests the experts of one registry in one world."""

    def __init__(self, registry: Registry, world: World, seed: int) -> None:
        self.registry, self.world, self.seed = registry, world, seed
        self.expert = Expert(registry)

    # Tasks --------------------------------------------------------------------------------------

    def check_task(self, task: TaskDeclaration) -> Iterator[Diagnostic]:
        """Yield what is wrong with a task or its expert; a livelock or nondeterminism ends the test."""
        trials: list[Trial] = []
        initially_unmet: list[bool] = []  # for each nominal start, whether there is anything to do
        initial_facts: set[str] = set()  # parts of the goals that hold at the start
        objects = len(self._instance(task, 0)[0].objects)
        for start, (_, count) in STARTS.items():
            for number in range(_trial_count(count, start, objects)):
                try:
                    trials.append(self._trial(task, start, number, initial_facts, initially_unmet))
                except Livelock as livelock:
                    yield _livelock(livelock, self.registry.apis, task.name, start, task.name_span)
                    return
                except NondeterministicExpert as error:
                    yield _nondeterministic(error, self.registry)
                    return
        yield from _check_reached(self.registry, task, trials)
        if initially_unmet and not any(initially_unmet):
            message = f"the goal of '{task.name}' holds at the start: there is nothing to demonstrate"
            yield Diagnostic("E602", message, _success_span(task))
        elif initial_facts:
            facts = ", ".join(sorted(initial_facts)[:3])
            message = f"part of the goal of '{task.name}' holds at the start: {facts}"
            help = "a demonstration only shows what does not hold at the start"
            yield Diagnostic("W602", message, _success_span(task), (), help)
        elif not any(trial.unmet for trial in trials if trial.start == "nominal"):
            yield from self._check_half_way(task, trials)

    def _instance(self, task: TaskDeclaration, number: int) -> tuple[Instance, np.random.Generator]:
        rng = np.random.default_rng((self.seed, number))
        return draw(self.registry, task, rng), rng

    def _trial(
        self,
        task: TaskDeclaration,
        start: str,
        number: int,
        initial_facts: set[str],
        initially_unmet: list[bool],
        limit: int | None = None,
    ) -> Trial:
        instance, rng = self._instance(task, number)
        self.world.reset(STARTS[start][0](instance, rng), number)
        scene = scene_text(self.world.truth())
        if start == "nominal":
            unmet = self._unmet(instance)
            initially_unmet.append(bool(unmet))
            initial_facts |= {
                str(fact)
                for fact in self._facts(instance)
                if fact not in unmet and _is_of_an_element(fact, instance)
            }
        policy = WatchedPolicy(self.expert)
        limits = Limits(primitives=limit or enough_primitives(instance), retries=1)
        interpreter = Interpreter(self.registry, policy, self.world, limits=limits, watch=policy.watch)
        run = interpreter.run(instance.program, instance.arguments)
        goal = ", ".join(map(str, instance.goal))
        deadlock = policy.deadlocks[-1][1] if policy.deadlocks and run.gave_up else None
        return Trial(start, run, self._unmet(instance), number, scene, goal, deadlock)

    def _facts(self, instance: Instance) -> list[Fact]:
        return instance.literals(self.registry, self.world.truth())

    def _unmet(self, instance: Instance) -> list[Fact]:
        state = State(self.registry, self.world.truth())
        return [fact for fact in self._facts(instance) if not state.holds(fact)]

    def _check_half_way(self, task: TaskDeclaration, trials: Sequence[Trial]) -> Iterator[Diagnostic]:
        """Yield an error where success already holds after half of the expert's primitives."""
        completed = [trial for trial in trials if trial.start == "nominal" and trial.run.primitives > 1]
        halves = [
            self._trial(task, "nominal", trial.seed, set(), [], trial.run.primitives // 2)
            for trial in completed
        ]
        if halves and not any(trial.unmet for trial in halves):
            message = f"success of '{task.name}' holds although its expert was stopped half-way"
            help = f"require in 'success' all that '{task.run.callee if task.run else '?'}' achieves"
            yield Diagnostic("E604", message, _success_span(task), (), help)

    # Programs -----------------------------------------------------------------------------------

    def check_program(self, program: Program, instances: Sequence[Instance]) -> Iterator[Diagnostic]:
        """Yield where a program, as the root with random arguments, does not achieve its contract."""
        reasons: list[str] = []
        livelocks: list[Livelock] = []
        for number in range(PROGRAM_TRIALS):
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
            except NondeterministicExpert as error:
                yield _nondeterministic(error, self.registry)
                return
            except OutOfRange:  # of a random number, which the program need not accept
                continue
            scope = program.bind(arguments)
            is_ready = all(state.holds(fact) for fact in state.literals(program.requires, scope))
            if is_ready and not run.done:
                reasons.append(str(run))
            elif is_ready:
                return
        if len(livelocks) > 1:
            yield _livelock(livelocks[0], self.registry.apis, program.name, "perturbed", program.span, "W604")
        elif len(reasons) > 1:
            tried = f"{len(reasons)} perturbed states"
            message = f"'{program.name}' did not achieve its contract in any of {tried}"
            note = Note(f"the last run ended: {reasons[-1]}", program.span)
            yield Diagnostic("W605", message, program.span, (note,))


def _trial_count(count: int, start: str, objects: int) -> int:
    """Return the number of trials: fewer for scenes with many objects, which take longer."""
    if objects > MIN_OBJECTS_FOR_ONE_TRIAL:
        return int(start == "perturbed")
    return max(1, round(count * min(1.0, (MAX_OBJECTS_FOR_ALL_TRIALS / objects) ** 2)))


def _is_of_an_element(fact: Fact, instance: Instance) -> bool:
    """Whether a fact relates the objects of one element of the goal."""
    if not isinstance(fact, Literal):
        return False
    rows = [{value for _, value in row.fields} for row in instance.goal]
    return any(len(row & set(fact.arguments)) >= min(2, len(row)) for row in rows)


def _check_reached(
    registry: Registry, task: TaskDeclaration, trials: Sequence[Trial]
) -> Iterator[Diagnostic]:
    """Yield an error where the goal is not reached; with a missing object the run need only end."""
    failed = [trial for trial in trials if trial.unmet and trial.start != "missing object"]
    if not failed:
        return
    for trial in failed:
        if trial.deadlock is not None:
            span = registry.programs[trial.deadlock.program].span
            yield _deadlock(trial.deadlock, task.name, trial.start, span, "E605")
            return
    tried = sum(trial.start != "missing object" for trial in trials)
    refused = all(trial.run.failures and not trial.run.gave_up for trial in failed)
    kinds = ", ".join(dict.fromkeys(trial.start for trial in failed))
    example = failed[0]
    notes = [Note(f"{example.unmet[0]} does not hold at the end; the run ended: {example.run}")]
    notes.append(Note(f"it started ({example.start}) with {example.scene}; the goal was {example.goal}"))
    assert task.run is not None
    message = f"the expert of '{task.name}' did not reach its goal from {len(failed)} of {tried} starts"
    message += f" ({kinds})"
    yield Diagnostic("W603" if refused else "E603", message, task.run.span, tuple(notes))


def _livelock(
    livelock: Livelock, apis: Container[str], name: str, start: str, home: Span, code: str = "E605"
) -> Diagnostic:
    lines = source_lines(livelock.cycle)
    # A cycle has no beginning: it is listed from a statement of this library, not of one that it uses.
    first = next((n for n, (_, place) in enumerate(lines) if place.path == home.path), 0)
    lines = lines[first:] + lines[:first]
    call, span = lines[0]
    message = f"'{name}' is in a livelock ({start} start): the same states recur"
    notes = [
        Note(f"{number}. {each.callee}({_given(each.arguments)})", place)
        for number, (each, place) in enumerate(lines, start=1)
    ]
    if livelock.refused:
        return _refused(livelock, name, start, span)
    if livelock.deadlocks and not any(each.callee in apis for each in livelock.cycle):
        return _deadlock(livelock.deadlocks[0], name, start, span, code)
    notes.append(Note(f"{len(lines) + 1}. {call.callee}({_given(call.arguments)}) again, and so on"))
    for program, arguments, reason in dict.fromkeys(livelock.unfinished):
        notes.append(Note(f"{program}({_given(arguments)}) returns unfinished: {reason}"))
    help = "one of these calls undoes what another achieves: write it before that one, or under a 'when'"
    return Diagnostic(code, message, span, tuple(notes), help)


def _deadlock(deadlock: Deadlock, name: str, start: str, span: Span, code: str) -> Diagnostic:
    """Return the diagnostic of a livelock in which a program has no statement that is due."""
    call = f"{deadlock.program}({_given(deadlock.arguments)})"
    unmet = ", ".join(map(str, deadlock.unmet[:3]))
    message = (
        f"'{name}' is in a deadlock ({start} start): {call} has not achieved {unmet}, but no statement is due"
    )
    notes = [
        Note(f"{number}. skipped: {reason}", statement.span)
        for number, (statement, reason) in enumerate(deadlock.skipped, start=1)
    ]
    help = f"give '{deadlock.program}' a statement that achieves it, or let it require what it cannot achieve"
    return Diagnostic(code, message, span, tuple(notes), help)


def _refused(livelock: Livelock, name: str, start: str, span: Span) -> Diagnostic:
    """Return the warning of a livelock that is due to failing calls, perhaps not the expert's fault."""
    failures = dict.fromkeys(f"{api}({_given(arguments)}): {why}" for api, arguments, why in livelock.refused)
    message = f"'{name}' makes no progress ({start} start): the world refuses {next(iter(failures))}"
    help = "leave more room: fewer or smaller objects, or larger regions; or call something else in that case"
    return Diagnostic("W603", message, span, (), help)


def _given(arguments: Sequence[Argument]) -> str:
    return ", ".join("..." if isinstance(each, tuple) else format_argument(each) for each in arguments)


def _nondeterministic(error: NondeterministicExpert, registry: Registry) -> Diagnostic:
    row = registry.programs[error.program]
    answers = [_answer(each) for each in error.answers]
    message = f"the expert of '{row.name}' is not a function of the state: {error.how}, it decides "
    message += f"{answers[1]}, not {answers[0]}"
    help = "decide by the arguments and the predicates alone; sort what has no order"
    return Diagnostic("E606", message, row.span, (), help)


def _answer(answer: Decision) -> str:
    if isinstance(answer, NextCall):
        return f"{answer.callee}({_given(answer.arguments)})"
    return "done" if answer.done else "unfinished"


def _success_span(task: TaskDeclaration) -> Span:
    assert task.success is not None
    return task.success.span
