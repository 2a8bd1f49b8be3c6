"""Learning a program's row: what was due in each decision of its expert, and which of it was done."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import torch

from ntp_dsl.core.dispatch.network import DispatchNetwork, batched
from ntp_dsl.core.dispatch.rows import Row, named, unrolled
from ntp_dsl.core.learnt.bodies import shown_calls, with_calls
from ntp_dsl.core.learnt.examples import Example, examples_in
from ntp_dsl.core.learnt.learnt_rows import LearntRow, declaration_of, function_of
from ntp_dsl.core.learnt.preferences import Choice, Preference, columns_of, preferred
from ntp_dsl.core.learnt.quantities import quantities
from ntp_dsl.core.perception.perceived import Believed
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Program, Registry
from ntp_dsl.traces.trace import Trace

PARTS = 5  # of the traces; each is foreseen by what the others show


def learn(registry: Registry, network: DispatchNetwork, program: str, traces: Sequence[Trace]) -> LearntRow:
    """Learn a program's row from traces of its expert; nothing else changes.

    Raises `NtpError` where the traces do not show it, or are of another declaration.
    """
    row = registry.programs[program]
    examples = examples_in(registry, row, traces)
    calls = shown_calls(registry, row, examples) if row.in_python else ()
    if calls:
        row = with_calls(registry, row, calls)
    known = replace(registry, programs={**registry.programs, program: row})
    choices = [(each.trace, _choice(known, network, row, each)) for each in examples]
    due = [(trace, choice) for trace, choice in choices if choice is not None]
    if not due:
        raise NtpError(
            f"'{program}' cannot be learnt: by the contracts, none of the calls that it makes was due; its "
            "contract, or those of what it calls, do not say what they are for"
        )
    preference = preferred([choice for _, choice in due])
    return LearntRow(
        program=program,
        of=declaration_of(registry, program, preference),
        function=function_of(registry, program),
        calls=calls,
        preference=preference,
        traces=len(traces),
        decisions=len(examples),
        due=len(due),
        foreseen=round(_foreseen(due), 4),
    )


def _choice(
    registry: Registry, network: DispatchNetwork, program: Program, example: Example
) -> Choice | None:
    """Return what was due and what was made; None where that was not due by the declaration."""
    state = Believed(registry, example.seen, {})
    row = unrolled(program, example.arguments, state)
    made = example.callee, named(example.given)
    due = [at for at, is_due in enumerate(_due(network, row)) if is_due]
    chosen = next((at for at in due if (row.calls[at].callee, named(row.calls[at].arguments)) == made), None)
    if chosen is None:
        return None
    calls = [
        columns_of(quantities(row.calls[at], row.statements[at], state), row.calls[at].callee) for at in due
    ]
    return Choice(calls, due.index(chosen))


@torch.inference_mode()
def _due(network: DispatchNetwork, row: Row) -> list[bool]:
    return (network.hazards(batched([row]))[0, : len(row.calls)] > 0).tolist() if row.calls else []


def _foreseen(choices: Sequence[tuple[int, Choice]]) -> float:
    """Return the share of choices that are foreseen by what other traces show."""
    hits = 0
    for part in range(PARTS):
        others = preferred([choice for trace, choice in choices if trace % PARTS != part])
        asked = [choice for trace, choice in choices if trace % PARTS == part]
        hits += sum(_likeliest(others, each) == each.chosen for each in asked)
    return hits / len(choices)


def _likeliest(preference: Preference, choice: Choice) -> int:
    scores = [preference.score(each) for each in choice.calls]
    return scores.index(max(scores))
