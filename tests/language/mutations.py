"""Ways in which texts go wrong: as people edit them, and as nobody would."""

from __future__ import annotations

import random
import re

WORD = re.compile(r"[A-Za-z_]+")
NOISE = (
    "(", ")", "[", "]", '"""', '"', "\n", "\r\n", "\r", " ", "\t", "    ", ":", ",", "..", "->", "#", "\\",
    "all ", "some ", "not ", "for ", "when ", "if ", " and ", " or ", "any", "by python", "calls ", "use ",
    "\0", "\ufeff", "é", "𝛼", "\u2028", "\x0b", "\x0c", "\x85", "\u202e", "9e9", "1e400", "0.1.2", "9" * 400,
    "program ", "task ", "type ", "enum ", "record ", "library ", "requires ", "achieves ", "scene: ", "==",
)  # fmt: skip


def edited(text: str, rng: random.Random) -> str:
    """The text after one edit of a line or a word, as somebody at work would make it."""
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
    """The text after one accident: noise, lines shuffled, an end cut off, other line ends, great depth."""
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
