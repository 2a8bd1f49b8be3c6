"""The package in Python: draw a task of a library, run a policy in a world, look at the trace.

    import ntp_dsl

    registry = ntp_dsl.load("block_stacking")
    task = ntp_dsl.draw(registry, "block_stacking", seed=3)
    shown = ntp_dsl.demonstrate(task)
    episode = ntp_dsl.run(task, ntp_dsl.learned_policy(task, shown))

What the command line does with a seed, this does with the same: the episode above is that of
`ntp run block_stacking block_stacking --seed 3 --world kinematic`.
"""

from __future__ import annotations

import io
from dataclasses import dataclass, replace
from numbers import Integral
from pathlib import Path
from typing import Any, TypeVar

from msgspec.structs import replace as with_fields

from ntp_dsl.common.text import counted
from ntp_dsl.datasets.recording import RecordedDemonstration, header
from ntp_dsl.demonstrations.demonstration import Demonstration, check_objects
from ntp_dsl.evaluation import episode_parts
from ntp_dsl.evaluation.demonstrated import as_demonstrated
from ntp_dsl.evaluation.success import Verdict
from ntp_dsl.execution.interpreter import Run
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.checked_policy import CheckedPolicy, kind_of
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.protocol import Policy
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.observation import SceneObject
from ntp_dsl.tasks.goal_samplers import Goal
from ntp_dsl.tasks.instances import Instance, find_task
from ntp_dsl.traces.reader import parse_trace
from ntp_dsl.traces.sources import library_sources
from ntp_dsl.traces.trace import Trace
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.catalogue import equip, make_world
from ntp_dsl.worlds.protocol import UNDISTURBED, Disturbances, Scene, World

Expected = TypeVar("Expected")

LARGEST_SEED = 2**63 - 1  # that a trace can state
DEFAULT_WORLD = "kinematic"
FIRST = 0  # the episode that commands carry out of a seed


@dataclass(frozen=True)
class Task:
    """A task that was drawn: its objects, its goal, and where it starts."""

    registry: Registry
    instance: Instance
    seed: int

    @property
    def name(self) -> str:
        return self.instance.name

    @property
    def objects(self) -> tuple[SceneObject, ...]:
        return self.instance.objects

    @property
    def goal(self) -> Goal:
        return self.instance.goal

    def scene(self) -> Scene:
        """Return where everything starts."""
        return episode_parts.starting_scene(self.registry, self.instance, self.seed, FIRST)

    def showing(self, demonstration: Demonstration) -> Task:
        """Return the same task with the goal that a demonstration states; without any where it states none.

        Such a task can be carried out; without a goal, nobody judges the result. Raises `NtpError` for a
        demonstration of other objects, and for a goal that is not one of this task.
        """
        return replace(self, instance=as_demonstrated(self.registry, self.instance, demonstration))

    def __repr__(self) -> str:
        goal = ", ".join(map(str, self.goal)) or "no goal is stated"
        return f"<Task {self.name} of {self.registry.name}, seed {self.seed}: {goal}>"


def draw(registry: Registry, task: str, seed: int = 0) -> Task:
    """Draw objects and goal of a declared task.

    Raises `NtpError` for a task that the library lacks, and for a seed that is not a whole number from 0.
    """
    declared = find_task(_expected(registry, Registry, "load"), task)
    seed = _whole(seed)
    return Task(registry, episode_parts.drawn_instance(registry, declared, seed, FIRST), seed)


def demonstrate(task: Task, world: World | str | None = None) -> RecordedDemonstration:
    """Let the expert show a task once, from another placement than the one in which it starts.

    Args:
        world: a world, or the name of one that ships; the kinematic one by default.

    Raises `NoDemonstration` where the expert fails again and again.
    """
    world = _equipped(world, _expected(task, Task, "draw").registry)
    expert = Expert(task.registry)
    shown, _ = episode_parts.demonstration(task.registry, expert, world, task.instance, task.seed, FIRST)
    return shown


def expert_policy(task: Task, shown: RecordedDemonstration | None = None) -> Policy:
    """Return the scripted expert.

    Args:
        shown: the demonstration that the scopes in its trace are frames of.
    """
    return ScriptedPolicy(Expert(task.registry), shown.calls if shown else None)


