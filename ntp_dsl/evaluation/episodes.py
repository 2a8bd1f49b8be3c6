"""Episodes: a task, a demonstration, a policy in a world, and a verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from msgspec.structs import replace as with_fields

from ntp_dsl.common.files import episode_files
from ntp_dsl.common.workers import in_order
from ntp_dsl.datasets.recording import RecordedDemonstration, header
from ntp_dsl.datasets.wording import in_words
from ntp_dsl.demonstrations.demonstration import noisy
from ntp_dsl.demonstrations.demonstration_files import write_demonstration
from ntp_dsl.evaluation.demonstrated import as_demonstrated
from ntp_dsl.evaluation.episode_parts import (
    ATTEMPTS,
    NoDemonstration,
    OnFrame,
    carry_out,
    demonstration,
    drawn_instance,
)
from ntp_dsl.evaluation.listening import as_lists, listener
from ntp_dsl.evaluation.scope_agreement import ScopeWatcher
from ntp_dsl.execution.interpreter import Watcher
from ntp_dsl.execution.supervision import Supervisor
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.evidence import rounded
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.protocol import Policy
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.sentences.understanding import Listener
from ntp_dsl.tasks.goal_text import Lists
from ntp_dsl.tasks.instances import Instance, as_told, find_task, from_file
from ntp_dsl.traces.decision import Dispatch
from ntp_dsl.traces.schema import Attribution, Header, PolicyKind
from ntp_dsl.traces.sources import library_sources
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.user_code.loading import load_with_python
from ntp_dsl.worlds.catalogue import equip, make_world
from ntp_dsl.worlds.habits import RATE, Person
from ntp_dsl.worlds.protocol import Disturbances


@dataclass(frozen=True)
class Plan:
    """The specification of an evaluation, which can be sent to worker processes."""

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
    arm: str | None = None  # of a world with one; None for the Panda
    dispatch: Dispatch | None = None  # of the one core; learned where None
    demo_noise: float = 0.0  # standard, of the positions that a demonstration shows [m]
    demo_by: Person | None = None  # a simulated person, by whose hand the expert demonstrates
    demo_rate: float = RATE  # of such a demonstration: frames a second
    whole_scopes: bool = False  # every program reads its lists from the whole demonstration
    spoken: bool = False  # each demonstration is put in words, and these are all that the program is told


@dataclass(frozen=True)
class GivenLists:
    """The lists of a task's program, in so many words, where nothing is demonstrated."""

    lists: Lists
    where: str  # they were told, for errors
    said: tuple[str, ...] = ()  # the sentences, if they were sentences
    probability: float = 1.0  # that the lists are what was meant


@dataclass(frozen=True)
class Episode:
    """The result of one episode. Wall times do not count in comparisons."""

    number: int
    name: str
    placements: int
    success: bool | None  # None where the demonstration states no goal, so that it cannot be judged
    success_authors: bool | None
    attributed_to: Attribution | None  # of a failure
    reason: str
    primitives: int
    simulated_seconds: float
    disturbances: int
    demonstrations: int  # attempts until one succeeded
    scopes: Mapping[str, Sequence[float]]  # of calls by callee: overlap with the expert's, 0 to 1
    confidence: float | None  # of the policy, that it has done what was shown
    wall_seconds: float = field(default=0.0, compare=False)
    deciding_seconds: float = field(default=0.0, compare=False)
    planning_seconds: float = field(default=0.0, compare=False)


