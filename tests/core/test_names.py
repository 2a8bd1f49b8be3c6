"""Names decide nothing: a library whose every name is another one is decided alike, call by call."""

from __future__ import annotations

import re
from random import Random

import pytest
from one_core_samples import the_model

from ntp_dsl.api import demonstrate, draw, run
from ntp_dsl.common.resources import examples_folder
from ntp_dsl.language.loader import load_text
from ntp_dsl.language.parsing.parser import parse
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.soup import random_library
from ntp_dsl.soup.library import written
from ntp_dsl.soup.names import Names
from ntp_dsl.worlds.protocol import Disturbances

EXAMPLES = ["block_stacking", "seating", "serving"]
FEW, MANY = 2, 8
DISTURBED = Disturbances(slips=0.2, noise=0.002)

Trail = list[tuple[int, ...]]


def trail(registry: Registry, task: str, seed: int) -> Trail:
    """Return every call of a run from one demonstration, each name and value as where it occurs first."""
    drawn = draw(registry, task, seed)
    shown = demonstrate(drawn).demonstration
    policy = the_model(registry, drawn.instance.program).shown(shown)
    trace = run(drawn, policy, disturbances=DISTURBED).trace
    first: dict[object, int] = {}
    return [
        tuple(
            first.setdefault(value, len(first))
            for value in (each.name, *map(str, plain(each.arguments)), str(each.scope), str(each.outcome))
        )
        for each in trace.calls
    ]


def plain(arguments: tuple[object, ...]) -> list[object]:
    return [value for value in arguments if not isinstance(value, tuple)]


# Examples, with other names by substitution


def with_other_names(text: str, seed: int) -> tuple[str, dict[str, str]]:
    """Return a library's text with every type, record, field, predicate, program, group and task renamed."""
    tree = parse(text)
    own = {each.name for each in tree.declarations}
    for each in tree.declarations:
        own |= {field.name for field in getattr(each, "fields", ())}
        own |= {parameter.name for parameter in getattr(each, "parameters", ())}
        own |= set(getattr(each, "members", ()))
        own |= set(re.findall(r"\bfor (\w+) in\b", text))
        if isinstance(each, nodes.TaskDeclaration):
            own |= {group.name for group in each.scene}
    own -= {"goal"}  # the word of the language for what a sampler draws
    names = Names(Random(seed))
    others = {name: names.type() if name[0].isupper() else names.word() for name in sorted(own)}
    bare = re.sub(r'""".*?"""', "", text, flags=re.DOTALL)
    return re.sub(r"\w+", lambda word: others.get(word[0], word[0]), bare), others


@pytest.mark.parametrize("example", EXAMPLES)
def test_an_example_with_other_names_is_decided_alike(example: str, soak: bool) -> None:
    text = (examples_folder() / example / f"{example}.ntp").read_text()
    other, names = with_other_names(text, 7)
    own_registry, registry = load_text(text), load_text(other)
    assert not set(own_registry.tasks) & set(registry.tasks)
    for task in own_registry.tasks:
        for seed in range(MANY if soak else FEW):
            own = trail(own_registry, task, seed)
            assert trail(registry, names[task], seed) == own and len(own) > 3


# Libraries that nobody wrote


def test_an_unseen_library_with_other_names_is_decided_alike(soak: bool) -> None:
    for seed in range(2000, 2020 if soak else 2003):
        registries = [load_text(random_library(seed)), load_text(written(seed, Names(Random("others"))))]
        for tasks in zip(*(registry.tasks for registry in registries), strict=True):
            one, other = (trail(*each, 1) for each in zip(registries, tasks, strict=True))
            assert one == other, f"soup {seed}: {tasks}"
