"""Runs a program: a stack of calls, a policy that decides, a world that carries out the primitives."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

from ntp_dsl.execution.refusals import Call, Refusals, differ
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.protocol import Barred, Choice, Frame, Policy
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.traces.schema import ROOT
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.protocol import Failure, Outcome, World

MAX_DEPTH = 48
CONFIRMATIONS = 2  # a root must say «done» of so many observations in a row
SECOND_LOOK = 0.5  # [s] between them: what is falling has fallen


@dataclass
class Limits:
    """A run ends after so many primitives, or so many decisions between two of them."""

    primitives: int = 150
    idle_decisions: int = 60
    retries: int = 5  # how often an unfinished root is asked again
    like_failures: int = 8  # primitives that fail alike, in a row


@dataclass
class Run:
    """What came of running a program to its end."""

    done: bool = False
    reason: str = ""
    primitives: int = 0
    deciding_seconds: float = 0.0  # wall, as all three
    planning_seconds: float = 0.0
    moving_seconds: float = 0.0
    disturbances: int = 0
    failures: list[Outcome] = field(default_factory=list)
    failing: int = 0  # the same failure so often in a row
    handled: set[Argument] = field(default_factory=set)  # what primitives were called on
    changes: int = 0  # of the world, by primitives
    in_vain: Refusals = field(default_factory=Refusals)


Watcher = Callable[[str, int, str, tuple[Argument, ...], Any], None]  # event, depth, name, …, detail
Interference = Callable[[World], None]  # after a primitive: what a recorder does to make trouble


class Interpreter:
    """Executes one root call. Ancestors are not consulted while a call runs."""

    def __init__(
        self,
        registry: Registry,
        policy: Policy,
        world: World,
        writer: TraceWriter | None = None,
        limits: Limits | None = None,
        watch: Watcher | None = None,
        frame_number: Callable[[], int] = lambda: 0,
        interfere: Interference | None = None,
    ) -> None:
        self.registry, self.policy, self.world = registry, policy, world
        self.writer = writer or TraceWriter()
        self.limits = limits or Limits()
        self.watch = watch or (lambda *_: None)
        self.frame_number = frame_number
        self.interfere = interfere

    def run(self, program: str, arguments: tuple[Argument, ...]) -> Run:
        run = Run()
        confirmed = retries = 0
        while not run.reason:
            before = run.primitives
            done = self._run_root(self.policy.root(program, arguments), run)
            confirmed = confirmed + 1 if done and run.primitives == before else int(done)
            if run.reason:
                break
            if confirmed >= CONFIRMATIONS:
                run.done, run.reason = True, "done"
                break
            if not done:
                retries += 1
                if retries > self.limits.retries:
                    run.reason = "unfinished: nothing that the program knows helps"
            self.world.settle(SECOND_LOOK)
        return run

    def _run_root(self, root: Frame, run: Run) -> bool:
        """One pass from the root to its return; true where it says «done»."""
        stack = [(root, self._enter(root, ROOT, {}, self.world.truth()), run.changes)]
        idle, fresh = 0, True  # fresh: the top of the stack has just been called
        while True:
            frame, number, changes = stack[-1]
            idle += 1
            run.reason = self._stop(idle, len(stack), run)
            if run.reason:
                for _, open_call, _ in reversed(stack):
                    self.writer.returned(open_call, "stopped", self.frame_number())
                return False
            choice = self._decide(frame, run, fresh and len(stack) > 1)
            fresh = False
            if choice.callee is None:
                self._leave(number, len(stack), frame, choice)
                stack.pop()
                if not stack:
                    return choice.done
                if run.changes == changes:
                    call = frame.program, frame.arguments
                    run.in_vain.add(call, self.world.truth(), failed=not choice.done)
            elif choice.callee in self.registry.apis:
                idle = 0
                self._execute(choice, number, len(stack), run)
            else:
                child = Frame(choice.callee, choice.arguments, choice.scope, choice.matched)
                entered = self._enter(child, number, choice.details, choice.seen, len(stack))
                stack.append((child, entered, run.changes))
                fresh = True

    def _stop(self, idle: int, depth: int, run: Run) -> str:
        """Why a run that gets nowhere is broken off, or nothing."""
        last = run.failures[-self.limits.like_failures :]
        if len(last) == self.limits.like_failures and run.failing == len(last):
            return f"stopped: {last[-1].failure} {len(last)} times in a row"
        if idle > self.limits.idle_decisions:
            return f"stopped: {idle} decisions without a primitive"
        if depth > MAX_DEPTH:
            return f"stopped at a depth of {depth} calls"
        if run.primitives >= self.limits.primitives:
            return f"stopped after {run.primitives} primitives"
        return ""

    def _decide(self, frame: Frame, run: Run, fresh: bool) -> Choice:
        """What the language forbids is not chosen: a return at the first step, a call in vain.

        A program to which nothing is left because calls failed is unfinished.
        """
        start = perf_counter()
        barred: Barred = frozenset({None} if fresh else ())
        choice = self.policy.decide(frame, self.world, barred)
        refused = False
        while choice.callee not in barred and self._is_vain((choice.callee, choice.arguments), run):
            refused |= run.in_vain.failed((choice.callee, choice.arguments), self.world.truth())
            barred |= {choice.callee}
            choice = self.policy.decide(frame, self.world, barred)
        if choice.callee is None and refused:
            choice = replace(choice, done=False)
        seconds = perf_counter() - start
        run.deciding_seconds += seconds
        source = self.registry.programs[frame.program].line(choice.callee)
        details = {"source": source, **choice.details, "seconds": round(seconds, 5)}
        return replace(choice, details=details)

    def _is_vain(self, call: Call, run: Run) -> bool:
        return call in run.in_vain and run.in_vain.bars(call, self.world.truth())

    def _enter(
        self,
        frame: Frame,
        parent: int,
        details: Mapping[str, Any],
        seen: Observation | None,
        depth: int = 0,
    ) -> int:
        self.watch("call", depth, frame.program, frame.arguments, frame.scope)
        return self._write_call(parent, "program", frame.program, frame, details, seen)

    def _write_call(
        self,
        parent: int,
        kind: str,
        name: str,
        given: Frame | Choice,
        details: Mapping[str, Any],
        seen: Observation | None,
    ) -> int:
        state, frame = self._state(seen), self.frame_number()
        return self.writer.call(parent, kind, name, given.arguments, given.scope, frame, state, details)

    def _state(self, seen: Observation | None) -> int:
        """What was decided by; for a policy that does not say, what is there."""
        return self.writer.state(self.world.truth() if seen is None else seen)

    def _leave(self, number: int, depth: int, frame: Frame, choice: Choice) -> None:
        outcome = "done" if choice.done else "unfinished"
        self.watch("return", depth - 1, frame.program, frame.arguments, outcome)
        state = self._state(choice.seen)
        frame_number = self.frame_number()
        self.writer.returned(number, outcome, frame_number, state=state, decision=choice.details)

    def _execute(self, choice: Choice, parent: int, depth: int, run: Run) -> None:
        assert choice.callee is not None
        self.watch("call", depth, choice.callee, choice.arguments, choice.scope)
        number = self._write_call(parent, "api", choice.callee, choice, choice.details, choice.seen)
        before = self.world.truth()
        outcome = self.world.call(choice.callee, choice.arguments)
        run.primitives += 1
        run.handled |= set(choice.arguments)
        run.planning_seconds += outcome.planning_seconds
        run.moving_seconds += outcome.moving_seconds
        run.disturbances += len(outcome.disturbances)
        after = self.world.truth()
        if differ(before, after):
            run.changes += 1
        else:
            by_chance = not outcome.achieved and outcome.failure is not Failure.NOT_READY
            call = choice.callee, choice.arguments
            run.in_vain.add(call, after, failed=not outcome.achieved, by_chance=by_chance)
        if outcome.achieved:
            run.failing = 0
        else:
            same = bool(run.failures) and run.failures[-1].failure is outcome.failure
            run.failing = run.failing + 1 if same else 1
            run.failures.append(outcome)
        word = "achieved" if outcome.achieved else str(outcome.failure)
        self.watch("return", depth, choice.callee, choice.arguments, word)
        self.writer.returned(
            number,
            word,
            self.frame_number(),
            planning=round(outcome.planning_seconds, 5),
            moving=round(outcome.moving_seconds, 5),
            solver=outcome.solver,
            planner=outcome.planner,
            evidence=dict(outcome.evidence),
            disturbances=list(outcome.disturbances),
        )
        if self.interfere is not None:
            self.interfere(self.world)
