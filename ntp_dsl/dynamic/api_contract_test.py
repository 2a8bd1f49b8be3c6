"""Whether apis are honest: where what they require holds, what they achieve holds after them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ntp_dsl.dynamic.starts import whereabouts
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Note
from ntp_dsl.language.registry import Api, Registry
from ntp_dsl.policies.random_arguments import random_arguments
from ntp_dsl.semantics.observation import Argument, without_lists
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import Instance
from ntp_dsl.traces.phrases import shown
from ntp_dsl.worlds.protocol import World

WALKS, STEPS = 40, 14  # from perturbed states, so many apis at random
TRIES = 12  # at arguments for which an api is ready
FEWEST = 5  # calls, before an api is judged
BROKEN = 0.15  # of its calls; an awkward corner is not a lie


@dataclass
class _Record:
    calls: int = 0
    broken: int = 0
    example: str = ""  # of a call that broke it


def check_honesty(
    registry: Registry, world: World, instances: Sequence[Instance], seed: int
) -> Iterator[Diagnostic]:
    """Every api of the registry that some random walk finds ready, and that does not keep its word."""
    records = {name: _Record() for name in registry.apis}
    for walk in range(WALKS):
        rng = np.random.default_rng((seed, walk))
        instance = instances[walk % len(instances)]
        world.reset(instance.perturbed_start(rng, straight=1.0), walk)
        for _ in range(STEPS):
            _step(registry, world, records, rng)
    for name, record in records.items():
        api = registry.apis[name]
        if record.calls >= FEWEST and record.broken > BROKEN * record.calls:
            yield _dishonest(api, record)
        elif record.calls == 0 and api.achieves is not None:
            message = f"'{name}' was never ready in {WALKS * STEPS} random states, so it was not tried"
            yield Diagnostic("N603", message, api.span)


def _step(registry: Registry, world: World, records: dict[str, _Record], rng: np.random.Generator) -> None:
    """One call that is ready. What is tried least comes first, so that none is left out by chance."""
    state = State(registry, world.truth())
    order = sorted(registry.apis.values(), key=lambda api: (records[api.name].calls, rng.random()))
    for api in order:
        for _ in range(TRIES):
            arguments = random_arguments(api.parameters, state, rng)
            if arguments is not None and _is_ready(api, arguments, state):
                _call(registry, world, api, arguments, records[api.name])
                return


def _bound(api: Api, arguments: tuple[Argument, ...]) -> dict[str, Argument]:
    return dict(zip((p.name for p in api.parameters), arguments, strict=True))


def _is_ready(api: Api, arguments: tuple[Argument, ...], state: State) -> bool:
    return all(state.holds(fact) for fact in state.literals(api.requires, _bound(api, arguments)))


def _call(
    registry: Registry, world: World, api: Api, arguments: tuple[Argument, ...], record: _Record
) -> None:
    outcome = world.call(api.name, arguments)
    after = State(registry, world.truth())
    lacking = [fact for fact in after.literals(api.achieves, _bound(api, arguments)) if not after.holds(fact)]
    record.calls += 1
    if lacking:
        record.broken += 1
        said = f"; the world said: {outcome.failure}" if outcome.failure else ""
        given = ", ".join(map(shown, arguments))
        where = whereabouts(after.observation, without_lists(arguments))
        record.example = f"for example {api.name}({given}): {lacking[0]} does not hold{said}"
        record.example += f"; after it: {where}" if where else ""


def _dishonest(api: Api, record: _Record) -> Diagnostic:
    assert api.achieves is not None
    message = (
        f"'{api.name}' does not keep its word: in {record.broken} of {record.calls} calls what it requires "
        f"held before, and not all that it achieves after"
    )
    help = "require what it needs, or promise less"
    return Diagnostic("E601", message, api.achieves.span, (Note(record.example, api.span),), help)
