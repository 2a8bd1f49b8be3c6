"""The trace of one call of an api, made from a state of a random walk."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from io import StringIO

from ntp_dsl.dynamic.trial_traces import header, write_frame
from ntp_dsl.language.registry import Api, Registry
from ntp_dsl.semantics.facts import Fact
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.tasks.instances import Instance
from ntp_dsl.traces.decision import NO_DECISION
from ntp_dsl.traces.failure_attribution import ATTRIBUTION_OF_OUTCOME
from ntp_dsl.traces.schema import (
    ROOT,
    CallKind,
    CallOutcome,
    End,
    Ending,
    Execution,
)
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.protocol import Outcome, World


class CallTrace:
    """A trace that begins before a call and, where the call was in vain, ends after it."""

    def __init__(
        self, registry: Registry, world: World, instance: Instance, api: Api, arguments: tuple[Argument, ...]
    ) -> None:
        self._text, self._world = StringIO(), world
        self._writer = TraceWriter(self._text)
        self._writer.header(header(registry, instance, api.name, arguments))
        state = self._writer.state(world.truth())
        self._writer.call(ROOT, CallKind.API, api.name, arguments, None, 0, state, NO_DECISION)
        world.on_frame = partial(write_frame, self._writer, world)

    def end(self, outcome: Outcome, unmet: Sequence[Fact]) -> str:
        """Return the text of a call that did not achieve what it promises."""
        facts = tuple(map(str, unmet))
        execution = Execution(evidence=dict(outcome.evidence), unmet=facts if outcome.achieved else ())
        state, frame = self._writer.state(self._world.truth()), self._writer.frames
        self._writer.returned(0, CallOutcome.of(outcome), frame, state, execution=execution)
        self._writer.end(
            End(
                ending=Ending.DONE if outcome.achieved else Ending.UNFINISHED,
                primitives=1,
                success=False,
                attributed_to=ATTRIBUTION_OF_OUTCOME.get(CallOutcome.of(outcome)),
                verdict=f"{', '.join(facts)} does not hold",
            )
        )
        return self._text.getvalue()
