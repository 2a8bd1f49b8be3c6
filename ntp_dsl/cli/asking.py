"""Questions to a person: what a demonstration leaves open."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ntp_dsl.common.files import written_whole
from ntp_dsl.common.text import counted, printable
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.evaluation.question_picture import question_picture
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
        offered = _offered(doubt)
        texts = [printable(format_element(registry, element)) for element, _ in offered]
        width = max(map(len, texts))
        rows = [
            f"  {number}  {text:<{width}}  {chance:4.0%}"
            for number, (text, (_, chance)) in enumerate(zip(texts, offered, strict=True), 1)
        ]
        time = float(demonstration.times[doubt.frame])
        head = f"element {doubt.number + 1} of '{doubt.parameter}', shown at {time:.1f} s, may be"
        more = len(doubt.others) + 1 - len(offered)
        rows += [f"  and {counted(more, 'other')} that {'is' if more == 1 else 'are'} less probable"] * (
            more > 0
        )
        yield "\n".join([head, *rows]), [element for element, _ in offered]


def _offered(doubt: Doubt) -> list[tuple[Element, float]]:
    return [(doubt.element, doubt.probability), *doubt.others][:MOST]


def draw_questions(
    folder: Path, registry: Registry, demonstration: Demonstration, doubts: Sequence[Doubt]
) -> Iterator[Path]:
    """Write a picture of each question to a folder, and yield its file."""
    for number, doubt in enumerate(doubts, 1):
        offered = [
            (element, f"{printable(format_element(registry, element))}  {chance:.0%}")
            for element, chance in _offered(doubt)
        ]
        path = folder / f"question_{number}.svg"
        with written_whole(path) as partial:
            partial.write_text(question_picture(demonstration, doubt.frame, offered), encoding="utf-8")
        yield path


def answered(
    registry: Registry, demonstration: Demonstration, doubts: Sequence[Doubt], answers: Sequence[int]
) -> dict[Doubt, Element]:
    """Return which element is meant by each doubt: as answered beforehand, or else by whoever is asked.

    Raises `NtpError` for an answer that was not offered, and where nobody can be asked.
    """
    asked = list(questions(registry, demonstration, doubts))
    if len(answers) > len(asked):
        raise NtpError(f"--answer: expected at most {counted(len(asked), 'answer')}, found {len(answers)}")
    for (question, offered), answer in zip(asked, answers, strict=False):
        if answer > len(offered):
            raise NtpError(f"{question}\nexpected an answer from 1 to {len(offered)}, found {answer}")
    left = asked[len(answers) :]
    if left and not sys.stdin.isatty():
        text = "\n".join(question for question, _ in left)
        raise NtpError(f"{text}\nnobody can be asked here: add {' '.join(['--answer N'] * len(left))}")
    choices = [*answers, *(_choice(question, len(offered)) for question, offered in left)]
    return {
        doubt: offered[choice - 1] for doubt, (_, offered), choice in zip(doubts, asked, choices, strict=True)
    }


def _choice(question: str, count: int) -> int:
    """Ask until an offered number is given. Raises `NtpError` where the input ends."""
    typer.echo(question, err=True)
    while True:
        try:
            choice: int = typer.prompt("which is meant?", default=1, type=int, err=True)
        except typer.Abort as error:
            raise NtpError("no answer was given, and nothing was done") from error
        if 1 <= choice <= count:
            return choice
        typer.echo(f"expected a number from 1 to {count}", err=True)
