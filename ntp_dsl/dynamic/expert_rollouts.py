"""Rollouts of experts: every task, and every program as the root, from all kinds of starts."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from ntp_dsl.dynamic.findings import Finding
from ntp_dsl.dynamic.places import Places
from ntp_dsl.dynamic.starts import STARTS
from ntp_dsl.dynamic.trial_traces import TrialTraces
from ntp_dsl.dynamic.trials import Trial, Trials
from ntp_dsl.dynamic.watching import Livelock, NondeterministicExpert
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.diagnostics.rendering import shown_path
from ntp_dsl.language.registry import Program, Registry
from ntp_dsl.language.syntax.nodes import Span, TaskDeclaration
from ntp_dsl.policies.random_arguments import random_arguments
from ntp_dsl.semantics.facts import Fact, Literal
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.state import State
from ntp_dsl.semantics.value_checks import OutOfRange
from ntp_dsl.tasks.instances import Instance, draw
from ntp_dsl.worlds.protocol import World

MAX_OBJECTS_FOR_ALL_TRIALS, MIN_OBJECTS_FOR_ONE_TRIAL = 16, 60
PROGRAM_TRIALS = 6  # of every program as the root


class ExpertRollouts:
    """Tests the experts of one registry in one world.

    Args:
        traces: where to write those of trials that failed.
    """

    def __init__(
        self, registry: Registry, world: World, seed: int, places: Places, traces: TrialTraces
    ) -> None:
        self.registry, self.world, self.seed = registry, world, seed
        self._places, self._traces = places, traces
        self._trials = Trials(registry, world, seed, traced=traces.folder is not None)

    @property
    def called(self) -> set[str]:
        """The programs and apis that were called in any trial."""
        return self._trials.called

    def unused_lines(self, programs: Collection[str]) -> Iterator[Diagnostic]:
        """Yield a note for each statement of some programs that made no call, though its program ran."""
        for program in self.registry.programs.values():
            if program.name not in self.called & set(programs) or not self._places.is_own(program.span):
                continue
            for statement in program.statements():
                if statement.span not in self._trials.followed:
                    message = f"no trial needed this call of '{statement.callee}': it is not tested"
                    help = "where it should have been made: see in which order the statements stand, and "
                    help += f"what '{program.name}' and '{statement.callee}' achieve; else it is a precaution"
                    yield Diagnostic("N604", message, statement.span, (), help)

    # Tasks --------------------------------------------------------------------------------------

    def check_task(self, task: TaskDeclaration) -> Iterator[Diagnostic]:
        """Yield what is wrong with a task or its expert; a livelock or nondeterminism ends the test.

        Raises `NtpError` where a function in Python fails.
        """
        assert task.run is not None
        trials: list[Trial] = []
        objects = len(self._instance(task, 0)[0].objects)
        for start, (_, count) in STARTS.items():
            for number in range(_trial_count(count, start, objects)):
                trial = self._trial(task, start, number)
                trials.append(trial)
                if trial.fault is not None:
                    failed = self._findings(task.name, filter(_is_failed, trials), task.run.span)
                    yield _fault(failed[-1])
                    return
        failed = self._findings(task.name, filter(_is_failed, trials), task.run.span)
        yield from _unreached(failed, sum(trial.start != "missing object" for trial in trials))
        yield from self._check_success(task, [trial for trial in trials if trial.start == "nominal"])

    def _instance(self, task: TaskDeclaration, number: int) -> tuple[Instance, np.random.Generator]:
        rng = np.random.default_rng((self.seed, number))
        return draw(self.registry, task, rng), rng

    def _trial(self, task: TaskDeclaration, start: str, number: int, limit: int | None = None) -> Trial:
        instance, rng = self._instance(task, number)
        self.world.reset(STARTS[start][0](instance, rng), number)
        return self._trials.run(instance, start, number, limit)

    def _findings(self, name: str, failed: Iterable[Trial], home: Span) -> list[Finding]:
        """Write the traces of trials that failed, and return what they show."""
        return [
            Finding(
                name,
                trial,
                home,
                self._places,
                self._traces.write(self.registry.name, name, trial.trace),
            )
            for trial in failed
        ]

    def _check_success(self, task: TaskDeclaration, nominal: Sequence[Trial]) -> Iterator[Diagnostic]:
        """Yield where success holds too early: at the start, in part, or half-way."""
        unmet = [trial.unmet_in(trial.first) for trial in nominal]
        initially = {
            str(fact)
            for trial, lacking in zip(nominal, unmet, strict=True)
            for fact in trial.facts_in(trial.first)
            if fact not in lacking and _is_of_an_element(fact, trial.instance)
        }
        if nominal and not any(unmet):
            message = f"the goal of '{task.name}' holds at the start: there is nothing to demonstrate"
            yield Diagnostic("E602", message, _success_span(task))
        elif initially:
            facts = ", ".join(sorted(initially)[:3])
            message = f"part of the goal of '{task.name}' holds at the start: {facts}"
            help = "a demonstration only shows what does not hold at the start"
            yield Diagnostic("W602", message, _success_span(task), (), help)
        elif not any(trial.unmet for trial in nominal):
            yield from self._check_half_way(task, nominal)

    def _check_half_way(self, task: TaskDeclaration, nominal: Sequence[Trial]) -> Iterator[Diagnostic]:
        """Yield an error where success already holds after half of the expert's primitives."""
        halves = [
            self._trial(task, "nominal", trial.number, trial.run.primitives // 2)
            for trial in nominal
            if trial.run.primitives > 1
        ]
        if halves and not any(trial.unmet for trial in halves):
            message = f"success of '{task.name}' holds although its expert was stopped half-way"
            help = f"require in 'success' all that '{task.run.callee if task.run else '?'}' achieves"
            yield Diagnostic("E604", message, _success_span(task), (), help)

    # Programs -----------------------------------------------------------------------------------

    def check_program(self, program: Program, instances: Sequence[Instance]) -> Iterator[Diagnostic]:
        """Yield where a program, as the root with random arguments, does not achieve its contract.

        Raises `NtpError` where a function in Python fails.
        """
        livelocks: list[Trial] = []
        unfinished: list[Trial] = []
        for number in range(PROGRAM_TRIALS):
            rng = np.random.default_rng((self.seed, 1, number))
            instance = instances[number % len(instances)]
            self.world.reset(instance.perturbed_start(rng, straight=1.0), number)
            state = State(self.registry, self.world.truth())
            arguments = random_arguments(program.parameters, state, rng)
            if arguments is None:
                return
            trial = self._trials.run(_calling(program, arguments, instance), "perturbed", number)
            if isinstance(trial.fault, Livelock):
                livelocks.append(trial)
            elif isinstance(trial.fault, OutOfRange):  # of a random number, which it need not accept
                continue
            elif trial.fault is not None:
                yield _fault(self._findings(program.name, [trial], program.span)[0])
                return
            elif all(map(state.holds, state.literals(program.requires, program.bind(arguments)))):
                if trial.run.done:
                    return
                unfinished.append(trial)
        if len(livelocks) > 1:
            yield _fault(self._findings(program.name, livelocks, program.span)[0], "W604")
        elif len(unfinished) > 1:
            findings = self._findings(program.name, unfinished, program.span)
            yield findings[-1].unkept(len(findings))


def _calling(program: Program, arguments: tuple[Argument, ...], instance: Instance) -> Instance:
    """Return an instance in the same scene whose root is a call of the program, and success its contract."""
    task = replace(instance.task, name=program.name, success=program.achieves)
    bindings = {**instance.bindings, **program.bind(arguments)}
    return replace(
        instance, task=task, goal=(), program=program.name, arguments=arguments, name="", bindings=bindings
    )


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


def _is_failed(trial: Trial) -> bool:
    return trial.is_failed


def _fault(finding: Finding, code: str = "E605") -> Diagnostic:
    """Return the diagnostic of the fault that ended a trial; raise it where a function in Python failed."""
    match finding.trial.fault:
        case Livelock() as livelock:
            return finding.livelock(livelock, code)
        case NondeterministicExpert() as error:
            return finding.nondeterministic(error)
        case fault:
            assert fault is not None
            if finding.file is not None:
                fault.add_note(f"its trace: {shown_path(finding.file)}")
            raise fault


def _unreached(failed: Sequence[Finding], tried: int) -> Iterator[Diagnostic]:
    """Yield an error where the goal is not reached, at a deadlock if there is one."""
    for finding in failed:
        if finding.trial.deadlock is not None:
            yield finding.deadlock(finding.trial.deadlock)
            return
    if failed:
        yield failed[0].unreached([finding.trial for finding in failed], tried)


def _success_span(task: TaskDeclaration) -> Span:
    assert task.success is not None
    return task.success.span
