"""`ntp read`: what a demonstration says."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ntp_dsl.cli.dialogue.asking import Interview, draw_questions, questions
from ntp_dsl.cli.dialogue.saying import as_changed, sentences_of, text_of, understood
from ntp_dsl.cli.display import answers, messages, print_json
from ntp_dsl.cli.models import model_or_shipped
from ntp_dsl.cli.options import DemoBy, DemoNoise, DemoRate, Json, Library, Model, Say, Seed, Task, shown_at
from ntp_dsl.common.text import counted, printable
from ntp_dsl.demonstrations.demonstration_files import read_demonstration
from ntp_dsl.evaluation.demonstration_remarks import act, remarks
from ntp_dsl.evaluation.episodes import Evaluator, Plan
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.tasks.goal_text import format_element, format_lists

if TYPE_CHECKING:
    from ntp_dsl.core.reading.reading import Doubt


SURE = 0.95  # probability from which on nothing is said
MOST = 12  # acts that are told


def command(
    library: Library,
    task: Task,
    demo: Annotated[
        Path | None,
        typer.Option(help="A demonstration file; by default the expert records one from the seed."),
    ] = None,
    say: Say = None,
    answer: Annotated[
        list[int] | None,
        typer.Option(min=1, help="Answer to what a sentence leaves open, by number, in order."),
    ] = None,
    model: Model = None,
    seed: Seed = 0,
    demo_noise: DemoNoise = 0.0,
    demo_by: DemoBy = None,
    demo_rate: DemoRate = None,
    pictures: Annotated[
        Path | None, typer.Option(help="Folder for a picture of each element that may be another.")
    ] = None,
    json: Json = False,
) -> int:
    """Print what a demonstration shows, or sentences say: the lists that the task's program is called with.

    With both --demo and --say, the sentences change what the demonstration shows, and the lists that come
    of it are printed.

    The text can be edited, and `ntp run --goal` takes it back. A comment says how much of what the hand does
    is explained by it; others, which elements may as well be others, how probable each is, which numbers may
    be off, and what was put somewhere for no reason. Exit status: 0 all of it is explained, 1 some is not.

    Example: ntp read block_stacking block_stacking --seed 3 > goal.txt
    """
    from ntp_dsl.core.models import OneCoreModel, open_model

    if say and demo is None:
        if demo_noise or demo_by or pictures:
            raise NtpError(
                "--say without --demo reads sentences, and no demonstration: omit what is about one"
            )
        return _read_sentences(library, task, model, seed, sentences_of(say), answer or [], json)
    if answer:
        raise NtpError("--answer goes with --say, and without --demo")
    if demo and (demo_noise or demo_by):
        raise NtpError("--demo is a demonstration, and --demo-noise and --demo-by say how to make one")
    rate = shown_at(demo_by, demo_rate)
    plan = Plan(library, task, None, seed=seed, demo_noise=demo_noise, demo_by=demo_by, demo_rate=rate)
    evaluator = Evaluator(plan)
    registry, instance = evaluator.registry, evaluator.instance(0)
    found = open_model(model_or_shipped(model), registry, instance.program)
    if not isinstance(found, OneCoreModel):
        raise NtpError("a checkpoint of `ntp train` says nothing of what it reads: leave out --model")
    if demo is None:
        messages.print(f"no --demo: the expert demonstrates the task once, from seed {seed}")
        demonstration = evaluator.demonstration(instance, 0)[0].demonstration
    else:
        demonstration = read_demonstration(demo, instance.objects)
        for remark in remarks(registry, instance, demonstration):
            messages.print(remark, style="yellow")
    source = found.read(demonstration)
    scope = source.scope()
    assert scope is not None
    reading = source.reading(instance.program, instance.arguments, scope)
    if pictures is not None:
        for path in draw_questions(pictures, registry, source, reading.doubts):
            messages.print(f"wrote {path}")
    program = registry.programs[instance.program]
    if say:
        sentences = sentences_of(say)
        arguments = as_changed(evaluator, reading.arguments, sentences)
        text = text_of(evaluator, arguments)
        if json:
            print_json({"text": text})
        else:
            answers.print(f"# {counted(len(sentences), 'sentence')} heeded")
            answers.print(text, end="")
        return 0
    text = format_lists(registry, program, reading.arguments)
    if json:
        lists = {
            parameter.name: [dict(each.fields) if hasattr(each, "fields") else each for each in value]
            for parameter, value in zip(program.parameters, reading.arguments, strict=True)
            if isinstance(value, tuple)
        }
        print_json(
            {
                "lists": lists,
                "text": text,
                "explained": reading.explained,
                "acts": reading.acts,
                "unexplained": [{"frame": frame} for frame in reading.unexplained],
                "unshown": list(reading.unshown),
                "probability": round(reading.probability, 4),
                "doubts": [_doubt(registry, each) for each in reading.doubts],
                "measures": [
                    {
                        "list": each.parameter,
                        "number": each.number + 1,
                        "element": format_element(registry, each.element),
                        "probability": round(each.probability, 4),
                    }
                    for each in reading.measures
                ],
                "strays": [{"item": each.item, "frame": each.frame} for each in reading.strays],
            }
        )
    else:
        acts = counted(reading.acts, "act")
        answers.print(f"# {reading.explained} of {acts} of the hand explained, by {program.name}")
        if reading.probability < SURE:
            answers.print(f"# probability {reading.probability:.0%}")
        for field in reading.unshown:
            answers.print(
                f"# {field}: nothing that {program.name} achieves is about it; "
                "it is read from what the hand does alone"
            )
        for question, _ in questions(registry, demonstration, reading.doubts):
            for row in question.splitlines():
                answers.print(f"# {row}")
        for frame in reading.unexplained[:MOST]:
            answers.print(f"# not explained: {act(demonstration, frame)}")
        if (more := len(reading.unexplained) - MOST) > 0:
            answers.print(f"# and {counted(more, 'more act')}")
        for stray in reading.strays:
            time = float(demonstration.times[stray.frame])
            answers.print(f"# for no reason: where {printable(stray.item)} is put last, at {time:.1f} s")
        for each in reading.measures:
            if each.probability < SURE:
                what = printable(format_element(registry, each.element))
                answers.print(f"# the numbers of {what} are near enough: {each.probability:.0%}")
        for row in text.splitlines():
            answers.print(printable(row))
    return int(not reading.is_whole)


def _read_sentences(
    library: Path,
    task: str,
    model: Path | None,
    seed: int,
    sentences: list[str],
    answers_given: list[int],
    json: bool,
) -> int:
    evaluator = Evaluator(Plan(library, task, model_or_shipped(model), seed=seed))
    registry = evaluator.registry
    interview = Interview(registry, answers_given, None)
    found = understood(evaluator, sentences, interview)
    if interview.unused:
        verb = "was" if interview.unused == 1 else "were"
        messages.print(f"{counted(interview.unused, 'answer')} {verb} not used: nothing else was asked")
    text = text_of(evaluator, found.arguments)
    if json:
        choices = [
            {
                "sentence": sentences[each.sentence],
                "list": each.parameter,
                "element": format_element(registry, each.element),
                "probability": round(each.probability, 4),
            }
            for each in found.choices
        ]
        print_json({"text": text, "probability": round(found.probability, 4), "elements": choices})
    else:
        answers.print(f"# {counted(len(sentences), 'sentence')} understood")
        answers.print(text, end="")
    return 0


def _doubt(registry: Registry, doubt: Doubt) -> dict[str, object]:
    return {
        "list": doubt.parameter,
        "number": doubt.number + 1,
        "element": format_element(registry, doubt.element),
        "probability": round(doubt.probability, 4),
        "others": [
            {"element": format_element(registry, element), "probability": round(chance, 4)}
            for element, chance in doubt.others
        ],
    }
