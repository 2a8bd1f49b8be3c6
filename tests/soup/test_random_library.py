"""Random libraries: a function of the seed, canonical, sound, and what their experts reach."""

from __future__ import annotations

import re
from collections import Counter
from functools import cache
from pathlib import Path
from random import Random

import pytest

from ntp_dsl.api import draw, expert_policy, run
from ntp_dsl.dynamic.check import check_dynamically
from ntp_dsl.language.formatting.canonical import format_text
from ntp_dsl.language.loader import diagnose_text, load, load_text
from ntp_dsl.language.parsing.parser import parse
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.visitors import walk
from ntp_dsl.soup import library_name, random_library
from ntp_dsl.soup.library import written
from ntp_dsl.soup.names import Names

FEW, MANY = 40, 300  # of the static checks
SIMULATED, EPISODES = 3, 3  # without `--soak`; of each task
SOUND, REACHED = 0.99, 0.98

text_of = cache(random_library)


def seeds(soak: bool, few: int) -> range:
    return range(MANY if soak else few)


@pytest.mark.parametrize("seed", range(5))
def test_a_library_is_a_function_of_its_seed(seed: int) -> None:
    assert random_library(seed) == random_library(seed)
    assert random_library(seed).startswith(f"library {library_name(seed)}\n")


def test_other_seeds_are_other_libraries() -> None:
    shapes = {_renamed(text_of(seed)) for seed in range(FEW)}
    assert len(shapes) == FEW


def test_a_library_is_canonical_and_its_text_without_errors(soak: bool) -> None:
    for seed in seeds(soak, FEW):
        assert format_text(text_of(seed)) == text_of(seed), f"seed {seed}"
        errors = [each for each in diagnose_text(text_of(seed)).diagnostics if each.severity == "error"]
        assert not errors, f"seed {seed}: {errors[0].code} {errors[0].message}"


def test_no_name_is_given_twice_or_by_a_library_that_is_used() -> None:
    used = load("containers")
    taken = {*used.parents, *used.records, *used.predicates, *used.apis, *used.programs, *used.constants}
    for seed in range(FEW):
        found = parse(text_of(seed)).declarations
        enums = [each for each in found if isinstance(each, nodes.EnumDeclaration)]
        names = [each.name for each in found] + [member for each in enums for member in each.members]
        assert Counter(name.lower() for name in names).most_common(1)[0][1] == 1, f"seed {seed}"
        assert not taken & set(names), f"seed {seed}"


@pytest.mark.parametrize("seed", range(5))
def test_what_things_are_called_decides_nothing_else(seed: int) -> None:
    others = written(seed, Names(Random("other names")))
    assert others != text_of(seed)
    assert _renamed(others) == _renamed(text_of(seed))


def _renamed(text: str) -> tuple[str, ...]:
    """Return the words of a text, each as the place where it occurs first.

    Brackets and commas are left out: where lines are too long, the layout adds some.
    """
    words = re.findall(r"\w+|[^\w\s(),]", text.split("\n", 1)[1])
    first = {word: index for index, word in reversed(list(enumerate(words)))}
    return tuple(str(first[word]) for word in words)


def test_the_libraries_use_the_whole_language() -> None:
    """Count what a core could not learn from if it did not occur."""
    found: Counter[str] = Counter()
    for seed in range(FEW):
        registry = load_text(text_of(seed))
        predicates = [each for each in registry.predicates.values() if each.span.path is None]
        bodies = [part for each in predicates if each.body for part in walk(each.body)]
        found.update({type(part).__name__ for part in bodies})
        rows = [row for row in registry.programs.values() if row.span.path is None]
        found.update({type(statement).__name__ for row in rows for statement in row.body})
        found.update(f"sampler {task.goal.name}" for task in registry.tasks.values() if task.goal)
        found.update(
            {f"shape {shape}" for shape in ("bin(", "bowl(", "box(", "cylinder(") if shape in text_of(seed)}
        )
        found["record parameter"] += any(
            p.type in registry.records for r in rows for p in r.parameters if not p.is_list
        )
        found["two lists"] += any(sum(p.is_list for p in row.parameters) > 1 for row in rows)
        found["list in list"] += any(
            registry.programs[name].takes_list
            for row in rows
            for name in row.callees
            if name in registry.programs
        )
        found["number"] += any(p.type == "length" for row in rows for p in row.parameters)
        found["wide record"] += any(len(fields) > 2 for fields in registry.records.values())
        found["own api"] += any(api.span.path is None for api in registry.apis.values())
    wanted = (
        "Atom Compare Not And Or Quantified Arithmetic Call When For|sampler towers|sampler matchings|"
        "sampler permutations|shape bin(|shape bowl(|shape box(|shape cylinder(|record parameter|two lists|"
        "list in list|number|wide record|own api"
    )
    kinds = [*wanted.split("|")[0].split(), *wanted.split("|")[1:]]
    assert {kind: found[kind] for kind in kinds if not found[kind]} == {}


def test_a_library_is_sound_by_simulation_and_its_experts_reach_their_goals(
    soak: bool, tmp_path: Path
) -> None:
    unsound, episodes, successes = [], 0, 0
    for seed in seeds(soak, SIMULATED):
        registry = load_text(text_of(seed))
        if any(each.severity == "error" for each in check_dynamically(registry)):
            unsound.append(seed)
        for name in registry.tasks:
            for number in range(EPISODES):
                task = draw(registry, name, number)
                episodes += 1
                successes += bool(run(task, expert_policy(task)).success)
    assert 1 - len(unsound) / len(seeds(soak, SIMULATED)) >= SOUND, unsound
    assert successes / episodes >= REACHED, f"{successes} of {episodes}"
