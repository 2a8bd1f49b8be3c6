"""The package in Python: load a library, draw a task, run a policy in a world, look at the trace.

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
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

from msgspec.structs import replace as with_fields

from ntp_dsl.common.text import counted
from ntp_dsl.datasets.recording import RecordedDemonstration, header
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.evaluation import episode_parts
from ntp_dsl.evaluation.demonstrated import as_demonstrated
from ntp_dsl.evaluation.success import Verdict
from ntp_dsl.execution.interpreter import Run
from ntp_dsl.graph import calls
from ntp_dsl.graph.picture import CallPicture
from ntp_dsl.language import loader
from ntp_dsl.language.checker import Report
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.protocol import Policy
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.observation import SceneObject
from ntp_dsl.tasks.goal_samplers import Goal
from ntp_dsl.tasks.instances import Instance, find_task
from ntp_dsl.traces.reader import parse_trace
from ntp_dsl.traces.schema import PolicyKind
from ntp_dsl.traces.sources import library_sources
from ntp_dsl.traces.trace import Trace
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.user_code.loading import with_functions, with_python
from ntp_dsl.worlds.catalogue import equip, make_world
from ntp_dsl.worlds.protocol import UNDISTURBED, Disturbances, Scene, World

Expected = TypeVar("Expected")

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
        return episode_parts.starting_scene(self.instance, self.seed, FIRST)

    def showing(self, demonstration: Demonstration) -> Task:
        """Return the same task with the goal that a demonstration states; without any where it states none.

        Such a task can be carried out; without a goal, nobody judges the result. Raises `NtpError` for a
        demonstration of other objects, and for a goal that is not one of this task.
        """
        return replace(self, instance=as_demonstrated(self.registry, self.instance, demonstration))

    def __repr__(self) -> str:
        goal = ", ".join(map(str, self.goal)) or "no goal is stated"
        return f"<Task {self.name} of {self.registry.name}, seed {self.seed}: {goal}>"


def load(path: Path | str) -> Registry:
    """Load a library, and its Python, from an `.ntp` file, a folder with one, or an example's name.

    Raises `SourceError`, which carries every diagnostic, where it is not sound.
    """
    return with_python(loader.load(path))


def load_text(
    text: str, functions: Sequence[Callable[..., Any]] = (), path: Path | str | None = None
) -> Registry:
    """Load a library from a string.

    Args:
        functions: what the library leaves to Python: functions marked with `@expert`, `@predicate`, `@skill`
            or `@sampler`.
        path: where the text belongs: diagnostics name it, and `use` looks beside it. It is not opened.

    Raises `SourceError`, which carries every diagnostic, where it is not sound.
    """
    return with_functions(loader.load_text(text, path), functions)


def diagnose(path: Path | str) -> Report:
    """Check a library without its Python: an `.ntp` file, a folder with one, or an example's name."""
    return loader.diagnose(loader.find(path))


def call_graph(registry: Registry, program: str | None = None) -> CallPicture:
    """Return who calls whom in a library, as a picture.

    Args:
        program: shows this one and what it calls, and no other.
    """
    return CallPicture(calls.call_graph(registry, program))


def draw(registry: Registry, task: str, seed: int = 0) -> Task:
    """Draw objects and goal of a declared task. Raises `NtpError` for a task that the library lacks."""
    declared = find_task(registry, task)
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
        model: a checkpoint; by default the shipped one that fits.

    Raises `NtpError` where no checkpoint has learnt the task's program.
    """
    from ntp_dsl.core.checkpoint import check_fits, load_core
    from ntp_dsl.core.policy import LearnedPolicy
    from ntp_dsl.core.shipped import shipped_checkpoint

    program = task.instance.program
    path = Path(model) if model is not None else shipped_checkpoint(task.registry, program)
    if path is None:
        raise NtpError(
            f"no shipped checkpoint knows '{program}' as '{task.registry.name}' declares it; "
            "`ntp record` and `ntp train` make one, which `model` then names"
        )
    core = load_core(path).core
    check_fits(core.memory, task.registry, program, path)
    given = shown.demonstration if isinstance(shown, RecordedDemonstration) else shown
    return LearnedPolicy(core, _expected(given, Demonstration, "demonstrate or read_demonstration"))


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
    world = _equipped(world, _expected(task, Task, "draw").registry)
    _expected(disturbances, Disturbances, "Disturbances")
    if not (hasattr(policy, "root") and hasattr(policy, "decide")):
        raise NtpError(f"expected a policy, as learned_policy gives; found {policy!r}")
    stream = io.StringIO()
    kind = getattr(policy, "kind", PolicyKind.CUSTOM)
    facts = header(task.registry, task.instance, task.seed, kind)
    done = episode_parts.carry_out(
        task.registry,
        task.instance,
        policy,
        world,
        TraceWriter(stream),
        with_fields(facts, sources=library_sources(task.registry), disturbances=disturbances),
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


def _equipped(world: World | str | None, registry: Registry) -> World:
    """Return a world that can do what a library declares."""
    if world is None or isinstance(world, str):
        return make_world(world or "kinematic", registry)
    equip(world, registry)
    return world


def picture(world: World, width: int = 400, height: int = 300) -> Any:
    """Return what a camera in front of the arm sees, as an image of Pillow; notebooks show it.

    Raises `NtpError` for a world that cannot be looked at, such as the kinematic one.
    """
    from PIL import Image

    render = getattr(world, "render", None)
    if render is None:
        raise NtpError("this world has no camera; the bullet world has")
    return Image.fromarray(render(width, height))
