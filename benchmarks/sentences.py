"""Measures tasks that are told in sentences: `sentence_templates.py`, over unseen goals and starts.

python benchmarks/sentences.py --episodes 100                    # ordered and free wording, kinematic
python benchmarks/sentences.py --episodes 20 --world bullet
python benchmarks/sentences.py --understanding                   # every template once, without running
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import sentence_templates as said_by_people

from ntp_dsl.core.one_core import shipped_core
from ntp_dsl.evaluation.episodes import Evaluator, GivenLists, Plan
from ntp_dsl.evaluation.listening import as_lists
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import Record
from ntp_dsl.sentences.amending import amended
from ntp_dsl.sentences.narration import said
from ntp_dsl.sentences.understanding import SURE_ENOUGH, Understood
from ntp_dsl.tasks.instances import Instance

EXAMPLES = Path(__file__).parents[1] / "examples"


@dataclass(frozen=True)
class Domain:
    """A task, and the sentences for its elements in ordered and in free wording."""

    name: str
    ordered: Sequence[str]
    free: Sequence[str]


DOMAINS = (
    Domain("block_stacking", said_by_people.ON_ORDERED, said_by_people.ON_FREE),
    Domain("seating", said_by_people.ON_ORDERED, said_by_people.ON_FREE),
    Domain("table_cleanup", said_by_people.IN_ORDERED, said_by_people.IN_FREE),
    Domain("object_sorting", said_by_people.KIND[:20], said_by_people.KIND[20:]),
    Domain("serving", said_by_people.MEMBER[:15], said_by_people.MEMBER[15:]),
    Domain("set_the_table", said_by_people.SIDE_ORDERED, said_by_people.SIDE_FREE),
)


def sentence(template: str, element: Record) -> str:
    """Return a template with an element's objects and members in it."""
    values = {name: said(value) for name, value in element.fields}
    first, *_, last = values.values()
    return template.format(a=first, b=last, k=_kind(element, template), **values)


def _kind(element: Record, template: str) -> str:
    name = str(element.fields[0][1])
    return name if template in said_by_people.MEMBER else f"{name}s"


def goal(instance: Instance) -> list[Record]:
    return [each for each in instance.goal if ("side", "ahead") not in each.fields]


def told(evaluator: Evaluator, number: int, templates: Sequence[str]) -> tuple[list[str], Instance]:
    """Return a sentence for each element of an episode's goal, and its task."""
    instance = evaluator.instance(number)
    rng = np.random.default_rng(number)
    rows = goal(instance)
    return [sentence(templates[int(rng.integers(len(templates)))], each) for each in rows], instance


def run(domain: Domain, templates: Sequence[str], arguments: argparse.Namespace) -> dict[str, Any]:
    """Return how often the goal that was told is built, and why not."""
    evaluator = Evaluator(
        Plan(EXAMPLES / domain.name, domain.name, shipped_core(), arguments.world, seed=arguments.seed)
    )
    episodes, won, asked = 0, 0, 0
    failed: list[str] = []
    for number in range(arguments.episodes):
        evaluator.tell(None)
        sentences, instance = told(evaluator, number, templates)
        if not sentences:  # only of sides that no template says
            continue
        episodes += 1
        try:
            found = evaluator.listener(number).understand(sentences)
            asked += any(each.probability < SURE_ENOUGH for each in found.choices)
            lists = as_lists(evaluator.registry, instance.program, found.arguments)
            if {each for some in lists.values() for each in some} != {*goal(instance)}:
                raise NtpError(f"understood {[*map(str, lists.values())]} of {' / '.join(sentences)}")
            evaluator.tell(GivenLists(lists, "the sentences", tuple(sentences), found.probability))
            episode = evaluator.episode(number)
        except NtpError as error:
            failed.append(f"{number}: {str(error).splitlines()[0]}")
            continue
        won += bool(episode.success)
        if not episode.success:
            failed.append(f"{number}: {episode.attributed_to}: {episode.reason}")
    shares = {"success": round(won / episodes, 4), "asked": round(asked / episodes, 4)}
    return {"episodes": episodes, **shares, "failed": failed}


def understood(domain: Domain, templates: Sequence[str], seed: int) -> Iterator[tuple[str, str]]:
    """Yield each template's sentence, and what became of it: right, asked, refused or wrong."""
    evaluator = Evaluator(Plan(EXAMPLES / domain.name, domain.name, None, seed=seed))
    for number, template in enumerate(templates):
        instance = evaluator.instance(number % 20)
        rows = goal(instance) or list(instance.goal)
        text = sentence(template, rows[number % len(rows)])
        listener = evaluator.listener(number % 20)
        try:
            found = listener.understand([text])
        except NtpError:
            yield text, "refused"
            continue
        yield text, _verdict(found, rows[number % len(rows)])


