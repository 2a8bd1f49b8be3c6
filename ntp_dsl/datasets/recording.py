"""Records demonstrations and labelled episodes from the expert, each in a placement of its own."""

from __future__ import annotations

import io
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from msgspec.structs import replace as with_fields

from ntp_dsl.common.seeds import derived
from ntp_dsl.datasets.labels import random_call
from ntp_dsl.demonstrations.demonstration import Demonstration, Origin, Recorder
from ntp_dsl.execution.interpreter import Interpreter, Limits, Run
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.scripted import ScriptedPolicy, demonstrated
from ntp_dsl.semantics.value_checks import OutOfRange
from ntp_dsl.tasks.instances import Instance, enough_primitives
from ntp_dsl.traces.reader import parse_trace
from ntp_dsl.traces.schema import (
    FORMAT,
    VERSION,
    DemonstratedCall,
    DemonstrationReference,
    Ending,
    Header,
    PolicyKind,
)
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.protocol import Disturbances, World

TROUBLE = 0.15  # how often, per primitive, a recorded episode slips, is pushed, or is led astray
LED_ASTRAY = 4  # primitives of a wrong program, at most


@dataclass(frozen=True)
class Shown:
    """A demonstration, and the calls that made it."""

    demonstration: Demonstration
    calls: DemonstratedCall | None = None  # None where it was brought from elsewhere

    def told(self, file: str) -> DemonstrationReference:
        """Return what a trace says of the demonstration; the file lies beside the trace."""
        return DemonstrationReference(file=file, frames=len(self.demonstration), calls=self.calls)


def demonstrate(
    registry: Registry, expert: Expert, world: World, instance: Instance, seed: int
) -> Shown | Run:
    """The expert, undisturbed, from a scattered placement; what went wrong if it fails."""
    rng = np.random.default_rng((seed, 0))
    scene = instance.scattered(rng)
    world.reset(scene, seed)
    recorder = Recorder(world)
    stream = io.StringIO()
    writer = TraceWriter(stream)
    writer.header(header(registry, instance, seed, PolicyKind.DEMONSTRATION))
    interpreter = Interpreter(
        registry,
        ScriptedPolicy(expert),
        world,
        writer,
        limits=Limits(primitives=enough_primitives(instance)),
        frame_number=lambda: len(recorder),
    )
    run = interpreter.run(instance.program, instance.arguments)
    world.on_frame = None
    if run.done and not len(recorder):
        run.ending, run.reason = Ending.UNFINISHED, "there is nothing to show: the goal holds from the start"
    if not run.done or run.failures:
        return run
    origin = Origin(library=registry.name, task=instance.name, seed=seed, goal=instance.goal)
    trace = parse_trace(stream.getvalue().encode(), Path("demonstration"))
    return Shown(recorder.demonstration(origin), demonstrated(trace))


def record_episode(
    registry: Registry,
    expert: Expert,
    world: World,
    instance: Instance,
    shown: Shown,
    seed: int,
    writer: TraceWriter,
    trouble: float = TROUBLE,
    demonstration_file: str = "",
) -> Run:
    """A labelled episode from another placement, with the trouble that recoveries are learnt from."""
    rng = np.random.default_rng((seed, 1))
    if trouble > 0 and rng.random() < 0.5:
        scene = instance.scrambled(rng, world.starts_holding)
    else:
        scene = instance.scattered(rng)
    world.reset(scene, derived(seed, 1), _troubles(trouble))
    told = header(registry, instance, seed, PolicyKind.SCRIPTED)
    writer.header(with_fields(told, demonstration=shown.told(demonstration_file)))
    recorder = Recorder(world)
    policy = ScriptedPolicy(expert, shown.calls)
    interpreter = Interpreter(
        registry,
        policy,
        world,
        writer,
        limits=Limits(primitives=enough_primitives(instance)),
        frame_number=lambda: len(recorder),
        interfere=_leader_astray(registry, expert, shown, rng, trouble),
    )
    run = interpreter.run(instance.program, instance.arguments)
    world.on_frame = None
    writer.end(run.end())
    return run


def _troubles(trouble: float) -> Disturbances:
    return Disturbances(slips=trouble, pushes=trouble, clumsiness=trouble)


def _leader_astray(
    registry: Registry, expert: Expert, shown: Shown, rng: np.random.Generator, trouble: float
) -> Callable[[World], None]:
    """Now and then runs a few primitives of a program that nobody asked for: wrong grasps, wrong towers."""

    def interfere(world: World) -> None:
        if rng.random() >= trouble:
            return
        program, arguments = random_call(expert, world.truth(), shown.calls, rng)
        limits = Limits(primitives=int(rng.integers(1, LED_ASTRAY + 1)), retries=0)
        with suppress(OutOfRange):  # a number at random, where a program says no range of its own
            Interpreter(registry, ScriptedPolicy(expert), world, limits=limits).run(program.name, arguments)

    return interfere


def header(registry: Registry, instance: Instance, seed: int, policy: PolicyKind) -> Header:
    """Return what a trace says of itself before the first call."""
    return Header(
        format=FORMAT,
        version=VERSION,
        library=registry.name,
        registry=registry.hash,
        task=instance.name,
        goal=instance.goal,
        program=instance.program,
        arguments=instance.arguments,
        seed=seed,
        policy=policy,
        objects=instance.objects,
    )