class Evaluator:
    """The library, policy and world of one process. Episode n depends only on the plan and n."""

    def __init__(self, plan: Plan) -> None:
        if plan.traces is not None:
            plan.traces.mkdir(parents=True, exist_ok=True)
        self.plan = plan
        self.registry = load_with_python(plan.library)
        self.expert = Expert(self.registry)
        self.task = find_task(self.registry, plan.task)
        self.world = make_world(plan.world, self.registry, gui=plan.gui, arm=plan.arm)
        self._shown_in = self.world  # where tasks are demonstrated
        if plan.demo_by is not None:
            from ntp_dsl.worlds.people import PersonWorld  # as of any world, only where it is used

            self._shown_in = PersonWorld(plan.demo_by, plan.demo_rate)
            equip(self._shown_in, self.registry)
        self._file = from_file(self.registry, self.task, plan.tasks) if plan.tasks else []
        self._told: GivenLists | None = None
        self._model: Any = None  # a `Model` of the core, which needs torch
        if plan.model is not None:
            from ntp_dsl.core.models import open_model  # the expert needs no torch
            from ntp_dsl.core.per_library.training import use_threads

            use_threads(1)  # a decision is a small computation, and other cores are for other workers

            assert self.task.run is not None
            self._model = open_model(plan.model, self.registry, self.task.run.callee, plan.dispatch)

    @property
    def is_learned(self) -> bool:
        return self._model is not None

    def tell(self, told: GivenLists | None) -> None:
        """Let episodes run with lists that were told, in place of a drawn goal and its demonstration.

        Args:
            told: None for as they are drawn.
        """
        self._told = told

    def instance(self, number: int) -> Instance:
        """Return the instance of an episode: from the task file, cyclically, or drawn until work is left.

        What was told is in place of the drawn goal.
        """
        if self._file:
            return self._file[number % len(self._file)]
        varied = dict(self.plan.varied)
        drawn = drawn_instance(self.registry, self.task, self.plan.seed, number, varied)
        told = self._told
        return as_told(self.registry, drawn, told.lists, told.where) if told is not None else drawn

    def listener(self, number: int) -> Listener:
        """Return a listener for an episode's scene, and for the program as the model runs it."""
        registry: Registry = getattr(self._model, "registry", self.registry)
        return listener(registry, self.instance(number), self.plan.seed, number)

    def demonstration(self, instance: Instance, number: int) -> tuple[RecordedDemonstration, int]:
        """Return the expert's demonstration from another placement, and the number of attempts.

        Raises `NoDemonstration` where all attempts fail; the episode's trace is that of the last one then.
        """
        seed, sigma = self.plan.seed, self.plan.demo_noise
        try:
            found, attempts = demonstration(
                self.registry, self.expert, self._shown_in, instance, seed, number
            )
        except NoDemonstration as failure:
            if self.plan.traces is not None:
                own = self._header(instance, number, None)
                failure.write_trace(episode_files(self.plan.traces, number)[0], own)
            raise
        if sigma:
            seen = noisy(found.demonstration, sigma, np.random.default_rng((seed, number, 4)))
            found = replace(found, demonstration=seen)
        return found, attempts

    def _in_words(self, instance: Instance, number: int) -> tuple[GivenLists, int]:
        """Return what the sentences for a demonstration say, and the number of attempts at it."""
        recorded, attempts = self.demonstration(instance, number)
        assert recorded.calls is not None
        said = in_words(self.registry, recorded.calls)
        understood = self.listener(number).understand(said)
        lists = as_lists(self.registry, instance.program, understood.arguments)
        return GivenLists(lists, "the sentences", tuple(said), understood.probability), attempts

    def policy(self, recorded: RecordedDemonstration | None) -> Policy:
        """Return the policy: learned for a demonstration, or scripted, with the demonstration's scopes."""
        if self._model is None:
            return ScriptedPolicy(self.expert, recorded.calls if recorded else None)
        if recorded is None:
            told: Policy = self._model.told(self._told.probability if self._told is not None else 1.0)
            return told
        shown: Policy = self._model.shown(recorded.demonstration, self.plan.whole_scopes)
        return shown

    def episode(
        self,
        number: int,
        recorded: RecordedDemonstration | None = None,
        watch: Watcher | None = None,
        on_frame: OnFrame | None = None,
        policy: Policy | None = None,
        supervisor: Supervisor | None = None,
    ) -> Episode:
        """Run and judge an episode.

        Args:
            recorded: the demonstration to use, with its goal; else the expert records one.
            watch: follows the calls.
            on_frame: called at every frame of the world.
            policy: the one of the demonstration, by default.
            supervisor: may stop it before a decision is carried out, and force outcomes.
        """
        instance = self.instance(number)
        attempts = 0
        if recorded is not None:
            instance = as_demonstrated(self.registry, instance, recorded.demonstration)
        elif self.plan.spoken:
            self._told = None
            instance = self.instance(number)
            try:
                self._told, attempts = self._in_words(instance, number)
                told = as_told(self.registry, instance, self._told.lists, self._told.where)
            except NoDemonstration as failure:
                return _without_demonstration(number, instance, failure)
            except NtpError as failure:
                return _not_begun(number, instance, Attribution.DECISION, str(failure), attempts)
            instance = replace(
                told, goal=instance.goal, bindings=instance.bindings
            )  # judged by what was meant
        elif self._told is None and (self.is_learned or self.plan.traces is not None):
            try:
                recorded, attempts = self.demonstration(instance, number)
            except NoDemonstration as failure:
                if self.is_learned:
                    return _without_demonstration(number, instance, failure)
        shown = recorded.calls if recorded is not None and self.is_learned else None
        scopes = ScopeWatcher(shown, watch) if shown is not None else None
        with traced(self.plan.traces, number) as writer:
            done = carry_out(
                self.registry,
                instance,
                policy if policy is not None else self.policy(recorded),
                self.world,
                writer,
                self._header(instance, number, recorded),
                self.plan.seed,
                number,
                self.plan.disturbances,
                scopes or watch,
                on_frame,
                supervisor,
            )
        run, verdict = done.run, done.verdict
        return Episode(
            number,
            instance.name,
            len(instance.goal),
            verdict.success if verdict else None,
            verdict.success_authors if verdict else None,
            verdict.attributed_to if verdict else None,
            verdict.reason if verdict else str(run),
            run.primitives,
            round(done.simulated_seconds, 3),
            run.disturbances,
            attempts if self.is_learned else 0,
            scopes.overlaps if scopes is not None else {},
            run.confidence,
            done.wall_seconds,
            run.deciding_seconds,
            run.planning_seconds,
        )

    def _header(self, instance: Instance, number: int, recorded: RecordedDemonstration | None) -> Header:
        """Return the header of a trace, and write the demonstration beside the trace."""
        kind = PolicyKind.LEARNED if self.is_learned else PolicyKind.SCRIPTED
        reference = None
        if recorded is not None and self.plan.traces is not None:
            _, path = episode_files(self.plan.traces, number)
            write_demonstration(recorded.demonstration, path)
            by, rate = self.plan.demo_by, self.plan.demo_rate
            reference = with_fields(
                recorded.trace_record(path.name),
                noise=self.plan.demo_noise,
                by=by or "",
                rate=rate if by else None,
            )
        return with_fields(
            header(self.registry, instance, self.plan.seed, kind),
            demonstration=reference,
            said=self._told.said if self._told is not None else (),
            understood=rounded(self._told.probability) if self._told is not None else 1.0,
            sources=library_sources(self.registry),
            episode=number,
            world=self.plan.world,
            arm=self.plan.arm,
            model=str(self.plan.model) if self.plan.model else None,
            training=self._model.training if self.is_learned else "",
            dispatch=(self.plan.dispatch or Dispatch.LEARNED) if self.is_learned else None,
            disturbances=self.plan.disturbances,
        )