def _verdict(found: Understood, wanted: Record) -> str:
    if [each.element for each in found.choices] != [wanted]:
        return "wrong"
    return "asked" if found.choices[0].probability < SURE_ENOUGH else "right"


def ambiguous(seed: int) -> Iterator[tuple[str, str]]:
    """Yield sentences that leave open what is meant, and whether that is noticed."""
    evaluator = Evaluator(Plan(EXAMPLES / "block_stacking", "block_stacking", None, seed=seed))
    listener = evaluator.listener(0)
    for text in said_by_people.AMBIGUOUS:
        try:
            found = listener.understand([text])
        except NtpError:
            yield text, "refused"
            continue
        doubtful = any(each.probability < SURE_ENOUGH for each in found.choices)
        yield text, "asked" if doubtful else "wrong"


def mixed(seed: int) -> Iterator[tuple[str, str]]:
    """Yield sentences that change a list, and whether they change it as they say."""
    evaluator = Evaluator(Plan(EXAMPLES / "block_stacking", "block_stacking", None, seed=seed))
    for number, (kind, template) in enumerate(said_by_people.MIXED):
        shown = next(
            each
            for attempt in range(number, number + 50)
            if 3 <= len(each := evaluator.instance(attempt).goal) <= 6
        )
        listener = evaluator.listener(0)
        a, b, c = _roles(kind, shown, number)
        text = template.format(a=said(a), b=said(b), c=said(c))
        try:
            [after] = amended(listener, [shown], text)
        except NtpError:
            yield text, "refused"
            continue
        assert isinstance(after, tuple)
        yield text, "right" if {*after} == {*_changed(kind, shown, a, b, c)} else "wrong"


def _roles(kind: str, shown: Sequence[Record], number: int) -> tuple[str, str, str]:
    """Return the blocks that a sentence names: one that is shown, a support, and another."""
    items = [str(each["item"]) for each in shown]
    supports = [str(each["support"]) for each in shown]
    blocks = [f"block_{n}" for n in range(8)]
    fresh = [each for each in blocks if each not in items]
    a = fresh[0] if kind == "add" else items[number % len(items)]
    b = next(each for each in blocks if each != a and each not in supports)
    c = items[(number + 1) % len(items)] if kind == "swap" else next(each for each in fresh if each != a)
    return a, b, c


def _changed(kind: str, shown: Sequence[Record], a: str, b: str, c: str) -> list[Record]:
    new = Record("Placement", (("item", a), ("support", b)))
    match kind:
        case "replace":
            return [new if each["item"] == a else each for each in shown]
        case "drop":
            return [each for each in shown if each["item"] != a]
        case "drop_last":
            return [*shown[:-1]]
        case "drop_first":
            return [*shown[1:]]
        case "add":
            return [*shown, new]
    names = {a: c} if kind == "instead" else {a: c, c: a}
    return [_renamed(each, names) for each in shown]


def _renamed(element: Record, names: dict[str, str]) -> Record:
    return Record(element.type, tuple((name, names.get(str(v), str(v))) for name, v in element.fields))


def counted(rows: Iterator[tuple[str, str]]) -> dict[str, Any]:
    found = list(rows)
    share = {kind: sum(each == kind for _, each in found) for kind in ("right", "asked", "refused", "wrong")}
    return {**share, "not right": [f"{kind}: {text}" for text, kind in found if kind != "right"]}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--episodes", type=int, default=100)
    parser.add_argument("--world", default="kinematic")
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--understanding", action="store_true", help="understand every template; run nothing")
    parser.add_argument("--only", default="", help="a domain")
    arguments = parser.parse_args()
    found: dict[str, Any] = {}
    for domain in DOMAINS:
        for tier in ("ordered", "free") if arguments.only in ("", domain.name) else ():
            templates: Sequence[str] = getattr(domain, tier)
            if arguments.understanding:
                found[f"{domain.name} {tier}"] = counted(understood(domain, templates, arguments.seed))
            else:
                found[f"{domain.name} {tier}"] = run(domain, templates, arguments)
            figures = {k: v for k, v in found[f"{domain.name} {tier}"].items() if not isinstance(v, list)}
            print(f"{domain.name} {tier}", figures, flush=True)
    if arguments.understanding:
        found["ambiguous"] = counted(ambiguous(arguments.seed))
        found["mixed"] = counted(mixed(arguments.seed))
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
