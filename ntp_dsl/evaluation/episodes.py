"""Episodes: a task, a demonstration of it, a policy in a world, and a verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from msgspec.structs import replace as with_fields

from ntp_dsl.common.files import episode_files
from ntp_dsl.common.seeds import derived
from ntp_dsl.common.workers import in_order
from ntp_dsl.datasets.recording import RecordedDemonstration, demonstrate, header
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.demonstrations.demonstration_files import write_demonstration
from ntp_dsl.evaluation.success import Verdict, judge
from ntp_dsl.execution.interpreter import Interpreter, Limits, Run, Watcher
from ntp_dsl.language.diagnostics.diagnostics import NtpError, TaskFailed
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.protocol import Policy
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.observation import Observation, Record
from ntp_dsl.tasks.goal_samplers import Goal
from ntp_dsl.tasks.instances import Instance, draw, enough_primitives, find_task, from_file
from ntp_dsl.traces.schema import Attribution, End, Header, PolicyKind
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.user_code.loading import load_with_python
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import Disturbances, Scene

OnFrame = Callable[[Observation], str | None]  # the file of the picture that it took, if any
ATTEMPTS = 5  # at a demonstration, each from another placement
REDRAWS = 100  # of a goal that holds from the start


@dataclass(frozen=True)
class Plan:
    """What an evaluation runs, in a form that every worker understands."""

    library: Path
    task: str
    model: Path | None  # None: the scripted expert
    world: str = "kinematic"
    seed: int = 0
    disturbances: Disturbances = Disturbances()
    tasks: Path | None = None
    traces: Path | None = None
    varied: tuple[tuple[str, tuple[int, int]], ...] = ()  # length, topology, semantics -> range
    gui: bool = False  # a window on the bullet world
    arm: str | None = None  # of the bullet world; the Panda if none is told


@dataclass(frozen=True)
class Episode:
    """What came of one episode. Wall times are left out of comparisons."""

    number: int
    name: str
    placements: int
    success: bool | None  # None where a demonstration does not say what it shows, so that nobody can judge
    success_authors: bool | None
    attributed_to: Attribution | None  # of a failure
    reason: str
    primitives: int
    simulated_seconds: float
    disturbances: int
    demonstrations: int  # how many it took until one went well
    wall_seconds: float = field(default=0.0, compare=False)
    deciding_seconds: float = field(default=0.0, compare=False)
    planning_seconds: float = field(default=0.0, compare=False)


class NoDemonstration(TaskFailed):
    """The expert could not show the task, so there is nothing to learn it from."""


class Evaluator:
    """One process's library, policy and world. Episode n depends on the plan and n alone."""

    def __init__(self, plan: Plan) -> None:
        if plan.traces is not None:
            plan.traces.mkdir(parents=True, exist_ok=True)
        self.plan = plan
        self.registry = load_with_python(plan.library)
        self.expert = Expert(self.registry)
        self.task = find_task(self.registry, plan.task)
        self.world = make_world(plan.world, self.registry, gui=plan.gui, arm=plan.arm)
        self._file = from_file(self.registry, self.task, plan.tasks) if plan.tasks else []
        self._core: Any = None
        if plan.model is not None:
            from ntp_dsl.core.checkpoint import check_fits, load_core
            from ntp_dsl.core.training import use_threads

            use_threads(1)  # a decision is small; other processors belong to other workers
            self._core = load_core(plan.model).core
            assert self.task.run is not None
            check_fits(self._core.memory, self.registry, self.task.run.callee, plan.model)

    @property
    def is_learned(self) -> bool:
        return self._core is not None

    def instance(self, number: int) -> Instance:
        """From the task file, in its order and over again; or drawn, until there is something to do."""
        if self._file:
            return self._file[number % len(self._file)]
        for attempt in range(REDRAWS):
            again = (attempt,) if attempt else ()
            rng = np.random.default_rng((self.plan.seed, number, 0, *again))
            drawn = draw(self.registry, self.task, rng, dict(self.plan.varied))
            if not drawn.holds_in(self.registry, self.scene(drawn, number)):
                return drawn
        raise NtpError(f"all of {REDRAWS} goals that were drawn for '{self.plan.task}' hold from the start")

    def scene(self, instance: Instance, number: int) -> Scene:
        return instance.nominal_start(np.random.default_rng((self.plan.seed, number, 1)))

    def demonstration(self, instance: Instance, number: int) -> tuple[RecordedDemonstration, int]:
        """By the expert, in the same world, from another placement; tried again where it fails.

        Raises `NoDemonstration` where it fails again and again.
        """
        reason = ""
        for attempt in range(ATTEMPTS):
            seed = derived(self.plan.seed, number, 2, attempt)
            shown = demonstrate(self.registry, self.expert, self.world, instance, seed)
            if isinstance(shown, RecordedDemonstration):
                return shown, attempt + 1
            reason = shown.reason
        raise NoDemonstration(f"the expert failed at {ATTEMPTS} demonstrations of {instance.name}: {reason}")

    def policy(self, shown: RecordedDemonstration | None) -> Policy:
        """Of a learned program, by a demonstration; else of the script, which takes its scopes from one."""
        if shown is None or self._core is None:
            return ScriptedPolicy(self.expert, shown.calls if shown else None)
        from ntp_dsl.core.policy import LearnedPolicy

        return LearnedPolicy(self._core, shown.demonstration)

    def episode(
        self,
        number: int,
        shown: RecordedDemonstration | None = None,
        watch: Watcher | None = None,
        on_frame: OnFrame | None = None,
    ) -> Episode:
        instance = self.instance(number)
        attempts = 0
        if shown is not None:
            check_objects(shown.demonstration, instance)
            instance = instance.with_goal(_goal_shown(self.registry, shown.demonstration, instance))
        elif self.is_learned or self.plan.traces is not None:
            try:
                shown, attempts = self.demonstration(instance, number)
            except NoDemonstration as failure:
                if self.is_learned:
                    return _not_shown(number, instance, failure)
        scene = self.scene(instance, number)
        with traced(self.plan.traces, number) as writer:
            writer.header(self._header(instance, number, shown))
            started = perf_counter()
            self.world.reset(scene, derived(self.plan.seed, number, 3), self.plan.disturbances)
            run = self._run(instance, writer, self.policy(shown), watch, on_frame)
            wall = perf_counter() - started
            simulated = self.world.time
            judged = judge(self.registry, self.world, instance, scene, run) if instance.goal else None
            writer.end(_end(run, judged))
        return Episode(
            number,
            instance.name,
            len(instance.goal),
            judged.success if judged else None,
            judged.success_authors if judged else None,
            judged.attributed_to if judged else None,
            judged.reason if judged else run.reason,
            run.primitives,
            round(simulated, 3),
            run.disturbances,
            attempts if self.is_learned else 0,
            wall,
            run.deciding_seconds,
            run.planning_seconds,
        )

    @cached_property
    def _sources(self) -> dict[str, str]:
        """The text of the library and of what it uses: a trace shows the statements that it refers to."""
        paths = {row.span.path for row in self.registry.programs.values() if row.span.path}
        return {path.name: path.read_text(encoding="utf-8") for path in sorted(paths)}

    def _header(self, instance: Instance, number: int, shown: RecordedDemonstration | None) -> Header:
        """Return what the trace says first. The demonstration is written beside it."""
        kind = PolicyKind.LEARNED if self.is_learned else PolicyKind.SCRIPTED
        told = None
        if shown is not None and self.plan.traces is not None:
            _, path = episode_files(self.plan.traces, number)
            write_demonstration(shown.demonstration, path)
            told = shown.trace_record(path.name)
        return with_fields(
            header(self.registry, instance, self.plan.seed, kind),
            demonstration=told,
            sources=self._sources,
            episode=number,
            world=self.plan.world,
            arm=self.plan.arm,
            model=str(self.plan.model) if self.plan.model else None,
            disturbances=self.plan.disturbances,
        )

    def _run(
        self,
        instance: Instance,
        writer: TraceWriter,
        policy: Policy,
        watch: Watcher | None,
        on_frame: OnFrame | None,
    ) -> Run:
        def frame(seen: Observation) -> None:
            number = writer.frame(self.world.time, seen)
            if on_frame is not None and (picture := on_frame(seen)):
                writer.picture(number, picture)

        self.world.on_frame = frame
        interpreter = Interpreter(
            self.registry,
            policy,
            self.world,
            writer,
            limits=Limits(primitives=enough_primitives(instance)),
            watch=watch,
            frame_number=lambda: writer.frames,
        )
        run = interpreter.run(instance.program, instance.arguments)
        self.world.on_frame = None
        return run


