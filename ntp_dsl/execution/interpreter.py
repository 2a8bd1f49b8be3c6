"""Runs a program: a stack of calls, a policy that decides, a world that carries out the primitives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

from msgspec.structs import replace as with_fields

from ntp_dsl.execution.refusals import ROUNDS, InVain, Refusals, differ
from ntp_dsl.execution.supervision import Supervisor
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.evidence import weighed
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.left_out import told_evidence
from ntp_dsl.policies.protocol import Barred, Choice, Frame, Policy
from ntp_dsl.semantics.attempts import reads_failures
from ntp_dsl.semantics.facts import Fact, Literal
from ntp_dsl.semantics.observation import Argument, Observation, without_lists
from ntp_dsl.semantics.state import State
from ntp_dsl.traces.decision import NO_DECISION, Decision, FactProbability, Status
from ntp_dsl.traces.schema import ROOT, CallKind, CallOutcome, End, Ending, Execution
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.attempts import note_attempt
from ntp_dsl.worlds.protocol import Failure, Outcome, World

MAX_DEPTH = 48
GOING_ROUND = "calls come round to the states in which they were made before"
CONFIRMATIONS = 2  # a root must say «done» for that many observations in a row
NOTHING_HELPS = "nothing that the program knows helps"
SECOND_LOOK = 0.5  # between them, so that falling objects come to rest [s]


@dataclass
class Limits:
    """When a run is stopped: a number of primitives, or of decisions between two of them."""

    primitives: int = 150
    idle_decisions: int = 60
    retries: int = 5  # how often an unfinished root is asked again
    like_failures: int = 8  # primitives that fail alike, in a row


@dataclass
class Run:
    """The result of running a program to its end."""

    ending: Ending | None = None  # None while it runs
    reason: str = ""  # of the ending, for people
    primitives: int = 0
    deciding_seconds: float = 0.0  # wall, as all three
    planning_seconds: float = 0.0
    moving_seconds: float = 0.0
    disturbances: int = 0
    failures: list[Outcome] = field(default_factory=list)
    failing: int = 0  # the same failure so often in a row
    handled: set[Argument] = field(default_factory=set)  # arguments of primitives
    changes: int = 0  # of the world, by primitives
    in_vain: Refusals = field(default_factory=Refusals)  # calls that changed nothing
    made: Refusals = field(default_factory=lambda: Refusals(ROUNDS))  # primitives that changed something
    rounds: tuple[bool, bool] = (False, False)  # whether a call came round: in this pass, and the one before
    tells: bool = False  # the policy says how probably programs have achieved what they are to
    missing: str = ""  # the first fact that a return of the root rests on and that does not hold
    least: float | None = None  # of the decisions' probabilities; None where the policy gives none
    achieved: float | None = None  # how probably the goal holds, when the root returned last

    @property
    def done(self) -> bool:
        """Return whether the program says that it is done."""
        return self.ending is Ending.DONE

    @property
    def gave_up(self) -> bool:
        """Return whether the program itself found nothing more to do, although it was not done."""
        return self.ending in (Ending.UNFINISHED, Ending.CIRCULAR)

    @property
    def confidence(self) -> float | None:
        """Return how probable the policy finds it that what was shown is done; None where it cannot tell.

        A wrong decision is mended at the next look, and a wrong reading is not: so this is the probability
        that the goal holds at last, and that it was read rightly.
        """
        return self.achieved if self.achieved is not None else 0.0 if self.tells else None

    @property
    def last_message(self) -> str:
        """Return the world's message on the last failed primitive, as a clause; empty where there is none."""
        messages = [str(each.evidence["message"]) for each in self.failures if "message" in each.evidence]
        return f"; last: {messages[-1]}" if messages else ""

    def __str__(self) -> str:
        """Return how it ended, and why."""
        return f"{self.ending}: {self.reason}" if self.reason else str(self.ending or "running")

    def end(self) -> End:
        """Return the trace's record of its end."""
        assert self.ending is not None, "the run is not over"
        return End(
            ending=self.ending,
            reason=f"{self.reason}, and {self.missing} does not hold" if self.missing else self.reason,
            primitives=self.primitives,
            confidence=self.confidence,
            least=self.least,
        )


