"""Mutations of texts: edits of users, accidents, and comments."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator

WORD = re.compile(r"[A-Za-z_]+")
NOISE = (
    "(", ")", "[", "]", '"""', '"', "\n", "\r\n", "\r", " ", "\t", "    ", ":", ",", "..", "->", "#", "\\",
    "all ", "some ", "not ", "for ", "when ", "if ", " and ", " or ", "any", "by python", "calls ", "use ",
    "\0", "\ufeff", "é", "𝛼", "\u2028", "\x0b", "\x0c", "\x85", "\u202e", "9e9", "1e400", "0.1.2", "9" * 400,
    "program ", "task ", "type ", "enum ", "record ", "library ", "requires ", "achieves ", "scene: ", "==",
)  # fmt: skip


def edited(text: str, rng: random.Random) -> str:
    """Return the text after one edit of a line or a word, as a user would make it."""
    rows = text.split("\n")
    row = rng.randrange(len(rows))
    match rng.randrange(8):
        case 0:
            del rows[row]
        case 1:
            rows.insert(row, rows[rng.randrange(len(rows))])
        case 2:
            rows.insert(row, rng.choice(["", "# why", "    # so"]))
        case 3:
            rows[row] = rows[row][: rng.randrange(len(rows[row]) + 1)]
        case 4:
            rows[row] = rng.choice(["    ", "  ", "\t", ""]) + rows[row].lstrip()
        case 5:
            other = rng.randrange(len(rows))
            rows[row], rows[other] = rows[other], rows[row]
        case _:
            words = WORD.findall(text)
            found = list(WORD.finditer(rows[row]))
            if found and words:
                word = rng.choice(found)
                meant = rng.choice([rng.choice(words), word.group()[:-1], word.group() + "x"])
                rows[row] = rows[row][: word.start()] + meant + rows[row][word.end() :]
    return "\n".join(rows)


def broken(text: str, rng: random.Random) -> str:
    """Return the text after one accident: noise, shuffled lines, a cut end, other line ends, great depth."""
    at = rng.randrange(len(text) + 1)
    match rng.randrange(10):
        case 0 | 1 | 2:
            return text[:at] + rng.choice(NOISE) + text[at + rng.choice([0, 1, 5, 40]) :]
        case 3:
            rows = text.split("\n")
            rng.shuffle(rows)
            return "\n".join(rows)
        case 4:
            return text[:at]
        case 5:
            return text.replace("\n", rng.choice(["\r\n", "\r", "\n\n"]))
        case 6:
            piece = rng.choice(NOISE)
            return text[:at] + piece * rng.choice([2, 10, 100, 1000]) + text[at:]
        case 7:
            data = bytearray(text.encode())
            for _ in range(rng.randint(1, 8)):
                if data:
                    data[rng.randrange(len(data))] = rng.randrange(256)
            return bytes(data).decode("utf-8", errors="replace")
        case 8:
            return "\ufeff" + text
        case _:
            start = rng.randrange(len(text) + 1)
            return text[:at] + text[start : start + rng.choice([10, 100, 400])] + text[at:]


# Strings, comments, line ends, and whatever else is one token.
TOKEN = re.compile(
    r'"""[\s\S]*?"""|"[^"\n]*"|#[^\n]*|\n|\d+(?:\.\d+)?(?:e[+-]?\d+)?|\w+|\.\.|->|[=!<>]=|[^\w\s]'
)
BESIDE = ("  # c{0}",)
ALONE = ("# c{0}\n", "    # c{0}\n", "  # c{0}\n\n", "\n        # c{0}\n", "\t# c{0}\n# d{0}\n", "    #\n")
WITHIN = ("  # c{0}\n", "\n# c{0}\n", "\n    # c{0}\n  ", "  # c{0}\n        # d{0}\n", "\n\n  # (c{0}\n\n")


def comment_places(text: str) -> Iterator[tuple[int, tuple[str, ...]]]:
    """Yield every offset where a comment may be inserted without another meaning, and the forms that fit."""
    yield 0, ALONE
    depth = 0
    for match in TOKEN.finditer(text):
        token = match.group()
        if token == "\n":
            yield match.start(), BESIDE
            yield match.end(), ALONE
            continue
        if token in ")]":
            yield match.start(), WITHIN
        depth += (token in "([") - (token in ")]")
        if depth and not token.startswith("#"):
            yield match.end(), WITHIN


def commented(text: str, rng: random.Random, most: int = 4) -> str:
    """Return the text with up to so many comments, wherever one may be."""
    places = list(comment_places(text))
    chosen = rng.sample(places, min(len(places), rng.randint(1, most)))
    for number, (at, forms) in sorted(enumerate(chosen), key=lambda each: -each[1][0]):
        text = text[:at] + rng.choice(forms).format(number) + text[at:]
    return text