@contextmanager
def traced(folder: Path | None, number: int) -> Iterator[TraceWriter]:
    """Open the writer of an episode's trace; without a folder, nothing is written."""
    path = episode_files(folder, number)[0] if folder else None
    with path.open("w", encoding="utf-8") if path else nullcontext() as stream:
        yield TraceWriter(stream)


def _without_demonstration(number: int, instance: Instance, failure: NoDemonstration) -> Episode:
    """Return the failed episode of a task that could not be demonstrated."""
    return _not_begun(number, instance, failure.attributed_to, str(failure), ATTEMPTS)


def _not_begun(
    number: int, instance: Instance, attributed_to: Attribution, reason: str, demonstrations: int
) -> Episode:
    return Episode(
        number,
        instance.name,
        len(instance.goal),
        False,
        False,
        attributed_to,
        reason,
        primitives=0,
        simulated_seconds=0.0,
        disturbances=0,
        demonstrations=demonstrations,
        scopes={},
        confidence=None,
    )


def run_all(plan: Plan, episodes: int, workers: int) -> Iterator[Episode]:
    """Yield the episodes in order, independently of the number of workers."""
    return in_order(partial(_open, plan), episodes, workers)


def _open(plan: Plan) -> Callable[[int], Episode]:
    return Evaluator(plan).episode
