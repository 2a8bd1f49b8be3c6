"""Episodes in numbers: two success tests, and for every failure who is to blame."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from math import hypot
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from ntp_dsl.experts import Expert
from ntp_dsl.interpreter import Interpreter, Run, Watcher
from ntp_dsl.language.diagnostics import NtpError
from ntp_dsl.language.loader import load
from ntp_dsl.policy import Policy
from ntp_dsl.predicates import JUDGED, held
from ntp_dsl.recording import Shown, demonstrate, header
from ntp_dsl.registry import Registry
from ntp_dsl.scripted import ScriptedPolicy
from ntp_dsl.seeds import derived
from ntp_dsl.specification import Demonstration, Recorder
from ntp_dsl.state import State
from ntp_dsl.tasks import Goal, Instance, draw, find_task, from_file
from ntp_dsl.traces import TraceWriter
from ntp_dsl.world import Disturbances, Failure, Observation, Record, Scene, Vector, World
from ntp_dsl.worlds import make_world
from ntp_dsl.worlds.scenes import movable, scattered

ATTEMPTS = 5  # at a demonstration, each from another placement
STILL_FOR = 2.0  # [s] that the result must stand
KNOCKED = "knocked aside"
STAYED = 0.01  # [m] that a thing the goal does not name may have moved
BLAME = {
    Failure.NO_IK: "planner",
    Failure.START_IN_COLLISION: "planner",
    Failure.GOAL_IN_COLLISION: "planner",
    Failure.NO_PATH: "planner",
    Failure.TIME_OUT: "planner",
    Failure.GRASP_FAILED: "grasp",
    Failure.OBJECT_DROPPED: "grasp",
    Failure.PLACE_FAILED: "physics",
}


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


class Evaluator:
    """One process's library, policy and world. Episode n depends on the plan and n alone."""

    def __init__(self, plan: Plan) -> None:
        if plan.traces is not None:
            plan.traces.mkdir(parents=True, exist_ok=True)
        self.plan = plan
        self.registry = load(plan.library)
        self.expert = Expert(self.registry)
        self.task = find_task(self.registry, plan.task)
        self.world = make_world(plan.world)
        self._file = from_file(self.registry, self.task, plan.tasks) if plan.tasks else []
        self._core: Any = None
        if plan.model is not None:
            from ntp_dsl.core.checkpoint import check_fits, load_core

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
        """By the expert, in the same world, from another placement; tried again where it fails."""
        for attempt in range(ATTEMPTS):
            seed = derived(self.plan.seed, number, 2, attempt)
            shown = demonstrate(self.registry, self.expert, self.world, instance, seed)
            if isinstance(shown, Shown):
                return shown, attempt + 1
        raise NtpError(f"the expert failed at {ATTEMPTS} demonstrations of {instance.name}")

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
            instance = replace(instance, goal=_goal_shown(demonstration))
        elif self.is_learned:
            shown, attempts = self.demonstration(instance, number)
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
            writer.header(**header(self.registry, instance, self.plan.seed, kind))
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
    if workers == 1:
        evaluator = Evaluator(plan)
        yield from (evaluator.episode(number) for number in range(episodes))
        return
    with ProcessPoolExecutor(workers, get_context("spawn"), _start_worker, (plan,)) as pool:
        yield from pool.map(_work, range(episodes))


_evaluator: Evaluator


def _start_worker(plan: Plan) -> None:
    global _evaluator
    _evaluator = Evaluator(plan)


def _work(number: int) -> Episode:
    return _evaluator.episode(number)


# Success -----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Verdict:
    blame: str
    reason: str
    authors: bool


def judge(registry: Registry, world: World, instance: Instance, scene: Scene, run: Run) -> Verdict:
    """The strict test, and the paper's authors' own; looks twice, two seconds apart."""
    before = world.truth()
    wrong_before = _wrong(registry, world, instance, scene, run)
    world.settle(STILL_FOR)
    after = world.truth()
    wrong = _wrong(registry, world, instance, scene, run) or _crept(before, after)
    authors = authors_success(after, instance.goal)
    if not wrong:
        return Verdict("", "", authors)
    return Verdict(_blame(run, wrong_before), f"{wrong}; {run.reason}", authors)


