"""What an episode consists of: each part is a function of the seed and the episode's number alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
from msgspec.structs import replace as with_fields

from ntp_dsl.common.files import written_whole
from ntp_dsl.common.seeds import derived
from ntp_dsl.datasets.recording import FailedDemonstration, RecordedDemonstration, demonstrate
from ntp_dsl.evaluation.success import Verdict, attribution_of_failure, attribution_of_failures, judge
from ntp_dsl.execution.interpreter import Interpreter, Limits, Run, Watcher
from ntp_dsl.execution.supervision import Supervisor
from ntp_dsl.language.diagnostics.diagnostics import NtpError, TaskFailed
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax.nodes import Sampler, TaskDeclaration
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.protocol import Policy
from ntp_dsl.semantics.observation import Observation
from ntp_dsl.tasks.goal_samplers import Variation
from ntp_dsl.tasks.instances import Instance, draw, enough_primitives
from ntp_dsl.traces.schema import Attribution, End, Header, PolicyKind
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.protocol import Disturbances, Scene, World

OnFrame = Callable[[Observation], str | None]  # the file of the picture that it took, if any
ATTEMPTS = 5  # at a demonstration, each from another placement
REDRAWS = 100  # of a goal that holds from the start


class NoDemonstration(TaskFailed):
    """The expert failed to demonstrate the task."""

    def __init__(self, instance: Instance, last: FailedDemonstration) -> None:
        super().__init__(f"the expert failed in {ATTEMPTS} demonstrations of {instance.name}: {last}")
        self.last = last

    @property
    def attributed_to(self) -> Attribution:
        """Return what the last attempt's failure is attributed to."""
        run = self.last.run
        if run.done and run.failures:
            return attribution_of_failure(run.failures[-1]) or Attribution.DECISION
        return attribution_of_failures(run)

    def write_trace(self, path: Path, header: Header) -> None:
        """Write the trace of the last attempt, under the header of the episode."""
        own = with_fields(
            header, policy=PolicyKind.DEMONSTRATION, model=None, dispatch=None, disturbances=None
        )
        end = with_fields(
            self.last.run.end(), success=False, attributed_to=self.attributed_to, verdict=str(self.last)
        )
        with written_whole(path) as unfinished, unfinished.open("w", encoding="utf-8") as stream:
            writer = TraceWriter(stream)
            writer.header(own)
            stream.write(self.last.trace)
            writer.end(end)


def drawn_instance(
    registry: Registry, task: TaskDeclaration, seed: int, number: int, varied: Variation | None = None
) -> Instance:
    """Draw an instance in which there is something to do. Raises `NtpError` where there is none."""
    for attempt in range(REDRAWS):
        again = (attempt,) if attempt else ()
        instance = draw(registry, task, np.random.default_rng((seed, number, 0, *again)), varied)
        is_drawn = isinstance(task.goal, Sampler)
        scene = (
            _scene(instance, seed, number, 0)
            if is_drawn
            else starting_scene(registry, instance, seed, number)
        )
        if not instance.holds_in(registry, scene):
            return instance
        if not is_drawn:
            raise NtpError(
                f"the goal of '{task.name}' holds at the start of all {REDRAWS} scenes that were drawn"
            )
    raise NtpError(f"all {REDRAWS} goals that were drawn for '{task.name}' hold at the start")


def starting_scene(registry: Registry, instance: Instance, seed: int, number: int) -> Scene:
    """Return where everything starts: of the scenes that are drawn, the first in which something is to do."""
    first = _scene(instance, seed, number, 0)
    if not instance.holds_in(registry, first):
        return first
    others = (_scene(instance, seed, number, attempt) for attempt in range(1, REDRAWS))
    return next((scene for scene in others if not instance.holds_in(registry, scene)), first)


def _scene(instance: Instance, seed: int, number: int, attempt: int) -> Scene:
    again = (attempt,) if attempt else ()
    return instance.nominal_start(np.random.default_rng((seed, number, 1, *again)))


def demonstration(
    registry: Registry, expert: Expert, world: World, instance: Instance, seed: int, number: int
) -> tuple[RecordedDemonstration, int]:
    """Return a demonstration by the expert, from another placement, and how many attempts it took.

    Raises `NoDemonstration` where the expert fails again and again.
    """
    failed: list[FailedDemonstration] = []
    while len(failed) < ATTEMPTS:
        shown = demonstrate(registry, expert, world, instance, derived(seed, number, 2, len(failed)))
        if isinstance(shown, RecordedDemonstration):
            return shown, len(failed) + 1
        failed.append(shown)
    raise NoDemonstration(instance, failed[-1])


@dataclass(frozen=True)
class CarriedOut:
    """What came of a task that was carried out."""

    run: Run
    verdict: Verdict | None  # None where the goal is not known, so that nobody can judge
    wall_seconds: float
    simulated_seconds: float


def carry_out(
    registry: Registry,
    instance: Instance,
    policy: Policy,
    world: World,
    writer: TraceWriter,
    header: Header,
    seed: int,
    number: int,
    disturbances: Disturbances,
    watch: Watcher | None = None,
    on_frame: OnFrame | None = None,
    supervisor: Supervisor | None = None,
) -> CarriedOut:
    """Reset the world, run the task's program to its end, judge the result, and trace all of it."""
    scene = starting_scene(registry, instance, seed, number)
    writer.header(header)
    started = perf_counter()
    world.reset(scene, derived(seed, number, 3), disturbances)

    def frame(seen: Observation) -> None:
        at = writer.frame(world.time, seen)
        if on_frame is not None and (picture := on_frame(seen)):
            writer.picture(at, picture)

    world.on_frame = frame
    interpreter = Interpreter(
        registry,
        policy,
        world,
        writer,
        limits=Limits(primitives=enough_primitives(instance)),
        watch=watch,
        frame_number=lambda: writer.frames,
        supervisor=supervisor,
    )
    run = interpreter.run(instance.program, instance.arguments)
    world.on_frame = None
    wall, simulated = perf_counter() - started, world.time
    verdict = judge(registry, world, instance, scene, run) if instance.is_judged else None
    writer.end(_end(run, verdict))
    return CarriedOut(run, verdict, wall, simulated)


def _end(run: Run, verdict: Verdict | None) -> End:
    if verdict is None:
        return run.end()
    return with_fields(
        run.end(),
        success=verdict.success,
        attributed_to=verdict.attributed_to,
        verdict=verdict.reason,
    )
