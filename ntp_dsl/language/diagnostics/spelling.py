"""Which known name a word was probably meant to be, and whether that is certain."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import SequenceMatcher, get_close_matches

KEYS = ("qwertyuiop", "asdfghjkl", "zxcvbnm")
SOUND_ALIKE = frozenset({"cs", "ck", "sz", "iy"})
MIN_LENGTH = 4  # of a word in which a letter is missing, superfluous or another
LONG = 6  # letters: as long a word is recognised with any of its letters wrong
VERY_LONG = 9  # or with two of them


def nearest(name: str, candidates: Iterable[str]) -> str | None:
    """Return what was probably meant, if anything is near: another case, few typing errors, a part of it."""
    known = sorted(set(candidates))
    alike = [each for each in known if _folded(each) == _folded(name)]
    if len(alike) == 1:
        return alike[0]
    distances = {
        each: count
        for each in known
        if (count := _edit_distance(name.lower(), each.lower(), max(len(name), len(each)) // 3)) is not None
    }
    if distances:
        return min(distances, key=lambda each: (distances[each], -_ratio(name, each)))
    found = get_close_matches(name, known, n=1, cutoff=0.6)
    return found[0] if found else None


def _folded(name: str) -> str:
    return name.lower().replace("_", "")


def _ratio(name: str, other: str) -> float:
    return SequenceMatcher(None, name, other).ratio()


def _edit_distance(name: str, other: str, most: int) -> int | None:
    """Count letters to add, drop, replace, or swap with a neighbour (optimal string alignment).

    None where it takes more than `most`.
    """
    if abs(len(name) - len(other)) > most or len(set(name) ^ set(other)) > 2 * most:
        return None  # the quick answer, for libraries of thousands of names
    second_last: list[int] = []
    last = list(range(len(other) + 1))
    for i, letter in enumerate(name, start=1):
        row = [i]
        for j, wanted in enumerate(other, start=1):
            cost = min(last[j] + 1, row[j - 1] + 1, last[j - 1] + (letter != wanted))
            if i > 1 and j > 1 and letter == other[j - 2] and name[i - 2] == wanted:
                cost = min(cost, second_last[j - 2] + 1)
            row.append(cost)
        second_last, last = last, row
    return last[-1] if last[-1] <= most else None


def is_misspelt(name: str, meant: str, known: Iterable[str]) -> bool:
    """Return whether the name is certainly the other one with a typing error, and no third one as near.

    A word of its own is not certain, however near it is: other first letters (`lock` for `block`), other
    digits (`bin_2` for `bin_3`), short words with another letter (`plate` for `place`).
    """
    most = 2 if min(len(name), len(meant)) >= VERY_LONG else 1
    others = [each for each in known if each != meant]
    if _folded(name) == _folded(meant):
        return all(_folded(each) != _folded(name) for each in others)
    distance = _edit_distance(name, meant, most)
    if distance is None or any(
        _edit_distance(name.lower(), each.lower(), distance) is not None for each in others
    ):
        return False
    if [each for each in name if each.isdigit()] != [each for each in meant if each.isdigit()]:
        return False
    pairs = [*zip(name.lower().split("_"), meant.lower().split("_"), strict=False)]
    differing = [(one, other) for one, other in pairs if one != other]
    if name.count("_") != meant.count("_") or len(differing) != 1:
        return False
    is_part = len(pairs) > 1  # the other words tell what is meant
    return all(_is_typing_error(one, other, distance, is_part) for one, other in differing)


def _is_typing_error(word: str, meant: str, distance: int, is_part: bool) -> bool:
    short, long = sorted((word, meant), key=len)
    if distance > 1:
        return word[:1] == meant[:1] and len(short) >= VERY_LONG - 1
    place = next((i for i, (a, b) in enumerate(zip(word, meant, strict=False)) if a != b), len(short))
    if len(short) != len(long):
        is_doubled = long[place : place + 1] in {long[place - 1 : place], long[place + 1 : place + 2]}
        return is_doubled or (place > 0 and (len(long) >= MIN_LENGTH or (is_part and len(long) > 2)))
    if sorted(word) == sorted(meant):  # two letters are exchanged
        return len(word) > 2
    one, other = word[place], meant[place]
    alike = _are_neighbours(one, other) or "".join(sorted((one, other))) in SOUND_ALIKE
    return place > 0 and (len(word) >= LONG or (len(word) >= MIN_LENGTH and alike))


def _are_neighbours(one: str, other: str) -> bool:
    """Return whether two letters are next to each other in a row of the keyboard."""
    return any(one + other in row or other + one in row for row in KEYS)