@dataclass(frozen=True)
class _Open:
    """A call that has not returned: its frame, its number in the trace, and the changes before it."""

    frame: Frame
    number: int
    changes: int

    def is_again(self, choice: Choice, run: Run) -> bool:
        """Return whether a call is this one once more, with nothing changed: it would recur for ever."""
        call = self.frame.program, self.frame.arguments, self.frame.scope
        return self.changes == run.changes and call == (choice.callee, choice.arguments, choice.scope)


Watcher = Callable[[str, int, str, tuple[Argument, ...], Any], None]  # event, depth, name, …, detail
Interference = Callable[[World], None]  # a recorder's perturbation after a primitive


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
        supervisor: Supervisor | None = None,
        expert: Expert | None = None,
    ) -> None:
        self.registry, self.policy, self.world = registry, policy, world
        self.writer = writer or TraceWriter()
        self.limits = limits or Limits()
        self.watch = watch or (lambda *_: None)
        self.frame_number = frame_number
        self.interfere = interfere
        self.supervisor = supervisor
        self._expert = expert or Expert(registry)

    def run(self, program: str, arguments: tuple[Argument, ...]) -> Run:
        run = Run()
        confirmed = retries = 0
        while run.ending is None:
            before = run.primitives
            done = self._run_root(self.policy.root(program, arguments), run)
            confirmed = confirmed + 1 if done and run.primitives == before else int(done)
            if run.ending is not None:
                break
            if confirmed >= CONFIRMATIONS:
                run.ending = Ending.DONE
                break
            if not done:
                retries += 1
                if retries > self.limits.retries:
                    run.ending = Ending.CIRCULAR if run.rounds[0] else Ending.UNFINISHED
                    run.reason = GOING_ROUND if run.rounds[0] else NOTHING_HELPS
            self.world.settle(SECOND_LOOK)
        return run

    def _run_root(self, root: Frame, run: Run) -> bool:
        """Run one pass from the root to its return; return whether it says «done»."""
        stack = [_Open(root, self._enter(root, ROOT, NO_DECISION, self.world.truth()), run.changes)]
        idle, fresh = 0, True  # fresh: the top of the stack has just been called
        run.rounds, run.achieved, run.missing = (False, run.rounds[0]), None, ""
        while True:
            frame, number, changes = stack[-1].frame, stack[-1].number, stack[-1].changes
            idle += 1
            if reason := self._stop(idle, len(stack), run):
                run.ending, run.reason = Ending.STOPPED, reason
                if any(run.rounds) and run.failing < self.limits.like_failures:
                    run.ending, run.reason = Ending.CIRCULAR, f"{GOING_ROUND}; stopped {reason}"
                for each in reversed(stack):
                    self.writer.returned(each.number, CallOutcome.STOPPED, self.frame_number())
                return False
            choice = self._decide(stack, run, fresh and len(stack) > 1)
            fresh = False
            if self.supervisor is not None:
                self.supervisor.before(len(stack), frame, choice)
            if choice.callee is None:
                self._leave(number, len(stack), frame, choice)
                stack.pop()
                if not stack:
                    return choice.done
                if run.changes == changes:
                    why = InVain.NEEDLESS if choice.done else InVain.FAILED
                    run.in_vain.add((frame.program, frame.arguments), self.world.truth(), why)
            elif choice.callee in self.registry.apis:
                idle = 0
                self._execute(choice, number, len(stack), run)
            else:
                child = Frame(choice.callee, choice.arguments, choice.scope, choice.matched)
                entered = self._enter(child, number, choice.decision, choice.seen, len(stack))
                stack.append(_Open(child, entered, run.changes))
                fresh = True

    def _stop(self, idle: int, depth: int, run: Run) -> str:
        """Return why a run without progress is stopped, or an empty string."""
        last = run.failures[-self.limits.like_failures :]
        if len(last) == self.limits.like_failures and run.failing == len(last):
            return f"{last[-1].failure} {len(last)} times in a row"
        if idle > self.limits.idle_decisions:
            return f"{idle} decisions without a primitive"
        if depth > MAX_DEPTH:
            return f"at a depth of {depth} calls"
        if run.primitives >= self.limits.primitives:
            return f"after {run.primitives} primitives"
        return ""

    def _decide(self, stack: Sequence[_Open], run: Run, fresh: bool) -> Choice:
        """Ask the policy, barring what the language forbids: a return at the first step, a call in vain.

        A program that has no option left because calls failed, or because they lead round in a circle, is
        unfinished.
        """
        start = perf_counter()
        frame = stack[-1].frame
        barred: Barred = frozenset({None} if fresh else ())
        world = self.world if self.supervisor is None else self.supervisor.world(frame, self.world)
        choice = self.policy.decide(frame, world, barred)
        read, waited = choice.decision.read, choice.waited
        refused = False
        while choice.callee not in barred and (found := self._in_vain(choice, stack, run)):
            refused |= found is not InVain.NEEDLESS
            if found is InVain.CIRCULAR:
                run.rounds = True, run.rounds[1]
            barred |= {choice.callee}
            choice = self.policy.decide(frame, world, barred)
            waited += choice.waited
        if choice.callee is None and refused:
            choice = replace(choice, done=False)
        run.least = _lesser(run.least, choice.decision.probability)
        run.tells |= choice.decision.achieved is not None
        if len(stack) == 1 and choice.callee is None:
            run.achieved = choice.decision.achieved
            lacking = [each.fact for each in choice.decision.facts if each.probability <= 0.5]
            run.missing = lacking[0] if lacking and not choice.done else ""
        seconds = perf_counter() - start - waited
        run.deciding_seconds += seconds
        self._check(choice)
        source = choice.decision.source or self._source(frame.program, choice)
        explains = self.writer.is_open or self.supervisor is not None
        decision = self._with_truth(frame, choice, world) if explains else choice.decision
        return replace(
            choice,
            decision=with_fields(
                decision,
                source=source,
                seconds=round(seconds, 5),
                read=choice.decision.read or read,
            ),
        )

    def _source(self, program: str, choice: Choice) -> str:
        """Return the line that makes a call: of like statements the one that was due, else the first."""
        row = self.registry.programs[program]
        made = choice.callee, without_lists(choice.arguments)
        for each in choice.decision.statements:
            is_made = (each.callee, without_lists(each.arguments)) == made
            if is_made and each.status is Status.DUE and row.span.path is not None:
                return f"{row.span.path.name}:{each.line}"
        return row.line(choice.callee)

    def _with_truth(self, frame: Frame, choice: Choice, shown: World) -> Decision:
        """Return a decision with the truth of its facts; a script's has those that its program names.

        Args:
            shown: the world as the policy saw it.
        """
        decision = choice.decision
        state = self._expert.state_of(self.world.truth())
        seen = state if shown is self.world else State(self.registry, shown.truth())

        def told(each: FactProbability, fact: Fact) -> FactProbability:
            forced = isinstance(fact, Literal) and seen.forced(fact.predicate, fact.arguments) is not None
            return with_fields(each, truth=state.holds(fact), forced=forced)

        if choice.grounds:
            return with_fields(decision, facts=tuple(map(told, decision.facts, choice.grounds)))
        if decision.facts or decision.probability is not None:
            return decision
        row = self.registry.programs[frame.program]
        is_unfinished = choice.callee is None and not choice.done
        grounds, statements = told_evidence(self._expert, row, frame.arguments, seen, is_unfinished)
        facts = tuple(map(told, weighed(grounds, seen.holds), grounds))
        return with_fields(decision, facts=facts, statements=statements, scripted=row.in_python)

    def _check(self, choice: Choice) -> None:
        """Raise `NtpError` where a policy chose what the library does not declare."""
        callee = choice.callee
        if callee is None:
            return
        if callee not in self.registry.apis and callee not in self.registry.programs:
            raise NtpError(
                f"the policy chose '{callee}', which is no program or api of library '{self.registry.name}'"
            )
        parameters = self.registry[callee].parameters
        if len(choice.arguments) != len(parameters):
            raise NtpError(
                f"the policy chose {callee} with {choice.arguments!r}; it takes "
                f"({', '.join(each.name for each in parameters)})"
            )

    def _in_vain(self, choice: Choice, stack: Sequence[_Open], run: Run) -> InVain | None:
        """Return why a call would lead to nothing, or None where it may be made."""
        call = choice.callee, choice.arguments
        if any(each.is_again(choice, run) for each in stack):
            return InVain.CIRCULAR
        if call not in run.in_vain and call not in run.made:
            return None
        state = self.world.truth()
        return run.in_vain.barred(call, state) or run.made.barred(call, state)

    def _enter(
        self,
        frame: Frame,
        parent: int,
        decision: Decision,
        seen: Observation | None,
        depth: int = 0,
    ) -> int:
        self.watch("call", depth, frame.program, frame.arguments, frame.scope)
        return self._write_call(parent, CallKind.PROGRAM, frame.program, frame, decision, seen)

    def _write_call(
        self,
        parent: int,
        kind: CallKind,
        name: str,
        given: Frame | Choice,
        decision: Decision,
        seen: Observation | None,
    ) -> int:
        state, frame = self._state(seen), self.frame_number()
        return self.writer.call(parent, kind, name, given.arguments, given.scope, frame, state, decision)

    def _state(self, seen: Observation | None) -> int:
        """Write the state behind a decision; the true one, if the policy does not give it."""
        return self.writer.state(self.world.truth() if seen is None else seen)

    def _leave(self, number: int, depth: int, frame: Frame, choice: Choice) -> None:
        outcome = CallOutcome.DONE if choice.done else CallOutcome.UNFINISHED
        self.watch("return", depth - 1, frame.program, frame.arguments, outcome)
        state = self._state(choice.seen)
        frame_number = self.frame_number()
        self.writer.returned(number, outcome, frame_number, state, choice.decision)

    def _execute(self, choice: Choice, parent: int, depth: int, run: Run) -> None:
        assert choice.callee is not None
        self.watch("call", depth, choice.callee, choice.arguments, choice.scope)
        number = self._write_call(parent, CallKind.API, choice.callee, choice, choice.decision, choice.seen)
        before = self.world.truth()
        forced = self._forced(choice)
        outcome = self.world.call(choice.callee, choice.arguments) if forced is None else forced
        if not isinstance(outcome, Outcome):
            raise NtpError(f"the world answered {choice.callee} with {outcome!r}; expected an Outcome")
        run.primitives += 1
        run.handled |= set(choice.arguments)
        run.planning_seconds += outcome.planning_seconds
        run.moving_seconds += outcome.moving_seconds
        run.disturbances += len(outcome.disturbances)
        after = self.world.truth()
        call = choice.callee, choice.arguments
        if differ(before, after):
            run.changes += 1
            run.made.add(call, before, InVain.CIRCULAR, by_chance=True)
        else:
            by_chance = not outcome.achieved and outcome.failure is not Failure.NOT_READY
            why = InVain.NEEDLESS if outcome.achieved else InVain.FAILED
            run.in_vain.add(call, after, why, by_chance)
        if outcome.achieved:
            run.failing = 0
        else:
            same = bool(run.failures) and run.failures[-1].failure is outcome.failure
            run.failing = run.failing + 1 if same else 1
            run.failures.append(outcome)
        came_to = CallOutcome.of(outcome)
        self.watch("return", depth, choice.callee, choice.arguments, came_to)
        execution = Execution(
            planning=round(outcome.planning_seconds, 5),
            moving=round(outcome.moving_seconds, 5),
            solver=outcome.solver,
            planner=outcome.planner,
            evidence=dict(outcome.evidence),
            disturbances=outcome.disturbances,
            unmet=self._unmet(choice, after) if outcome.achieved and forced is None else (),
        )
        self.writer.returned(number, came_to, self.frame_number(), execution=execution)
        if self.interfere is not None:
            self.interfere(self.world)

    def _forced(self, choice: Choice) -> Outcome | None:
        """Return the outcome that is forced on a primitive, if one is."""
        if self.supervisor is None or choice.callee is None:
            return None
        outcome = self.supervisor.outcome(choice.callee, choice.arguments)
        if outcome is not None and reads_failures(self.registry):
            note_attempt(self.world, choice.callee, choice.arguments, outcome)
        return outcome

    def _unmet(self, choice: Choice, after: Observation) -> tuple[str, ...]:
        """Return what a primitive is to achieve and what does not hold after it, where a trace is written."""
        assert choice.callee is not None
        if not self.writer.is_open:
            return ()
        row, state = self.registry.apis[choice.callee], self._expert.state_of(after)
        promised = state.literals(row.achieves, row.bind(choice.arguments))
        return tuple(str(fact) for fact in promised if not state.holds(fact))


def _lesser(some: float | None, other: float | None) -> float | None:
    return min((each for each in (some, other) if each is not None), default=None)
