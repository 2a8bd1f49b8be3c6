"""Whatever is said is understood, asked about or refused, and never an error of the program."""

from __future__ import annotations

import random

import pytest
from listening import scene

from ntp_dsl.language.diagnostics.diagnostics import NtpError

WORDS = """put the a it that other one two all both on in into under of with from to between on top use as
for and then , . : is are goes takes carries where there so does place seat stack leave give first last right
left 3 5 cm 4 degrees object everything when bring swap"""


@pytest.mark.parametrize("name", ["block_stacking", "set_the_table", "serving", "seating"])
def test_any_run_of_words_is_understood_or_refused(name: str) -> None:
    who, _ = scene(name)
    rng = random.Random(name)
    words = WORDS.split() + [word for thing in who.vocabulary.things for word in thing.split("_")]
    understood = 0
    for _ in range(150):
        said = " ".join(rng.choice(words) for _ in range(rng.randrange(3, 14)))
        try:
            who.understand([said])
        except NtpError:
            continue
        understood += 1
    assert understood
