"""Learning a program's row: what was due in each decision of its expert, and which of it was done."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import torch

from ntp_dsl.core.dispatch.network import DispatchNetwork, batched
from ntp_dsl.core.dispatch.rows import Row, named, unrolled
from ntp_dsl.core.learnt.bodies import shown_calls, with_calls
from ntp_dsl.core.learnt.columns import columns_of
from ntp_dsl.core.learnt.examples import Example, examples_in
from ntp_dsl.core.learnt.learnt_rows import LearntRow, declaration_of
from ntp_dsl.core.learnt.preferences import Choice, Preference, preferred
from ntp_dsl.core.perception.perceived import Believed
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Program, Registry
from ntp_dsl.traces.trace import Trace


def learn(registry: Registry, network: DispatchNetwork, program: str, traces: Sequence[Trace]) -> LearntRow:
    """Learn a program's row from traces of its expert; nothing else changes.

    Raises `NtpError` where the traces do not show it, or call it as nothing declared could be called.
    """
    examples = examples_in(traces, program)
    if not examples:
        raise NtpError(f"none of the traces has a call of '{program}' that called something: record its task")
    row = registry.programs[program]
    calls = shown_calls(registry, row, examples) if row.in_python else ()
    if calls:
        row = with_calls(registry, row, calls)
        registry = replace(registry, programs={**registry.programs, program: row})
    choices = [each for each in (_choice(registry, network, row, e) for e in examples) if each is not None]
    preference = preferred(choices)
    hits = sum(_likeliest(preference, each) == each.chosen for each in choices)
    return LearntRow(
        program=program,
        of=declaration_of(registry, program),
        calls=calls,
        preference=preference,
        traces=len(traces),
        decisions=len(examples),
        foreseen=round(hits / len(examples), 4),
    )


def _choice(
    registry: Registry, network: DispatchNetwork, program: Program, example: Example
) -> Choice | None:
    """Return what was due and what was made; None where that was not due by the declaration."""
    state = Believed(registry, example.seen, {})
    row = unrolled(registry, program, example.arguments, state)
    made = example.callee, named(example.given)
    due = [at for at, is_due in enumerate(_due(network, row)) if is_due]
    chosen = next((at for at in due if (row.calls[at].callee, named(row.calls[at].arguments)) == made), None)
    if chosen is None:
        return None
    return Choice([columns_of(row.calls[at], row.statements[at], state) for at in due], due.index(chosen))


@torch.inference_mode()
def _due(network: DispatchNetwork, row: Row) -> list[bool]:
    return (network.hazards(batched([row]))[0, : len(row.calls)] > 0).tolist() if row.calls else []


def _likeliest(preference: Preference, choice: Choice) -> int:
    scores = [preference.score(each) for each in choice.calls]
    return scores.index(max(scores))
