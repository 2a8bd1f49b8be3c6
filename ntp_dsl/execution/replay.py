"""Asks a policy what it would do at every state of a trace, and writes its answers as a trace."""

from __future__ import annotations

from typing import Any, cast

from msgspec.structs import replace as with_fields

from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.protocol import Barred, Frame, Policy, Tracking
from ntp_dsl.policies.scripted import ScriptedPolicy, counterpart
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.traces.decision import NO_DECISION, Answer, Decision
from ntp_dsl.traces.schema import FORMAT, ROOT, VERSION, Call, PolicyKind
from ntp_dsl.traces.trace import Trace
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.protocol import World


class StillWorld:
    """A moment of a trace, which can only be observed."""

    def __init__(self, seen: Observation) -> None:
        self._seen = seen

    def observe(self) -> Observation:
        return self._seen

    def truth(self) -> Observation:
        return self._seen


class Replay:
    """One policy, one trace. The caller's arguments and scope are the trace's, whatever was answered."""

    def __init__(self, registry: Registry, policy: Policy, trace: Trace) -> None:
        self.registry, self.policy, self.trace = registry, policy, trace
        self._matched: dict[int, Any] = {}  # what the policy knows of each call

    def write(self, writer: TraceWriter, model: str | None = None) -> None:
        """Write the trace again, with the policy's answer beside each decision.

        Args:
            model: the path of the checkpoint that answers; None where a script does.
        """
        replayed = PolicyKind.REPLAYED
        own = with_fields(self.trace.header, format=FORMAT, version=VERSION, training="")
        writer.header(with_fields(own, policy=replayed, model=model))
        for call, returns in self.trace.events():
            if returns:
                self._return(writer, call)
            else:
                self._call(writer, call)
        if self.trace.end is not None:
            writer.end(self.trace.end)

    def _call(self, writer: TraceWriter, call: Call) -> None:
        seen = self.trace.states[call.state]
        decision = NO_DECISION
        if call.parent != ROOT:
            caller = self.trace.calls[call.parent]
            decision, matched = self._asked(caller, seen, call.decision, is_first=self._is_first(call))
            answer = decision.answer
            if answer is not None and (answer.callee, answer.arguments) == (call.name, call.arguments):
                self._matched[call.id] = matched
        self._match(call)
        writer.call(
            call.parent,
            call.kind,
            call.name,
            call.arguments,
            call.scope,
            call.frame,
            writer.state(seen),
            decision,
        )

    def _return(self, writer: TraceWriter, call: Call) -> None:
        assert call.outcome is not None, "only what returned is an event"
        end_frame = call.end_frame or call.frame
        if not call.is_program or call.end_state is None:
            writer.returned(call.id, call.outcome, end_frame, execution=call.execution)
            return
        seen = self.trace.states[call.end_state]
        decision, _ = self._asked(call, seen, call.return_decision or NO_DECISION, is_first=False)
        writer.returned(call.id, call.outcome, end_frame, writer.state(seen), decision)

    def _is_first(self, call: Call) -> bool:
        """Return whether this is the first step of a callee, which may not be a return."""
        caller = self.trace.calls[call.parent]
        return caller.parent != ROOT and call.id == caller.id + 1

    def _asked(
        self, caller: Call, seen: Observation, followed: Decision, is_first: bool
    ) -> tuple[Decision, Any]:
        """Return the policy's decision with its answer, and what it knows of the call that it would make.

        The statement is the one that the trace followed.
        """
        arguments = self._arguments(caller)
        if arguments is None:
            return Decision(source=followed.source), None
        frame = Frame(caller.name, arguments, caller.scope, self._matched.get(caller.id))
        barred: Barred = frozenset({None} if is_first else ())
        if isinstance(self.policy, Tracking):
            choice = self.policy.choose(frame, seen, barred)
        else:
            world = cast(World, StillWorld(seen))  # a policy looks, and does nothing
            choice = self.policy.decide(frame, world, barred)
        is_api = choice.callee in self.registry.apis
        answer = Answer(choice.callee, is_api, choice.arguments, choice.scope)
        return with_fields(choice.decision, source=followed.source, answer=answer), choice.matched

    def _arguments(self, caller: Call) -> tuple[Argument, ...] | None:
        """Return the caller's arguments; None where a script needs lists that the trace lacks."""
        is_script = isinstance(self.policy, ScriptedPolicy)
        row = self.registry.programs[caller.name]
        lacks_lists = is_script and row.takes_list and () in caller.arguments
        if len(caller.arguments) == len(row.parameters) and not lacks_lists:
            return caller.arguments
        if caller.parent == ROOT and self.trace.header.arguments:
            return self.trace.header.arguments
        return None if is_script else caller.arguments

    def _match(self, call: Call) -> None:
        """Find the demonstrated call that a script takes its scopes from."""
        if not isinstance(self.policy, ScriptedPolicy):
            return
        above = self._matched.get(call.parent)
        arguments = self._arguments(call) if call.is_program else call.arguments
        if call.parent == ROOT:
            self._matched[call.id] = self.policy.demonstration
        elif arguments is not None:
            self._matched[call.id] = counterpart(above, call.name, arguments)
