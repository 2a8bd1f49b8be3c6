"""Trials: an expert's run from one start, what came of it, and its trace."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial
from io import StringIO

from msgspec.structs import replace as with_fields

from ntp_dsl.common.text import listed
from ntp_dsl.dynamic.stuck import MOST, Stuck, stuck
from ntp_dsl.dynamic.trial_traces import header, write_frame
from ntp_dsl.dynamic.watching import Livelock, NondeterministicExpert, WatchedPolicy
from ntp_dsl.execution.interpreter import Interpreter, Limits, Run
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax.nodes import Span
from ntp_dsl.policies.expert import Expert
from ntp_dsl.semantics.facts import Fact
from ntp_dsl.semantics.observation import Observation
from ntp_dsl.semantics.shortfalls import why_not
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import Instance, enough_primitives
from ntp_dsl.traces.failure_attribution import ATTRIBUTION_OF_OUTCOME
from ntp_dsl.traces.schema import (
    Attribution,
    CallOutcome,
    End,
    Ending,
    Header,
)
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.protocol import World

Fault = Livelock | NondeterministicExpert | NtpError


@dataclass(frozen=True)
class Trial:
    """A run of an instance's program, until it ended or a fault of the expert was found."""

    expert: Expert
    instance: Instance
    start: str  # its kind
    number: int
    first: Observation  # the true states at both ends
    last: Observation
    policy: WatchedPolicy
    run: Run
    fault: Fault | None
    trace: str = ""  # its text, where it was asked for

    @cached_property
    def unmet(self) -> list[Fact]:
        """The conditions of success that do not hold at the end."""
        return self.unmet_in(self.last)

    def unmet_in(self, seen: Observation) -> list[Fact]:
        """Return the conditions of success that do not hold in a state."""
        state = State(self.expert.registry, seen)
        return [fact for fact in self.facts_in(seen) if not state.holds(fact)]

    @property
    def lacking(self) -> str:
        """What success lacks at the end, in words, and of a single fact why it does not hold; or nothing."""
        if len(self.unmet) == 1:
            return why_not(self.unmet[0], State(self.expert.registry, self.last))
        return f"{listed(self.unmet, MOST)} do not hold" if self.unmet else ""

    def facts_in(self, seen: Observation) -> list[Fact]:
        """Return the conditions of success."""
        return self.instance.literals(self.expert.registry, seen)

    @property
    def is_failed(self) -> bool:
        """Whether it shows a mistake; without one of its objects, the expert need only end."""
        return self.fault is not None or bool(self.unmet) and self.start != "missing object"

    @property
    def deadlock(self) -> Stuck | None:
        """The deadlock in which the run ended unfinished."""
        return self.policy.deadlocks[-1][1] if self.policy.deadlocks and self.run.gave_up else None

    @cached_property
    def end(self) -> Stuck:
        """The state of the root call at the end."""
        state = State(self.expert.registry, self.last)
        return stuck(self.expert, self.instance.program, self.instance.arguments, state)


class Trials:
    """Runs experts of one registry in one world.

    Args:
        traced: whether trials keep their traces.
    """

    def __init__(self, registry: Registry, world: World, seed: int, traced: bool = False) -> None:
        self.registry, self.world, self.seed = registry, world, seed
        self.expert = Expert(registry)
        self.called: set[str] = set()  # programs and apis, in all trials so far
        self.followed: set[Span] = set()  # statements that made a call
        self._traced = traced

    def run(self, instance: Instance, start: str, number: int, limit: int | None = None) -> Trial:
        """Run the instance's program in the world as it is.

        Args:
            limit: number of primitives after which it is stopped.
        """
        first, policy, text = self.world.truth(), WatchedPolicy(self.expert), StringIO()
        writer = TraceWriter(text if self._traced else None)
        if self._traced:
            writer.header(self._header(instance, number))
            self.world.on_frame = partial(write_frame, writer, self.world)
        interpreter = Interpreter(
            self.registry,
            policy,
            self.world,
            writer,
            Limits(primitives=limit or enough_primitives(instance), retries=1),
            policy.watch,
            lambda: writer.frames,
            expert=self.expert,
        )
        run, fault = Run(), None
        try:
            run = interpreter.run(instance.program, instance.arguments)
        except (Livelock, NondeterministicExpert, NtpError) as error:
            fault = error
        finally:
            self.world.on_frame = None
        self.called |= {instance.program, *(each.callee for each in policy.decisions)}
        self.followed |= {each.span for each in policy.decisions}
        last = self.world.truth()
        trial = Trial(self.expert, instance, start, number, first, last, policy, run, fault)
        if not self._traced or not trial.is_failed:
            return trial
        writer.end(_end(trial))
        return replace(trial, trace=text.getvalue())

    def _header(self, instance: Instance, number: int) -> Header:
        head = header(self.registry, instance, instance.program, instance.arguments)
        return with_fields(head, goal=instance.goal, seed=self.seed, episode=number)


def _end(trial: Trial) -> End:
    """Return the trace's record of a trial's end; a run that a fault stopped has none of its own."""
    match trial.fault:
        case None:
            return with_fields(
                trial.run.end(),
                success=not trial.unmet,
                attributed_to=_cause(trial) if trial.unmet else None,
                verdict=trial.lacking,
            )
        case Livelock():
            ending, reason = Ending.CIRCULAR, "the same states recur"
        case NondeterministicExpert():
            ending, reason = Ending.STOPPED, f"'{trial.fault.program}' decides differently when asked again"
        case NtpError():
            ending, reason = Ending.STOPPED, str(trial.fault)
    apis = trial.expert.registry.apis
    return End(
        ending=ending,
        reason=reason,
        primitives=sum(each.callee in apis for each in trial.policy.decisions),
        success=False,
        attributed_to=_cause(trial),
        verdict=reason,
    )


def _cause(trial: Trial) -> Attribution:
    """Return what a failure is attributed to: what the world refused last, or else the expert's decisions."""
    if trial.run.done or not trial.policy.refused:
        return Attribution.DECISION
    _, (_, _, why) = trial.policy.refused[-1]
    return ATTRIBUTION_OF_OUTCOME.get(CallOutcome(why), Attribution.DECISION)