def learned_policy(
    task: Task, shown: RecordedDemonstration | Demonstration, model: Path | str | None = None
) -> Policy:
    """Return the learned program of one demonstration.

    Args:
        model: a checkpoint, of `ntp pretrain` or `ntp train`; by default the core that ships.

    Raises `NtpError` for a checkpoint that has not learnt the program, and for a demonstration of other
    objects.
    """
    from ntp_dsl.core.models import open_model
    from ntp_dsl.core.one_core import shipped_core

    given = shown.demonstration if isinstance(shown, RecordedDemonstration) else shown
    check_objects(_expected(given, Demonstration, "demonstrate or read_demonstration"), task.objects)
    path = Path(model) if model is not None else shipped_core()
    return open_model(path, task.registry, task.instance.program).shown(given)


@dataclass(frozen=True)
class Episode:
    """What came of a task that was carried out."""

    task: Task
    run: Run
    verdict: Verdict | None  # None where the task states no goal
    trace: Trace

    @property
    def success(self) -> bool | None:
        """Whether the strict test is passed: see `docs/results.md`; None where nobody can judge."""
        return self.verdict.success if self.verdict else None

    def __repr__(self) -> str:
        judged = "not judged"
        if self.verdict is not None:
            cause = f" ({self.verdict.attributed_to}: {self.verdict.reason})"
            judged = "success" if self.verdict.success else f"failure{cause}"
        return f"<Episode of {self.task.name}: {judged}, {counted(self.run.primitives, 'primitive')}>"


def run(
    task: Task,
    policy: Policy,
    world: World | str | None = None,
    disturbances: Disturbances = UNDISTURBED,
    on_frame: episode_parts.OnFrame | None = None,
) -> Episode:
    """Carry out a task.

    Args:
        policy: what decides; see `expert_policy`, `learned_policy` and the protocol `Policy`.
        world: where: the name of a world that ships, one of `make_world`, or your own `World`; the kinematic
            one by default.
        on_frame: called with the observation of every tenth of a second of the motion.
    """
    name = world or DEFAULT_WORLD if world is None or isinstance(world, str) else None
    world = _equipped(world, _expected(task, Task, "draw").registry)
    _expected(disturbances, Disturbances, "Disturbances")
    facts = with_fields(
        header(task.registry, task.instance, task.seed, kind_of(policy)),
        sources=library_sources(task.registry),
        episode=FIRST,
        world=name,
        disturbances=disturbances,
    )
    stream = io.StringIO()
    done = episode_parts.carry_out(
        task.registry,
        task.instance,
        CheckedPolicy(policy),
        world,
        TraceWriter(stream),
        facts,
        task.seed,
        FIRST,
        disturbances,
        on_frame=on_frame,
    )
    trace = parse_trace(stream.getvalue().encode(), Path(task.name))
    return Episode(task, done.run, done.verdict, trace)


def _expected(value: Any, kind: type[Expected], source: str) -> Expected:
    """Return a value that a caller gave. Raises `NtpError` where it is of another type."""
    if not isinstance(value, kind):
        raise NtpError(f"expected a {kind.__name__}, as {source} gives; found {value!r}")
    return value


def _whole(seed: Any) -> int:
    """Return a seed, of numpy's integers too. Raises `NtpError` where it is not a whole number from 0."""
    if not isinstance(seed, Integral) or isinstance(seed, bool) or not 0 <= int(seed) <= LARGEST_SEED:
        raise NtpError(f"expected a seed, a whole number from 0 to {LARGEST_SEED}; found {seed!r}")
    return int(seed)


def _equipped(world: World | str | None, registry: Registry) -> World:
    """Return a world that can do what a library declares."""
    if world is None or isinstance(world, str):
        return make_world(world or DEFAULT_WORLD, registry)
    equip(world, registry)
    return world


def picture(world: World, width: int = 400, height: int = 300) -> Any:
    """Return what a camera in front of the arm sees, as an image of Pillow; notebooks show it.

    Raises `NtpError` for a world that cannot be looked at, such as the kinematic one.
    """
    from PIL import Image

    render = getattr(world, "render", None)
    if render is None:
        raise NtpError("this world has no camera: one with an arm has, where PyBullet is installed")
    return Image.fromarray(render(width, height))
