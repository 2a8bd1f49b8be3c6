"""How a declaration words itself: what its parameters are in its docstring, its `says`, and its name."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ntp_dsl.language.registry import Parameter, Registry
from ntp_dsl.sentences.consequences import element_said
from ntp_dsl.sentences.english import (
    DETERMINERS,
    EVERY,
    FILLERS,
    ONES,
    PREPOSITIONS,
    Role,
    name_words,
    singular,
    singulars,
    stem,
    words,
)
from ntp_dsl.sentences.grammar import readings
from ntp_dsl.sentences.senses import Mention, Sense
from ntp_dsl.sentences.splitting import split

BEFORE, AFTER = r"(?:\b(?:the|a|an|every|each|its|their|that)\s+)", r"(?:\s+(?:object|thing|one)\b)?"
Wording = tuple[Role | None, ...]  # what each parameter is in one of them; None where it does not occur


@dataclass(frozen=True)
class Form:
    """A program, an api or a predicate as something that can be said. Records fall into their fields."""

    name: str
    is_fact: bool  # a predicate, which is said to hold
    parameters: tuple[Parameter, ...]
    wordings: tuple[Wording, ...]
    verbs: frozenset[str]  # stems of the words that it uses
    is_element: bool = False  # of a list: its fields are told by types, or by their names


def form_of(registry: Registry, name: str, is_fact: bool, texts: Sequence[str]) -> Form:
    """Return how a declaration is worded.

    Args:
        texts: its docstring and what else it says of itself.
    """
    parameters = sayable(registry, _declared(registry, name, is_fact))
    wordings: dict[Wording, None] = {}
    verbs: set[str] = set()
    for text in texts:
        for clause in split(words(text), lambda tokens: _mentions(tokens, parameters)):
            if "other" in clause:  # "take other drinks off": none of these
                continue
            for found in readings(clause, _mentions(clause, parameters)):
                verbs |= found.verbs
                roles: list[Role | None] = [None] * len(parameters)
                for role, mention in found.parts:
                    for number in mention.senses[0].values:
                        roles[int(number)] = role
                if any(roles):
                    wordings[tuple(roles)] = None
    spoken = {each.name: "" for each in parameters}
    says_relation = any((word,) in PREPOSITIONS for word in name_words(name))
    if not wordings or says_relation or not any(filled(text, spoken) for text in texts):
        wordings[_by_name(name_words(name), len(parameters))] = None
    verbs |= {stem(word) for word in name_words(name) if word not in FILLERS | ONES | EVERY}
    return Form(name, is_fact, parameters, tuple(wordings), frozenset(verbs))


def form_of_elements(registry: Registry, parameter: Parameter) -> Form:
    """Return how an element of a list is told where its fields are named."""
    fields = registry.records.get(parameter.type, (Parameter(parameter.name, parameter.type),))
    verbs = frozenset(stem(word) for word in name_words(parameter.type))
    said = element_said(parameter.name, ())
    return Form(said.name, False, tuple(fields), ((None,) * len(fields),), verbs, is_element=True)


def sayable(registry: Registry, parameters: Sequence[Parameter]) -> tuple[Parameter, ...]:
    """Return parameters with records replaced by their fields; none where one is a list."""
    if any(each.is_list for each in parameters):
        return ()
    found: list[Parameter] = []
    for each in parameters:
        found += registry.records.get(each.type, (each,))
    return tuple(found)


def _declared(registry: Registry, name: str, is_fact: bool) -> tuple[Parameter, ...]:
    if not is_fact:
        return registry[name].parameters
    declared = registry.predicates[name]
    return tuple(Parameter(each.name, each.type.name) for each in declared.parameters)


def _mentions(tokens: Sequence[str], parameters: Sequence[Parameter]) -> list[Mention]:
    """Return where a text mentions parameters: by name, or else by type."""
    found: dict[int, Mention] = {}
    taken: set[int] = set()
    for by_type in (False, True):
        for number, parameter in enumerate(parameters):
            wanted = name_words(parameter.type if by_type else parameter.name)
            if number in found or not wanted:
                continue
            starts = range(len(tokens) - len(wanted) + 1)
            for at in sorted(starts, key=lambda at: _rank(tokens[at - 1] if at else "")):
                end = at + len(wanted)
                if not _alike(wanted, tokens[at:end]) or not taken.isdisjoint(range(at, end)):
                    continue
                begin = at
                while begin and tokens[begin - 1] in DETERMINERS | {"{"}:
                    begin -= 1
                end += tokens[end : end + 1] == ["}"]
                found[number] = Mention(begin, end, (Sense((str(number),)),))
                taken |= {*range(begin, end)}
                break
    return sorted(found.values(), key=lambda each: each.begin)


def _rank(before: str) -> int:
    """Return how little the word before a noun shows that it is meant: braces, an article, anything."""
    return 0 if before == "{" else 1 if before in DETERMINERS else 2


def _alike(wanted: Sequence[str], given: Sequence[str]) -> bool:
    return all(
        word in singulars(each) or singular(word) == singular(each)
        for word, each in zip(wanted, given, strict=True)
    )


def _by_name(name: Sequence[str], count: int) -> Wording:
    """Return what the parameters are where a name such as `put_in` is spoken: "put … in …"."""
    roles: list[Role | None] = [None] * count
    if not count:
        return ()
    places = [f"{{{number}}}" for number in range(count)]
    tokens = spoken_by_name(name, places)
    mentions = [
        Mention(at, at + 1, (Sense((str(places.index(word)),)),))
        for at, word in enumerate(tokens)
        if word in places
    ]
    for role, mention in readings(tokens, mentions)[0].parts:
        for number in mention.senses[0].values:
            roles[int(number)] = role
    return tuple(roles)


def spoken_by_name(name: Sequence[str], values: Sequence[str]) -> list[str]:
    """Return a name with values where a person would say them: after its verb, and after its preposition."""
    relation = next((at for at, word in enumerate(name) if (word,) in PREPOSITIONS), None)
    if relation is None or len(values) < 2:
        return [*name, *values]
    return [*name[:relation], values[0], *name[relation:], *values[1:]]


def filled(text: str, spoken: Mapping[str, str]) -> str:
    """Return the first clause of a text with its parameters replaced; nothing where one does not occur.

    Where the text has braces, these alone are places.
    """
    text = re.split(r"[.;:,](?:\s|$)", " ".join(text.split()))[0]
    if not spoken:
        return ""
    spans: dict[str, tuple[int, int]] = {}
    for name in sorted(spoken, key=len, reverse=True):
        noun = re.escape(name.replace("_", " "))
        patterns = [rf"{BEFORE}?\{{ *{re.escape(name)} *\}}"] if "{" in text else []
        patterns = patterns or [rf"{BEFORE}{noun}\b{AFTER}", rf"\b{noun}\b{AFTER}"]
        matches = (match for each in patterns for match in re.finditer(each, text, re.IGNORECASE))
        free = (m.span() for m in matches if all(m.end() <= a or m.start() >= b for a, b in spans.values()))
        span = next(free, None)
        if span is None:
            return ""
        spans[name] = span
    for name, (begin, end) in sorted(spans.items(), key=lambda each: -each[1][0]):
        text = text[:begin] + spoken[name] + text[end:]
    return text
