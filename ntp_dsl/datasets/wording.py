"""What a demonstration shows, in words."""

from __future__ import annotations

from collections.abc import Iterator

from ntp_dsl.language.registry import Registry
from ntp_dsl.sentences.narration import narrated
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
