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
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.scripted import ScriptedPolicy, demonstrated
from ntp_dsl.semantics.attempts import reads_failures
from ntp_dsl.semantics.shortfalls import why_not
from ntp_dsl.semantics.state import State
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
from ntp_dsl.worlds.protocol import Disturbances, Scene, World

PERTURBATION_RATE = 0.15  # per primitive: slips, pushes, misses and wrong subprograms
PLACEMENTS = 20  # of which a demonstration begins from one
WRONG_PRIMITIVES = 4  # primitives of a wrong program, at most


@dataclass(frozen=True)
class RecordedDemonstration:
    """A demonstration, and the calls that made it."""

    demonstration: Demonstration
    calls: DemonstratedCall | None = None  # None where it was brought from elsewhere

    def trace_record(self, file: str) -> DemonstrationReference:
        """Return the trace's record of the demonstration; the file lies beside the trace."""
        return DemonstrationReference(file=file, frames=len(self.demonstration), calls=self.calls)


@dataclass(frozen=True)
class FailedDemonstration:
    """A run of the expert that did not bring the goal about, with the trace of it."""

    run: Run
    trace: str  # its lines, without the header and the end
    lacking: str  # that a fact of the goal does not hold at the end, in words; empty where all do

    def __str__(self) -> str:
        if self.run.done:
            return f"a call of the expert failed{self.run.last_message}"
        lacking = f"{self.lacking}; " if self.lacking else ""
        return f"{lacking}{self.run}{self.run.last_message}"


def demonstration_start(registry: Registry, instance: Instance, seed: int) -> Scene:
    """Return the placement from which a task is demonstrated.

    What holds from the start is not shown by bringing it about: of a few placements that is the first from
    which all parts of the goal are shown, or else the one from which most are.
    """
    best, most = None, -1
    for attempt in range(PLACEMENTS):
        again = (attempt,) if attempt else ()
        try:
            scene = instance.nominal_start(np.random.default_rng((seed, 0, *again)))
        except NtpError:  # there was no room this time
            if best is None:
                raise
            continue
        shown = instance.shown_by(registry, scene)
        if shown > most:
            best, most = scene, shown
        if most == instance.parts:
            break
    assert best is not None
    return best


def demonstrate(
    registry: Registry, expert: Expert, world: World, instance: Instance, seed: int
) -> RecordedDemonstration | FailedDemonstration:
    """Record the expert, undisturbed, from a nominal start."""
    world.reset(demonstration_start(registry, instance, seed), seed)
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
        expert=expert,
    )
    run = interpreter.run(instance.program, instance.arguments)
    world.on_frame = None
    if run.done and not run.primitives:
        run.ending, run.reason = (
            Ending.UNFINISHED,
            "the program did nothing, as all that it is to achieve held",
        )
    may_fail = reads_failures(registry) and all(each.is_failed_attempt for each in run.failures)
    if not run.done or (run.failures and not may_fail):
        end = world.truth()
        state = State(registry, end)
        lacking = (why_not(each, state) for each in instance.literals(registry, end) if not state.holds(each))
        _, _, lines = stream.getvalue().partition("\n")
        return FailedDemonstration(run, lines, next(lacking, ""))
    origin = Origin(library=registry.name, task=instance.name, seed=seed, goal=instance.goal)
    trace = parse_trace(stream.getvalue().encode(), Path("demonstration"))
    return RecordedDemonstration(recorder.demonstration(origin), demonstrated(trace))


def record_episode(
    registry: Registry,
    expert: Expert,
    world: World,
    instance: Instance,
    shown: RecordedDemonstration,
    seed: int,
    writer: TraceWriter,
    perturbation_rate: float = PERTURBATION_RATE,
    demonstration_file: str = "",
) -> Run:
    """Record a labelled episode from another start, with perturbations, so that recoveries are learnt."""
    rng = np.random.default_rng((seed, 1))
    if perturbation_rate > 0 and rng.random() < 0.5:
        scene = instance.perturbed_start(rng, world.starts_holding)
    else:
        scene = instance.nominal_start(rng)
    world.reset(scene, derived(seed, 1), _disturbances(perturbation_rate))
    own = header(registry, instance, seed, PolicyKind.SCRIPTED)
    writer.header(with_fields(own, demonstration=shown.trace_record(demonstration_file)))
    recorder = Recorder(world)
    policy = ScriptedPolicy(expert, shown.calls)
    interpreter = Interpreter(
        registry,
        policy,
        world,
        writer,
        limits=Limits(primitives=enough_primitives(instance)),
        frame_number=lambda: len(recorder),
        interfere=_inject_wrong_subprogram(registry, expert, shown, rng, perturbation_rate),
        expert=expert,
    )
    run = interpreter.run(instance.program, instance.arguments)
    world.on_frame = None
    writer.end(run.end())
    return run


def _disturbances(rate: float) -> Disturbances:
    return Disturbances(slips=rate, pushes=rate, clumsiness=rate)


def _inject_wrong_subprogram(
    registry: Registry,
    expert: Expert,
    shown: RecordedDemonstration,
    rng: np.random.Generator,
    perturbation_rate: float,
) -> Callable[[World], None]:
    """Return an interference that runs, at random, a few primitives of a wrong program."""

    def interfere(world: World) -> None:
        if rng.random() >= perturbation_rate:
            return
        program, arguments = random_call(expert, world.truth(), shown.calls, rng)
        limits = Limits(primitives=int(rng.integers(1, WRONG_PRIMITIVES + 1)), retries=0)
        with suppress(OutOfRange):  # by a random number, where a program declares no range
            Interpreter(registry, ScriptedPolicy(expert), world, limits=limits).run(program.name, arguments)

    return interfere


def header(registry: Registry, instance: Instance, seed: int, policy: PolicyKind) -> Header:
    """Return the header of a trace."""
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