def _wrong(
    registry: Registry, world: World, instance: Instance, scene: Scene, run: Run
) -> str:
    """The first thing that is not as it should be, or nothing."""
    now = world.truth()
    state = State(registry, now, JUDGED)
    for literal in instance.literals(registry, now):
        if not state.holds(literal):
            return f"{literal} does not hold"
    for placement in instance.goal:
        if not world.supported(placement["item"], placement["support"]):
            return f"{placement['item']} does not touch {placement['support']}"
    in_hand = held(now)
    if in_hand is not None:
        return f"{in_hand} is in the hand"
    named = {placement[part] for placement in instance.goal for part in ("item", "support")}
    for thing in movable(instance.things):
        if thing.name in named or thing.name in world.disturbed:
            continue
        if _distance(now.positions[thing.name], scene.positions[thing.name]) > STAYED:
            return f"{thing.name} was {'moved' if thing.name in run.handled else KNOCKED}"
    return ""


def _crept(before: Observation, after: Observation) -> str:
    for name, position in after.positions.items():
        if _distance(position, before.positions[name]) > STAYED / 10:
            return f"{name} is not still"
    return ""


def _blame(run: Run, wrong_before: str) -> str:
    """Physics where all was well and then fell, or was knocked; the arm where it gave up; else decisions."""
    if run.done and (not wrong_before or wrong_before.endswith(KNOCKED)):
        return "physics"
    if run.done:
        return "decision"
    kinds = Counter(BLAME[f.failure] for f in run.failures[-5:] if f.failure in BLAME)
    return kinds.most_common(1)[0][0] if len(run.failures) >= 3 and kinds else "decision"


def authors_success(now: Observation, goal: Goal) -> bool:
    """The test of the paper's authors: within 0.05 m of each other seen from above, and higher."""
    for placement in goal:
        x, y, z = now.positions[placement["item"]]
        sx, sy, sz = now.positions[placement["support"]]
        if hypot(x - sx, y - sy) > 0.05 or z <= sz:
            return False
    return True


def _distance(a: Vector, b: Vector) -> float:
    return float(np.linalg.norm(np.subtract(a, b)))


# Figures -----------------------------------------------------------------------------------------


def summary(episodes: Sequence[Episode], seed: int) -> dict[str, Any]:
    """The figures that `eval --json` prints."""
    count = len(episodes)
    wins = sum(episode.success for episode in episodes)
    blames = Counter(episode.blame for episode in episodes if episode.blame)
    return {
        "episodes": count,
        "success": wins / count,
        "success_interval": wilson(wins, count),
        "success_authors": sum(episode.success_authors for episode in episodes) / count,
        "failures": {kind: blames[kind] for kind in ("decision", "planner", "grasp", "physics")},
        "seconds_per_episode": _mean(episode.wall_seconds for episode in episodes),
        "deciding_seconds_per_episode": _mean(episode.deciding_seconds for episode in episodes),
        "planning_seconds_per_episode": _mean(episode.planning_seconds for episode in episodes),
        "simulated_seconds_per_episode": _mean(e.simulated_seconds for e in episodes),
        "placements_per_episode": _mean(float(episode.placements) for episode in episodes),
        "disturbances": sum(episode.disturbances for episode in episodes),
        "demonstrations_repeated": sum(max(e.demonstrations - 1, 0) for e in episodes),
        "failed": [
            {"episode": e.number, "task": e.name, "blame": e.blame, "reason": e.reason}
            for e in episodes
            if not e.success
        ],
        "seed": seed,
    }


def wilson(wins: int, count: int, z: float = 1.959964) -> tuple[float, float]:
    """The 95 % interval of a proportion (Wilson, 1927)."""
    share, spread = wins / count, z * z / count
    centre = (share + spread / 2) / (1 + spread)
    half = z / (1 + spread) * ((share * (1 - share) + spread / 4) / count) ** 0.5
    return round(max(0.0, centre - half), 4), round(min(1.0, centre + half), 4)


def _mean(values: Iterator[float]) -> float:
    return round(float(np.mean(list(values))), 4)
