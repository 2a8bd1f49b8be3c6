"""Measures how instructions are understood that people wrote for the project's libraries.

In `instructions.tsv` sentences are separated by `//`, elements by `;`, and what is right as well by `OR`;
`ASK` is a due question.

python benchmarks/instructions.py
"""

from __future__ import annotations

import csv
import json
from collections import Counter, defaultdict
from functools import cache
from pathlib import Path

from ntp_dsl.core.one_core import shipped_core
from ntp_dsl.evaluation.episodes import Evaluator, Plan
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.sentences.elements import values_of
from ntp_dsl.sentences.understanding import SURE_ENOUGH, Listener

ROOT = Path(__file__).parents[1]
Values = tuple[str | float, ...]


@cache
def listener(library: str, task: str, seed: int) -> Listener:
    return Evaluator(Plan(ROOT / library, task, shipped_core(), seed=seed)).listener(0)


def meant(text: str) -> list[set[Values]]:
    """Return the lists that are right, each as the values of its elements."""
    ways = (way for way in text.split(" OR ") if "(" in way)
    return [{_values(each.strip()[1:-1]) for each in way.split(";")} for way in ways]


def _values(text: str) -> Values:
    return tuple(_value(each.strip()) for each in text.split(","))


def _value(text: str) -> str | float:
    try:
        return round(float(text), 4)
    except ValueError:
        return text


def verdict(who: Listener, sentences: list[str], wanted: str) -> str:
    """Return what became of an instruction: right, asked, refused or wrong."""
    try:
        found = who.understand(sentences)
    except NtpError:
        return "refused"
    if any(each.probability < SURE_ENOUGH for each in found.choices):
        return "right" if wanted.endswith("ASK") else "asked"
    elements = {
        tuple(round(v, 4) if isinstance(v, float) else v for v in values_of(each.element))
        for each in found.choices
    }
    return "right" if elements in meant(wanted) else "wrong"


def main() -> None:
    counts: defaultdict[str, Counter[str]] = defaultdict(Counter)
    with (ROOT / "benchmarks" / "instructions.tsv").open(encoding="utf-8") as file:
        for row in csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE):
            who = listener(row["library"], row["task"], int(row["seed"]))
            became = verdict(who, row["sentences"].split(" // "), row["meant"])
            counts[row["wording"]][became] += 1
            if became != "right":
                print(f"{became}: {row['library']}: {row['sentences']}")
    print(json.dumps(counts, indent=1))


if __name__ == "__main__":
    main()