@contextmanager
def traced(folder: Path | None, number: int) -> Iterator[TraceWriter]:
    """Into a folder, where there is one."""
    path = episode_files(folder, number)[0] if folder else None
    with path.open("w", encoding="utf-8") if path else nullcontext() as stream:
        yield TraceWriter(stream)


def _end(run: Run, judged: Verdict | None) -> End:
    if judged is None:
        return run.end()
    return with_fields(
        run.end(),
        success=judged.success,
        attributed_to=judged.attributed_to,
        verdict=judged.reason,
    )


def _not_shown(number: int, instance: Instance, failure: NoDemonstration) -> Episode:
    """An episode that could not begin counts as failed."""
    return Episode(
        number,
        instance.name,
        len(instance.goal),
        False,
        False,
        Attribution.PLANNER,
        str(failure),
        primitives=0,
        simulated_seconds=0.0,
        disturbances=0,
        demonstrations=ATTEMPTS,
    )


def check_objects(demonstration: Demonstration, instance: Instance) -> None:
    """Raise `NtpError` unless a demonstration shows the objects of the scene, all and no others."""
    shown = {(obj.name, obj.type) for obj in demonstration.objects}
    there = {(obj.name, obj.type) for obj in instance.objects}
    for verb, odd in (("lacks", there - shown), ("also shows", shown - there)):
        if odd:
            listed = ", ".join(sorted(f"{name} ({type_name})" for name, type_name in odd))
            raise NtpError(
                f"the demonstration {verb} {listed}; the scene has "
                f"{', '.join(sorted(name for name, _ in there))}"
            )


