"""Tasks that are told in sentences: what a demonstration shows, in words, and who understands them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ntp_dsl.evaluation.episode_parts import starting_scene
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import Argument, Record
from ntp_dsl.sentences.narration import narrated
from ntp_dsl.sentences.understanding import Listener
from ntp_dsl.tasks.goal_text import Lists
from ntp_dsl.tasks.instances import Instance
from ntp_dsl.traces.schema import DemonstratedCall


def in_words(registry: Registry, shown: DemonstratedCall) -> list[str]:
    """Return the calls that a demonstration shows as sentences, in their order, each once.

    A sentence is a call of the task's program; where that takes a list itself, of what it calls.
    """
    return list(dict.fromkeys(_sentences(registry, shown)))


def _sentences(registry: Registry, shown: DemonstratedCall) -> Iterator[str]:
    for call in shown.children:
        if any(isinstance(each, tuple) for each in call.arguments):
            yield from _sentences(registry, call)
        elif call.arguments:
            yield narrated(registry, registry[call.name], call.arguments)


def listener(registry: Registry, instance: Instance, seed: int, number: int) -> Listener:
    """Return who understands sentences about an episode's scene, as it is at the start."""
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
