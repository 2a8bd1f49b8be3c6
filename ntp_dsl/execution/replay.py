"""Asks a policy at every state of a trace what it would do, and writes its answers down as a trace."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.protocol import Barred, Frame, Policy
from ntp_dsl.policies.scripted import DemonstratedCall, ScriptedPolicy, counterpart
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.traces.comparison.teacher_forcing import answer_row
from ntp_dsl.traces.schema import ROOT, Call, Trace, from_json
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.protocol import World


class StillWorld:
    """A moment of a trace: can be looked at, and nothing else."""

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
        self._matched: dict[int, DemonstratedCall | None] = {}

    def write(self, writer: TraceWriter, **facts: Any) -> None:
        """The trace again, with the policy's answer beside each decision. `facts` go into the header."""
        kept = {k: v for k, v in self.trace.header.items() if k not in ("event", "format", "version")}
        writer.header(**{**kept, "policy": "replayed", "model": None, **facts})
        for call, returns in self.trace.events():
            if returns:
                self._return(writer, call)
            else:
                self._call(writer, call)
        if self.trace.end is not None:
            writer.end(**self.trace.end)

    def _call(self, writer: TraceWriter, call: Call) -> None:
        seen = self.trace.states[call.state]
        decision: Mapping[str, Any] = {}
        if call.parent != ROOT:
            caller = self.trace.calls[call.parent]
            decision = self._asked(caller, seen, is_first=self._is_first(call)) | self._source(call.decision)
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
        end_frame = call.end_frame or call.frame
        if not call.is_program or call.end_state is None:
            writer.returned(call.id, call.outcome, end_frame, **call.details)
            return
        seen = self.trace.states[call.end_state]
        decision = self._asked(call, seen, is_first=False) | self._source(call.ending)
        state = writer.state(seen)
        writer.returned(call.id, call.outcome, end_frame, state=state, decision=decision)

    def _is_first(self, call: Call) -> bool:
        """A callee may not return at its first step; a root may."""
        caller = self.trace.calls[call.parent]
        return caller.parent != ROOT and call.id == caller.id + 1

    def _asked(self, caller: Call, seen: Observation, is_first: bool) -> dict[str, Any]:
        arguments = self._arguments(caller)
        if arguments is None:
            return {}
        frame = Frame(caller.name, arguments, caller.scope, self._matched.get(caller.id))
        barred: Barred = frozenset({None} if is_first else ())
        world = cast(World, StillWorld(seen))  # a policy looks, and does nothing
        choice = self.policy.decide(frame, world, barred)
        kind = "api" if choice.callee in self.registry.apis else "program"
        row = answer_row(choice.callee, kind, choice.arguments, choice.scope)
        return {**choice.details, "answer": row}

    def _arguments(self, caller: Call) -> tuple[Argument, ...] | None:
        """As the policy takes them; None where a script would need lists that the trace does not have."""
        if len(caller.arguments) == len(self.registry.programs[caller.name].parameters):
            return caller.arguments
        if caller.parent == ROOT and isinstance(given := self.trace.header.get("arguments"), list):
            return tuple(from_json(value) for value in given)
        return None if isinstance(self.policy, ScriptedPolicy) else caller.arguments

    def _match(self, call: Call) -> None:
        """The demonstration's call that a script takes its scopes from."""
        if not isinstance(self.policy, ScriptedPolicy):
            return
        above = self._matched.get(call.parent)
        arguments = self._arguments(call) if call.is_program else call.arguments
        if call.parent == ROOT:
            self._matched[call.id] = self.policy.demonstration
        elif arguments is not None:
            self._matched[call.id] = counterpart(above, call.name, arguments)

    def _source(self, decision: Mapping[str, Any]) -> dict[str, Any]:
        """The statement is the one that the trace followed."""
        return {"source": decision["source"]} if "source" in decision else {}