def _goal_shown(registry: Registry, demonstration: Demonstration, instance: Instance) -> Goal:
    """Return what success is judged by where a demonstration is brought: its own goal, if it says one.

    The policy never sees it.
    """
    told = demonstration.origin.goal
    if not told:
        return ()
    pattern = instance.goal[0]
    try:
        goal = tuple(
            Record(pattern.type, tuple((name, type(value)(row[name])) for name, value in pattern.fields))
            for row in told
        )
    except (KeyError, TypeError, ValueError) as error:
        fields = ", ".join(name for name, _ in pattern.fields)
        raise NtpError(
            f"the demonstration's goal is not one of this task: its elements have {fields}"
        ) from error
    known = {*demonstration.names, *(name for enum in registry.enums.values() for name in enum)}
    missing = {value for row in goal for _, value in row.fields if isinstance(value, str)} - known
    if missing:
        raise NtpError(f"the demonstration's goal names {', '.join(sorted(missing))}, which it lacks")
    return goal


def run_all(plan: Plan, episodes: int, workers: int) -> Iterator[Episode]:
    """Episodes in their order, whatever the number of workers."""
    return in_order(partial(_open, plan), episodes, workers)


def _open(plan: Plan) -> Callable[[int], Episode]:
    return Evaluator(plan).episode
