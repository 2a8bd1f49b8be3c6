"""Tasks that are told in sentences: who understands them, and the lists that they tell."""

from __future__ import annotations

from collections.abc import Sequence

from ntp_dsl.evaluation.episode_parts import starting_scene
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import Argument, Record
from ntp_dsl.sentences.understanding import Listener
from ntp_dsl.tasks.goal_text import Lists
from ntp_dsl.tasks.instances import Instance


def listener(registry: Registry, instance: Instance, seed: int, number: int) -> Listener:
    """Return a listener for an episode's scene, as it is at the start."""
    groups = {name: _names(value) for name, value in instance.bindings.items()}
    seen = starting_scene(registry, instance, seed, number).seen
    named = {name: names for name, names in groups.items() if names}
    return Listener(registry, instance.program, instance.arguments, seen, named)


def _names(value: Argument) -> tuple[str, ...]:
    return tuple(each for each in value if isinstance(each, str)) if isinstance(value, tuple) else ()


def as_lists(registry: Registry, program: str, arguments: Sequence[Argument]) -> Lists:
    """Return the lists among a program's arguments by their parameters' names."""
    pairs = zip(registry.programs[program].parameters, arguments, strict=True)
    return {each.name: _elements(value) for each, value in pairs if each.is_list}


def _elements(value: Argument) -> tuple[Record | str, ...]:
    assert isinstance(value, tuple)
    return value
