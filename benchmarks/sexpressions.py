"""From the text of a planning problem to nested lists of words: what PDDL and BDDL have in common."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

TOKEN = re.compile(r"[()]|[^\s()]+")

Sexp = list["Sexp"] | str


def read_problem(path: Path) -> list[Sexp]:
    """Return what `(define ...)` contains in a file, without comments."""
    tokens = TOKEN.findall(re.sub(r";.*", "", path.read_text(encoding="utf-8")))
    return _tree(iter(tokens[1:]))


def _tree(tokens: Iterator[str]) -> list[Sexp]:
    found: list[Sexp] = []
    for token in tokens:
        if token == ")":
            return found
        found.append(_tree(tokens) if token == "(" else token)
    return found


def parts_of(problem: Sequence[Sexp]) -> dict[str, list[Sexp]]:
    """Return the parts of a problem, such as `:objects`, by their first word, in lower case."""
    return {str(part[0]).lower(): part[1:] for part in problem if isinstance(part, list) and part}


def flat(tree: Sequence[Sexp]) -> Iterator[str]:
    """Yield all words in their order."""
    for each in tree:
        yield from flat(each) if isinstance(each, list) else [each]


def typed(words: Sequence[Sexp]) -> Iterator[tuple[str, str]]:
    """Yield the names of `a b - kind` with their kind; those without one at the end with `object`."""
    waiting: list[str] = []
    rest = iter(map(str, words))
    for word in rest:
        if word == "-":
            kind = next(rest, "object")
            yield from ((name, kind) for name in waiting)
            waiting = []
        else:
            waiting.append(word)
    yield from ((name, "object") for name in waiting)
