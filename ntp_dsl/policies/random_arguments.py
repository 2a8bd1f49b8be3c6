"""Arguments at random, by type: objects of the scene, members, numbers of the range, and records of these."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ntp_dsl.language.registry import Parameter, bounds
from ntp_dsl.semantics.observation import Argument, Record, without_lists
from ntp_dsl.semantics.state import State


def random_arguments(
    parameters: Sequence[Parameter], state: State, rng: np.random.Generator
) -> tuple[Argument, ...] | None:
    """Return an argument for each parameter, no object twice; None for a list or without candidates."""
    chosen: list[Argument] = []
    for parameter in parameters:
        argument = _argument(parameter, state, without_lists(tuple(chosen)), rng)
        if argument is None:
            return None
        chosen.append(argument)
    return tuple(chosen)


def _argument(
    parameter: Parameter, state: State, before: Sequence[Argument], rng: np.random.Generator
) -> Argument | None:
    registry = state.registry
    if parameter.is_list:
        return None
    if parameter.type in registry.records:
        return _record(parameter.type, state, before, rng)
    if parameter.type in registry.enums:
        candidates = list(registry.enums[parameter.type])
    elif parameter.type not in registry.parents:
        return float(rng.uniform(*bounds(parameter)))
    else:
        objects = state.objects(parameter.type)
        fixed = [n for n, kind in registry.constants.items() if registry.is_a(kind, parameter.type)]
        candidates = [name for name in dict.fromkeys([*objects, *fixed]) if name not in before]
    return candidates[int(rng.integers(len(candidates)))] if candidates else None


def _record(name: str, state: State, before: Sequence[Argument], rng: np.random.Generator) -> Record | None:
    fields: list[tuple[str, str | float]] = []
    for parameter in state.registry.records[name]:
        taken = [*before, *(value for _, value in fields)]
        value = _argument(parameter, state, taken, rng)
        if not isinstance(value, str | float):
            return None
        fields.append((parameter.name, value))
    return Record(name, tuple(fields))
