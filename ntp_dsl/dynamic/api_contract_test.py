"""Contract test of apis: if `requires` holds before a call, `achieves` must hold after it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import starmap
from pathlib import Path

import numpy as np

from ntp_dsl.dynamic.call_traces import CallTrace
from ntp_dsl.dynamic.places import Places
from ntp_dsl.dynamic.starts import places_text
from ntp_dsl.dynamic.trial_traces import TrialTraces
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Note
from ntp_dsl.language.diagnostics.rendering import shown_path
from ntp_dsl.language.registry import Api, Registry
from ntp_dsl.language.syntax.nodes import NOWHERE, Span
from ntp_dsl.policies.random_arguments import random_arguments
from ntp_dsl.semantics.attempts import reads_failures
from ntp_dsl.semantics.facts import Fact, Literal, bind
from ntp_dsl.semantics.observation import Argument, without_lists
from ntp_dsl.semantics.shortfalls import why_not
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import Instance
from ntp_dsl.traces.phrases import format_argument, format_measurement
from ntp_dsl.worlds.protocol import World

WALKS, STEPS = 40, 14  # random walks from perturbed starts, and calls of each
TRIES = 12  # at random arguments for which an api is ready
MIN_CALLS = 5  # before an api is judged
MAX_VIOLATIONS = 0.15  # share of calls; single awkward states are tolerated
MOST_TRACES = 3  # of an api's calls that violate its contract


@dataclass
class _Record:
    calls: int = 0
    violations: int = 0
    example: str = ""  # the first violation
    in_python: tuple[str, ...] = ()  # functions that the example rests on
    numbers: defaultdict[tuple[str, bool], list[float]] = field(  # parameter, whether kept -> its arguments
        default_factory=lambda: defaultdict(list)
    )
    scene: Span = NOWHERE  # the line that declares an object of it
    traces: list[str] = field(default_factory=list)  # of violations


def check_contracts(
    registry: Registry,
    world: World,
    instances: Sequence[Instance],
    seed: int,
    places: Places,
    traces: TrialTraces,
) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each api that violates its contract, or was never ready in a random walk.

    Of a library that is used, those apis are tested that a program of the one that is checked may call; where
    that has neither programs nor apis, all.

    Args:
        traces: where to write those of calls that violate one.
    """
    programs = [name for name, row in registry.programs.items() if places.is_own(row.span)]
    programs += [task.run.callee for task in registry.tasks.values() if task.run is not None]
    called = {name for each in programs for name in registry.called_by(each)}
    tested = {name for name, api in registry.apis.items() if name in called or places.is_own(api.span)}
    records = {name: _Record() for name in tested or registry.apis}
    is_traced = traces.folder is not None
    for walk in range(WALKS):
        rng = np.random.default_rng((seed, walk))
        instance = instances[walk % len(instances)]
        world.reset(instance.perturbed_start(rng, straight=1.0), walk)
        for _ in range(STEPS):
            trace = partial(CallTrace, registry, world, instance) if is_traced else None
            _step(registry, world, records, rng, partial(places.scene, instance), trace)
    for name, record in records.items():
        api = registry.apis[name]
        if record.calls >= MIN_CALLS and record.violations > MAX_VIOLATIONS * record.calls:
            files = [traces.write(registry.name, name, text) for text in record.traces]
            yield _violation(api, record, places, next(filter(None, files), None))
        elif record.calls == 0 and api.achieves is not None and places.is_own(api.span):
            message = f"'{name}' was never ready in {WALKS * STEPS} random states, so it was not tested"
            yield Diagnostic("N603", message, api.span)


def _step(
    registry: Registry,
    world: World,
    records: dict[str, _Record],
    rng: np.random.Generator,
    scene: Callable[[Collection[object]], Span],
    trace: Callable[[Api, tuple[Argument, ...]], CallTrace] | None,
) -> None:
    """Call an api that is ready; the least tested come first, so that none is left out by chance.

    Args:
        scene: returns the line of the scene that declares one of some objects.
        trace: begins the trace of a call.
    """
    state = State(registry, world.truth())
    apis = [registry.apis[name] for name in registry.apis if name in records]
    order = sorted(apis, key=lambda api: (records[api.name].calls, rng.random()))
    for api in order:
        for _ in range(TRIES):
            arguments = random_arguments(api.parameters, state, rng)
            if arguments is not None and _is_ready(api, arguments, state):
                record = records[api.name]
                if _violates(registry, world, api, arguments, record, trace) and record.violations == 1:
                    record.scene = scene(without_lists(arguments))
                return


