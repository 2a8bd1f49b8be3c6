"""Episodes: a task, a demonstration of it, a policy in a world, and a verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import nullcontext
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from ntp_dsl.experts import Expert
from ntp_dsl.interpreter import Interpreter, Run, Watcher
from ntp_dsl.language.diagnostics import NtpError, TaskFailed
from ntp_dsl.language.loader import load
from ntp_dsl.policy import Policy
from ntp_dsl.recording import Shown, demonstrate, header
from ntp_dsl.scripted import ScriptedPolicy
from ntp_dsl.seeds import derived
from ntp_dsl.specification import Demonstration, Recorder
from ntp_dsl.success import judge
from ntp_dsl.tasks import Goal, Instance, draw, find_task, from_file
from ntp_dsl.traces import TraceWriter
from ntp_dsl.workers import in_order
from ntp_dsl.world import Disturbances, Observation, Record, Scene
from ntp_dsl.worlds import make_world
from ntp_dsl.worlds.scenes import scattered

ATTEMPTS = 5  # at a demonstration, each from another placement


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


@dataclass(frozen=True)
class Episode:
    """What came of one episode. Wall times are left out of comparisons."""

    number: int
    name: str
    placements: int
    success: bool
    success_authors: bool
    blame: str  # empty, or decision, planner, grasp, physics
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
        self.registry = load(plan.library)
        self.expert = Expert(self.registry)
        self.task = find_task(self.registry, plan.task)
        self.world = make_world(plan.world, self.registry)
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
        """From the task file, in its order and over again, or drawn from the seed."""
        if self._file:
            return self._file[number % len(self._file)]
        rng = np.random.default_rng((self.plan.seed, number, 0))
        return draw(self.registry, self.task, rng)

    def scene(self, instance: Instance, number: int) -> Scene:
        return scattered(instance.things, np.random.default_rng((self.plan.seed, number, 1)))

    def demonstration(self, instance: Instance, number: int) -> tuple[Shown, int]:
        """By the expert, in the same world, from another placement; tried again where it fails.

        Raises `NoDemonstration` where it fails again and again.
        """
        reason = ""
        for attempt in range(ATTEMPTS):
            seed = derived(self.plan.seed, number, 2, attempt)
            shown = demonstrate(self.registry, self.expert, self.world, instance, seed)
            if isinstance(shown, Shown):
                return shown, attempt + 1
            reason = shown.reason
        raise NoDemonstration(
            f"the expert failed at {ATTEMPTS} demonstrations of {instance.name}: {reason}"
        )

    def policy(self, demonstration: Demonstration | None) -> Policy:
        if demonstration is None or self._core is None:
            return ScriptedPolicy(self.expert)
        from ntp_dsl.core.policy import LearnedPolicy

        return LearnedPolicy(self._core, demonstration)

    def episode(
        self,
        number: int,
        demonstration: Demonstration | None = None,
        watch: Watcher | None = None,
        on_frame: Callable[[Observation], None] | None = None,
    ) -> Episode:
        instance = self.instance(number)
        attempts = 0
        if demonstration is not None:
            _check_shown(demonstration, instance)
            instance = replace(instance, goal=_goal_shown(demonstration))
        elif self.is_learned:
            try:
                shown, attempts = self.demonstration(instance, number)
            except NoDemonstration as failure:
                return _not_shown(number, instance, failure)
            demonstration = shown.demonstration
        scene = self.scene(instance, number)
        started = perf_counter()
        self.world.reset(scene, derived(self.plan.seed, number, 3), self.plan.disturbances)
        run = self._run(instance, number, self.policy(demonstration), watch, on_frame)
        wall = perf_counter() - started
        simulated = self.world.time
        verdict = judge(self.registry, self.world, instance, scene, run)
        return Episode(
            number,
            instance.name,
            len(instance.goal),
            not verdict.blame,
            verdict.authors,
            verdict.blame,
            verdict.reason,
            run.primitives,
            round(simulated, 3),
            run.disturbances,
            attempts,
            wall,
            run.deciding_seconds,
            run.planning_seconds,
        )

    def _run(
        self,
        instance: Instance,
        number: int,
        policy: Policy,
        watch: Watcher | None,
        on_frame: Callable[[Observation], None] | None,
    ) -> Run:
        folder = self.plan.traces
        path = folder / f"episode_{number:05d}.trace.jsonl" if folder else None
        with path.open("w") if path else nullcontext() as stream:
            writer = TraceWriter(stream)
            kind = "learned" if self._core is not None else "scripted"
            writer.header(
                **header(self.registry, instance, self.plan.seed, kind),
                episode=number,
                world=self.plan.world,
                model=str(self.plan.model) if self.plan.model else None,
                disturbances=asdict(self.plan.disturbances),
            )
            recorder = Recorder(self.world, also=on_frame)
            interpreter = Interpreter(
                self.registry,
                policy,
                self.world,
                writer,
                watch=watch,
                frame_number=lambda: len(recorder),
            )
            run = interpreter.run(instance.program, instance.arguments)
            writer.end(done=run.done, reason=run.reason, primitives=run.primitives)
        self.world.on_frame = None
        return run


def _not_shown(number: int, instance: Instance, failure: NoDemonstration) -> Episode:
    """An episode that could not begin counts as failed."""
    placements = len(instance.goal)
    return Episode(
        number, instance.name, placements, False, False, "planner", str(failure), 0, 0.0, 0, ATTEMPTS
    )


def _check_shown(demonstration: Demonstration, instance: Instance) -> None:
    """Before anything is written: a demonstration shows the things of the scene, all and no others."""
    shown = {(thing.name, thing.type) for thing in demonstration.things}
    there = {(thing.name, thing.type) for thing in instance.things}
    for verb, odd in (("lacks", there - shown), ("also shows", shown - there)):
        if odd:
            listed = ", ".join(sorted(f"{name} ({type_name})" for name, type_name in odd))
            raise NtpError(
                f"the demonstration {verb} {listed}; the scene has "
                f"{', '.join(sorted(name for name, _ in there))}"
            )


def _goal_shown(demonstration: Demonstration) -> Goal:
    """What success is judged by where a demonstration is brought: its own goal. The policy never sees it."""
    try:
        goal = [
            Record("Placement", (("item", row["item"]), ("support", row["support"])))
            for row in demonstration.notes["goal"]
        ]
    except (KeyError, TypeError) as error:
        raise NtpError("the demonstration does not say what it shows; record it anew") from error
    missing = {name for row in goal for _, name in row.fields} - set(demonstration.names)
    if missing:
        raise NtpError(f"the demonstration's goal names {', '.join(sorted(missing))}, which it lacks")
    return tuple(goal)


def run_all(plan: Plan, episodes: int, workers: int) -> Iterator[Episode]:
    """Episodes in their order, whatever the number of workers."""
    return in_order(partial(_open, plan), episodes, workers)


def _open(plan: Plan) -> Callable[[int], Episode]:
    return Evaluator(plan).episode
