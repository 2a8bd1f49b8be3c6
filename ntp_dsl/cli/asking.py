"""Questions to a person: what a demonstration leaves open."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import typer

from ntp_dsl.common.text import printable
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.tasks.goal_text import Element, format_element

if TYPE_CHECKING:
    from ntp_dsl.core.reading.reading import Doubt

MOST = 5  # elements that a question offers


def questions(
    registry: Registry, demonstration: Demonstration, doubts: Sequence[Doubt]
) -> Iterator[tuple[str, list[Element]]]:
    """Yield a question for each doubt, and the elements among which to choose."""
    for doubt in doubts:
        offered = [(doubt.element, doubt.probability), *doubt.others][:MOST]
        texts = [printable(format_element(registry, element)) for element, _ in offered]
        width = max(map(len, texts))
        rows = [
            f"  {number}  {text:<{width}}  {chance:4.0%}"
            for number, (text, (_, chance)) in enumerate(zip(texts, offered, strict=True), 1)
        ]
        time = float(demonstration.times[doubt.frame])
        head = f"element {doubt.number + 1} of '{doubt.parameter}', shown at {time:.1f} s, may be"
        yield "\n".join([head, *rows]), [element for element, _ in offered]


def answered(
    registry: Registry, demonstration: Demonstration, doubts: Sequence[Doubt], answers: Sequence[int]
) -> dict[Doubt, Element]:
    """Return which element is meant by each doubt: as answered beforehand, or else by whoever is asked.

    Raises `NtpError` for an answer that was not offered, and where nobody can be asked.
    """
    asked = list(questions(registry, demonstration, doubts))
    if len(answers) > len(asked):
        raise NtpError(f"--answer: {len(answers)} answers to {len(asked) or 'no'} questions")
    if len(answers) < len(asked) and not sys.stdin.isatty():
        text = "\n".join(question for question, _ in asked)
        raise NtpError(f"{text}\nnobody can be asked here: add {'--answer N ' * len(asked)}".rstrip())
    found: dict[Doubt, Element] = {}
    for number, (doubt, (question, offered)) in enumerate(zip(doubts, asked, strict=True)):
        if number < len(answers):
            choice = answers[number]
        else:
            typer.echo(question, err=True)
            choice = typer.prompt("which is meant?", default=1, type=int, err=True)
        if not 1 <= choice <= len(offered):
            raise NtpError(f"{question}\nexpected an answer from 1 to {len(offered)}, found {choice}")
        found[doubt] = offered[choice - 1]
    return found