def _is_ready(api: Api, arguments: tuple[Argument, ...], state: State) -> bool:
    """Return whether a call may be made. What is in the hand is left out unless it is to be there.

    No program goes to what it holds, and with few objects that would be many of the calls.
    """
    required = state.literals(api.requires, api.bind(arguments))
    held = state.observation.held
    if held in arguments and not any(_says_held(fact, held, state) for fact in required):
        return False
    return all(state.holds(fact) for fact in required)


def _says_held(fact: Fact, held: str, state: State) -> bool:
    """Return whether a fact, or the body of a composed one, says that an object is in the hand."""
    if not isinstance(fact, Literal) or not fact.positive:
        return False
    declared = state.registry.predicates[fact.predicate]
    if declared.body is not None:
        scope = bind(declared, fact.arguments)
        return any(_says_held(each, held, state) for each in state.literals(declared.body, scope))
    return fact.arguments == (held,) and declared.provider == "holding"


def _violates(
    registry: Registry,
    world: World,
    api: Api,
    arguments: tuple[Argument, ...],
    record: _Record,
    trace: Callable[[Api, tuple[Argument, ...]], CallTrace] | None,
) -> bool:
    """Call an api, and return whether it does not achieve what it promises."""
    begun = trace(api, arguments) if trace is not None and len(record.traces) < MOST_TRACES else None
    try:
        outcome = world.call(api.name, arguments)
    finally:
        world.on_frame = None
    if outcome.is_failed_attempt and reads_failures(registry):
        return False
    after = State(registry, world.truth())
    unmet = [fact for fact in after.literals(api.achieves, api.bind(arguments)) if not after.holds(fact)]
    record.calls += 1
    for parameter, value in zip(api.parameters, arguments, strict=True):
        if isinstance(value, float):
            record.numbers[parameter.name, not unmet].append(value)
    if unmet:
        record.violations += 1
        if begun is not None:
            record.traces.append(begun.end(outcome, unmet))
    if record.violations == 1 and unmet:
        measured = "; ".join(starmap(format_measurement, outcome.evidence.items()))
        failure = f"; it failed: {outcome.failure}" if outcome.failure else ""
        failure += f" ({measured})" if failure and measured else ""
        given = ", ".join(map(format_argument, arguments))
        where = places_text(after.observation, without_lists(arguments))
        record.example = f"for example {api.name}({given}): {why_not(unmet[0], after)}{failure}"
        record.example += f"; afterwards: {where}" if where else ""
        functions = [("skill", api.name)]
        functions += [("predicate", each.predicate) for each in unmet[:1] if isinstance(each, Literal)]
        given_to = registry.python.functions
        record.in_python = tuple(
            f"the {kind} '{name}'" for kind, name in functions if (kind, name) in given_to
        )
    return bool(unmet)


def _violation(api: Api, record: _Record, places: Places, file: Path | None) -> Diagnostic:
    """Return the error at what the api achieves; where that is not the user's, at the scene.

    Args:
        file: the trace of a call that violates the contract.
    """
    assert api.achieves is not None
    message = (
        f"'{api.name}' violates its contract: in {record.violations} of {record.calls} calls its 'requires' "
        f"held before, but its 'achieves' did not hold after"
    )
    help = "require more, or achieve less"
    if record.in_python:
        help += f"; or mend {' or '.join(record.in_python)}, in Python"
    seen = () if file is None else (Note(f"its trace: {shown_path(file)}"),)
    notes: tuple[Note, ...] = (Note(record.example, api.span), *map(Note, _ranges(api, record)), *seen)
    if not places.is_own(api.span):
        help = "declare objects that it can handle, and leave them more room"
        notes = (Note(record.example), Note("it promises this", api.achieves.span), *seen)
        return Diagnostic("E601", message, record.scene, notes, help)
    return Diagnostic("E601", message, api.achieves.span, notes, help)


def _ranges(api: Api, record: _Record) -> Iterator[str]:
    """Yield for which numbers a contract is kept, where that tells the kept calls from the others."""
    for parameter in api.parameters:
        kept, broken = (record.numbers[parameter.name, which] for which in (True, False))
        if kept and broken and (max(kept) < min(broken) or max(broken) < min(kept)):
            spans = [f"{min(each):.3g} to {max(each):.3g}" for each in (kept, broken)]
            yield f"it is kept for {parameter.name} from {spans[0]}, and broken from {spans[1]}"
