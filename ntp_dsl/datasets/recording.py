"""Records demonstrations and labelled episodes from the expert, each in a placement of its own."""

from __future__ import annotations

import io
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ntp_dsl.common.seeds import derived
from ntp_dsl.datasets.labels import random_call
from ntp_dsl.demonstrations.demonstration import Demonstration, Recorder
from ntp_dsl.execution.interpreter import Interpreter, Limits, Run
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.scripted import DemonstratedCall, ScriptedPolicy, demonstrated
from ntp_dsl.semantics.value_checks import OutOfRange
from ntp_dsl.tasks.instances import Instance, enough_primitives
from ntp_dsl.traces.reader import parse_trace
from ntp_dsl.traces.schema import to_json
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.protocol import Disturbances, World

TROUBLE = 0.15  # how often, per primitive, a recorded episode slips, is pushed, or is led astray
LED_ASTRAY = 4  # primitives of a wrong program, at most


@dataclass(frozen=True)
class Shown:
    """A demonstration, and the calls that made it."""

    demonstration: Demonstration
    calls: DemonstratedCall | None = None  # None where it was brought from elsewhere

    def facts(self, file: str) -> dict[str, Any]:
        """What a trace says of the demonstration that its scopes are frames of; the file lies beside it."""
        calls = self.calls.to_json() if self.calls else None
        return {"file": file, "frames": len(self.demonstration), "calls": calls}


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
    writer.header(**header(registry, instance, seed, "demonstration"))
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
        run.done, run.reason = False, "there is nothing to show: the goal holds from the start"
    if not run.done or run.failures:
        return run
    goal = [dict(placement.fields) for placement in instance.goal]
    notes = {"task": instance.name, "library": registry.name, "seed": seed, "goal": goal}
    trace = parse_trace(stream.getvalue().encode(), Path("demonstration"))
    return Shown(recorder.demonstration(notes), demonstrated(trace))


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
    facts = header(registry, instance, seed, "scripted")
    writer.header(**facts, demonstration=shown.facts(demonstration_file))
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
    writer.end(done=run.done, reason=run.reason, primitives=run.primitives)
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


def header(registry: Registry, instance: Instance, seed: int, policy: str) -> dict[str, Any]:
    """What a trace says of itself before the first call; `demonstration` and others may follow."""
    return {
        "library": registry.name,
        "registry": registry.hash,
        "task": instance.name,
        "goal": [dict(record.fields) for record in instance.goal],
        "program": instance.program,
        "arguments": [to_json(argument) for argument in instance.arguments],
        "seed": seed,
        "policy": policy,
        "things": [asdict(thing) for thing in instance.things],
    }
