"""What somebody says on the command line: sentences, or files of them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from ntp_dsl.cli.dialogue.asking import Interview
from ntp_dsl.cli.display import messages
from ntp_dsl.common.text import printable
from ntp_dsl.evaluation.episode_parts import starting_scene
from ntp_dsl.evaluation.episodes import Evaluator, GivenLists
from ntp_dsl.evaluation.rehearsal import shortfall
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.sentences.amending import amended
from ntp_dsl.sentences.understanding import Listener, Understood
from ntp_dsl.tasks.goal_text import Lists, format_lists, parse_lists
from ntp_dsl.tasks.instances import as_told

LONGEST = 10_000  # characters of a file
MOST = 200  # sentences
UNDERSTOOD = "what was understood"


def sentences_of(given: Sequence[str]) -> list[str]:
    """Return the sentences of `--say`: each is one, or a file with one a line.

    Raises `NtpError` where there are none, and for a file that cannot be read.
    """
    found: list[str] = []
    for each in given:
        found += _lines(Path(each)) if _is_file(each) else [each]
    kept = [" ".join(each.split()) for each in found if each.strip() and not each.strip().startswith("#")]
    if not kept:
        raise NtpError(
            '--say: expected a sentence, such as "put block 1 on block 2", or a file with one a line'
        )
    if len(kept) > MOST:
        raise NtpError(f"--say: expected up to {MOST} sentences, found {len(kept)}")
    return kept


def _is_file(given: str) -> bool:
    """Return whether a text is meant as a file: it ends like one, and is there or has no blanks."""
    if "/" not in given and re.search(r"\w\.\w+$", given) is None:
        return False
    return " " not in given.strip() or (len(given) < 256 and Path(given).is_file())


def _lines(path: Path) -> list[str]:
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise NtpError(f"{path}: expected sentences, as text in UTF-8") from error
    except OSError as error:
        raise NtpError(f"{path}: {error.strerror}") from error
    if len(text) > LONGEST:
        raise NtpError(f"{path}: expected sentences, one a line, in at most {LONGEST} characters")
    return text.splitlines()


def understood(evaluator: Evaluator, sentences: Sequence[str], interview: Interview) -> Understood:
    """Return what sentences say of the lists of a task; what may mean several things is asked."""
    listener = evaluator.listener(0)
    found = listener.understand(sentences)
    for number, word in found.passed_over:
        messages.print(
            f"sentence {number + 1}: '{printable(word)}' means nothing here; it was understood without it",
            style="yellow",
        )
    return interview.meanings(listener, sentences, found)


def told(evaluator: Evaluator, sentences: Sequence[str], interview: Interview) -> GivenLists:
    """Return the lists that sentences tell, and print them as they are understood."""
    found = understood(evaluator, sentences, interview)
    return _as_told(evaluator, found.arguments, sentences, found.probability)


def changed(
    evaluator: Evaluator, read: tuple[Argument, ...], sentences: Sequence[str], probability: float
) -> GivenLists:
    """Return the lists of a demonstration as sentences change them, and print them."""
    return _as_told(evaluator, as_changed(evaluator, read, sentences), sentences, probability)


def as_changed(
    evaluator: Evaluator, read: tuple[Argument, ...], sentences: Sequence[str]
) -> tuple[Argument, ...]:
    """Return a program's arguments, as a demonstration shows them and sentences change them."""
    listener: Listener = evaluator.listener(0)
    for sentence in sentences:
        read = amended(listener, read, sentence)
    return read


def text_of(evaluator: Evaluator, arguments: tuple[Argument, ...]) -> str:
    """Return the lists among a program's arguments as goal text.

    Raises `NtpError`, with the lists printed, for what the program does not take or what cannot come about.
    """
    text = _text(evaluator, arguments)
    try:
        _rehearsed(evaluator, text)
    except NtpError:
        _print_understood(text)
        raise
    return text


def _as_told(
    evaluator: Evaluator, arguments: tuple[Argument, ...], sentences: Sequence[str], probability: float
) -> GivenLists:
    """Print lists as they were understood, and return them."""
    text = _text(evaluator, arguments)
    _print_understood(text)
    return GivenLists(_rehearsed(evaluator, text), UNDERSTOOD, tuple(sentences), probability)


def _text(evaluator: Evaluator, arguments: tuple[Argument, ...]) -> str:
    registry = evaluator.registry
    return format_lists(registry, registry.programs[evaluator.instance(0).program], arguments)


def _print_understood(text: str) -> None:
    for line in text.splitlines():
        messages.print(f"understood: {printable(line.strip())}")


def _rehearsed(evaluator: Evaluator, text: str) -> Lists:
    """Return the lists of a goal text, once an expert has brought them about without physics.

    Raises `NtpError` for what the program does not take, and where not all of it comes about.
    """
    registry, instance = evaluator.registry, evaluator.instance(0)
    lists = parse_lists(text, UNDERSTOOD, registry, registry.programs[instance.program], instance.objects)
    meant = as_told(registry, instance, lists, UNDERSTOOD)
    scene = starting_scene(registry, meant, evaluator.plan.seed, 0)
    if lacking := shortfall(registry, meant, scene):
        raise NtpError(f"not all of this comes about, as a rehearsal without physics shows: {lacking}")
    return lists
