"""Arguments at random, by type: things of the scene, members, numbers of the range."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ntp_dsl.registry import Parameter
from ntp_dsl.state import State
from ntp_dsl.world import Argument

UNBOUNDED = (0.0, 0.1)  # of a number whose declaration gives no range


def random_arguments(
    parameters: Sequence[Parameter], state: State, rng: np.random.Generator
) -> tuple[Argument, ...] | None:
    """One for each parameter, no thing twice; None where the scene has none, or for a list."""
    chosen: list[Argument] = []
    for parameter in parameters:
        argument = _argument(parameter, state, chosen, rng)
        if argument is None:
            return None
        chosen.append(argument)
    return tuple(chosen)


def _argument(
    parameter: Parameter, state: State, before: Sequence[Argument], rng: np.random.Generator
) -> Argument | None:
    registry = state.registry
    if parameter.is_list or parameter.type in registry.records:
        return None
    if parameter.type in registry.enums:
        return str(rng.choice(registry.enums[parameter.type]))
    if parameter.type not in registry.parents:
        low, high = parameter.low, parameter.high
        bounds = UNBOUNDED if low is None or high is None else (low, high)
        return float(rng.uniform(*bounds))
    constants = [name for name, kind in registry.constants.items() if registry.is_a(kind, parameter.type)]
    candidates = {*state.things(parameter.type), *constants} - {x for x in before if isinstance(x, str)}
    return str(rng.choice(sorted(candidates))) if candidates else None
