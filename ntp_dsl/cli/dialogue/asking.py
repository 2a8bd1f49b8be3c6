"""Questions to a person: what a demonstration leaves open, and what is in doubt while a program runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ntp_dsl.cli.display import messages
from ntp_dsl.cli.terminal import has_typist, read_line
from ntp_dsl.common.files import written_whole
from ntp_dsl.common.text import counted, printable
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.evaluation.question_picture import Offer, question_picture
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import Observation, Record, without_lists
from ntp_dsl.sentences.understanding import SURE_ENOUGH, Choice, Listener, Understood
from ntp_dsl.tasks.goal_text import Element, format_element
from ntp_dsl.traces.phrases import format_invocation, format_option

if TYPE_CHECKING:
    from ntp_dsl.core.asking import Question
    from ntp_dsl.core.reading.reading import Doubt
    from ntp_dsl.core.shown import Shown

MOST = 5  # elements that a question offers
MEANT, RIGHT = "which is meant?", "which is right?"


class Interview:
    """Questions to whoever runs a program: answered beforehand, in their order, or else at the terminal.

    Args:
        pictures: where questions are drawn; None for no pictures.
    """

    def __init__(self, registry: Registry, answers: Sequence[int], pictures: Path | None) -> None:
        self._registry, self._pictures = registry, pictures
        self._answers = [*answers]
        self._count = 0

    @property
    def unused(self) -> int:
        """How many answers no question has been asked for."""
        return len(self._answers)

    def elements(self, source: Shown, doubts: Sequence[Doubt]) -> dict[Doubt, Element]:
        """Return which element is meant by each doubt.

        Raises `NtpError` for an answer that was not offered, and where nobody can be asked.
        """
        asked = [*questions(self._registry, source.demonstration, doubts)]
        for doubt in doubts:
            self._draw(source.look(doubt.frame), _offers(self._registry, doubt), MEANT)
        left = asked[len(self._answers) :]
        if left and not has_typist():
            raise NtpError("\n".join([*(text for text, _ in left), _nobody(len(left))]))
        meant: dict[Doubt, Element] = {}
        for doubt, (text, offered) in zip(doubts, asked, strict=True):
            meant[doubt] = offered[self._answer(text, MEANT, len(offered)) - 1]
        return meant

    def meanings(self, listener: Listener, sentences: Sequence[str], understood: Understood) -> Understood:
        """Return what sentences say once somebody has told which of several things is meant.

        Raises `NtpError` as `elements` does.
        """
        unsure = [each for each in understood.choices if each.probability < SURE_ENOUGH]
        asked = [_meaning(self._registry, sentences, each) for each in unsure]
        left = asked[len(self._answers) :]
        if left and not has_typist():
            raise NtpError("\n".join([*(text for text, _ in left), _nobody(len(left))]))
        meant = {}
        for choice, (text, offered) in zip(unsure, asked, strict=True):
            element = offered[self._answer(text, MEANT, len(offered)) - 1]
            meant[choice] = replace(choice, element=element, probability=1.0, others=())
        choices = tuple(meant.get(each, each) for each in understood.choices)
        return replace(understood, arguments=listener.with_elements(choices), choices=choices)

    def decision(self, question: Question) -> int:
        """Return which option a program is to take, from 0. Raises `NtpError` as `elements` does."""
        options = question.options
        texts = [format_option(each) for each in options]
        who = format_invocation(question.program, question.arguments)
        rows = _table(texts, [each.probability for each in options])
        asked = "\n".join([f"{who} may go on in {len(texts)} ways:", *rows])
        offers: list[Offer] = [
            ([str(value) for value in without_lists(option.arguments)], f"{text}  {option.probability:.0%}")
            for option, text in zip(options, texts, strict=True)
        ]
        self._draw(question.seen, offers, RIGHT)
        if not self._answers and not has_typist():
            raise NtpError(f"{asked}\n{_nobody(1)}")
        return self._answer(asked, RIGHT, len(texts)) - 1

    def _draw(self, seen: Observation, offers: Sequence[Offer], title: str) -> None:
        if self._pictures is None:
            return
        self._count += 1
        path = self._pictures / f"question_{self._count}.svg"
        _write(path, seen, offers, title)
        messages.print(f"wrote {path}")

    def _answer(self, question: str, prompt: str, count: int) -> int:
        """Return the next answer, or ask until an offered number is given.

        Raises `NtpError` for an answer that was not offered, and where the input ends.
        """
        typer.echo(question, err=True)
        if self._answers:
            answer = self._answers.pop(0)
            if answer > count:
                raise NtpError(f"expected an answer from 1 to {count}, found {answer}")
            typer.echo(f"{prompt} answered {answer}", err=True)
            return answer
        while True:
            typer.echo(f"{prompt} [1]: ", nl=False, err=True)
            line = read_line()
            if not line:
                raise NtpError("no answer was given, and nothing more was done")
            text = line.strip() or "1"
            if text.isdecimal() and len(text) < 4 and 1 <= int(text) <= count:
                return int(text)
            typer.echo(f"expected a number from 1 to {count}", err=True)


def questions(
    registry: Registry, demonstration: Demonstration, doubts: Sequence[Doubt]
) -> Iterator[tuple[str, list[Element]]]:
    """Yield a question for each doubt, and the elements among which to choose."""
    for doubt in doubts:
        offered = _offered(doubt)
        texts = [printable(format_element(registry, element)) for element, _ in offered]
        time = float(demonstration.times[doubt.frame])
        head = f"element {doubt.number + 1} of '{doubt.parameter}', shown at {time:.1f} s, may be"
        rows = _table(texts, [chance for _, chance in offered])
        more = len(doubt.others) + 1 - len(offered)
        rows += [f"  and {counted(more, 'other')} that {'is' if more == 1 else 'are'} less probable"] * (
            more > 0
        )
        yield "\n".join([head, *rows]), [element for element, _ in offered]


def _meaning(registry: Registry, sentences: Sequence[str], choice: Choice) -> tuple[str, list[Element]]:
    """Return a question about a sentence, and the elements among which to choose."""
    offered = [(choice.element, choice.probability), *choice.others][:MOST]
    texts = [printable(format_element(registry, element)) for element, _ in offered]
    head = f"sentence {choice.sentence + 1}, '{printable(sentences[choice.sentence])}', may mean"
    rows = _table(texts, [chance for _, chance in offered])
    more = len(choice.others) + 1 - len(offered)
    rows += [f"  and {counted(more, 'other')} as well: say it more exactly"] * (more > 0)
    return "\n".join([head, *rows]), [element for element, _ in offered]


def draw_questions(
    folder: Path, registry: Registry, source: Shown, doubts: Sequence[Doubt]
) -> Iterator[Path]:
    """Write a picture of each doubt to a folder, and yield its file."""
    for number, doubt in enumerate(doubts, 1):
        path = folder / f"question_{number}.svg"
        _write(path, source.look(doubt.frame), _offers(registry, doubt), MEANT)
        yield path


def _write(path: Path, seen: Observation, offers: Sequence[Offer], title: str) -> None:
    with written_whole(path) as partial:
        partial.write_text(question_picture(seen, offers, title), encoding="utf-8")


def _offered(doubt: Doubt) -> list[tuple[Element, float]]:
    return [(doubt.element, doubt.probability), *doubt.others][:MOST]


def _offers(registry: Registry, doubt: Doubt) -> list[Offer]:
    """Return the elements that may be meant as a picture shows them."""
    return [
        (
            [str(value) for _, value in element.fields] if isinstance(element, Record) else [element],
            f"{printable(format_element(registry, element))}  {chance:.0%}",
        )
        for element, chance in _offered(doubt)
    ]


def _table(texts: Sequence[str], chances: Sequence[float]) -> list[str]:
    width = max(map(len, texts))
    pairs = zip(texts, chances, strict=True)
    return [f"  {number}  {text:<{width}}  {chance:4.0%}" for number, (text, chance) in enumerate(pairs, 1)]


def _nobody(count: int) -> str:
    return f"nobody can be asked here: add {' '.join(['--answer N'] * count)}"
