"""What is refused before it is understood: negations, hedges, conditions, questions, things not there."""

from __future__ import annotations

import re

from ntp_dsl.common.text import shortened
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.sentences.english import (
    ASKING,
    KNOWN,
    KNOWN_VERBS,
    OPPOSITES,
    REFUSED,
    number_of,
    singulars,
    stem,
    words,
)
from ntp_dsl.sentences.matching import Matcher
from ntp_dsl.sentences.mentions import Vocabulary
from ntp_dsl.sentences.splitting import STOPS

LEFT_ALONE = re.compile(r"\bleav\w+\b[^.;]*\b(alone|untouched|where (it|they)|as (it|they))\b", re.IGNORECASE)
# What takes things away, takes back what was said, or names a thing by what it is at.
TURNING = re.compile(
    r"\b(?:(?:free|rid|empty|devoid) of|closed to|comes? out of|(?:it|them) off again|instead of|far from|"
    r"i mean|as long as|what (?:is|are) (?:on|in|at)|what \w+(?: \d+)? (?:is|are) (?:on|in|at))\b",
    re.IGNORECASE,
)
ARTICLES = (["the"], ["a"], ["an"])
CONDITION = re.compile(
    r"((?:when|once|after) (?!you |i |we |it |this |that |all |everything )(?:the |a )?\w+(?: \d+)? "
    r"(?:is|are) (?!on\b|in\b|at\b|to\b|under\b|inside\b)\w+)\b"
)
LONGEST = 80  # words of a sentence


def refuse(text: str, number: int, vocabulary: Vocabulary, matcher: Matcher) -> None:
    """Raise `NtpError` for words that turn or hedge what is said, and for questions."""
    tokens = words(text)
    head = f"sentence {number + 1}, '{shortened(text)}'"
    if len(tokens) > LONGEST:
        raise NtpError(
            f"sentence {number + 1} has {len(tokens)} words: say it in several, of up to {LONGEST}"
        )
    if LEFT_ALONE.search(text):
        raise NtpError(f"{head}: say what is to be done, and leave the rest out")
    if turning := TURNING.search(text):
        raise NtpError(
            f"{head}: '{turning[0]}' is not understood; "
            f"state the result that you want, without '{turning[0]}'"
        )
    mentions = vocabulary.mentions(tokens)
    inside = {at for each in mentions for at in range(each.begin, each.end)}
    for each in (each for each in mentions if each.senses[0].is_number and not each.label):
        end = vocabulary.side_after(tokens, each)
        side = OPPOSITES[tokens[end - 1]] & vocabulary.offsets if end is not None else frozenset()
        if end is not None and side:
            raise NtpError(
                f"{head}: '{tokens[end - 1]}' is not understood; "
                f"say how far '{min(side)}', which may be below zero"
            )
    if condition := CONDITION.match(" ".join(tokens)):
        raise NtpError(
            f"{head}: '{condition[1]}' is a condition, which is not "
            "understood; say what is to be done in any case"
        )
    for at, word in enumerate(tokens):
        refused = word in REFUSED - matcher.own_words or word.endswith("n't")
        refused |= word == "rest" and tokens[max(0, at - 1)] == "the"
        begins = at == 0 or tokens[at - 1] in STOPS
        asked = [*tokens[at:]].index("?") + at if begins and "?" in tokens[at:] else at
        asks = word in ASKING and sum(at <= each.begin < asked for each in mentions) > 1
        if (refused and at not in inside) or asks:
            raise NtpError(
                f"{head}: '{word}' is not understood; state the result that you want, without '{word}'"
            )
        is_noun = not matcher.nouns.isdisjoint(singulars(word))
        is_verb = word not in KNOWN and not is_noun and stem(word) in KNOWN_VERBS | matcher.verbs
        follows = [each for each in mentions if each.begin == at + 1 and at not in inside]
        if (
            is_verb
            and follows
            and tokens[at - 1 : at] in ARTICLES
            and not number_of(tokens[follows[0].end - 1])
        ):
            raise NtpError(
                f"{head}: '{word}' is no trait of anything here; "
                "name what is meant by its name, its kind or its traits"
            )
        is_owned = word == "'s" and any(each.end == at for each in mentions)
        owned = "".join(tokens[at + 1 : at + 2])
        if is_owned and vocabulary.is_kind(owned) and all(each.begin <= at + 1 for each in mentions):
            raise NtpError(f"{head}: which {owned} that is, is not understood; name it")
        is_named = any(each.begin < at < each.end for each in mentions)
        if number_of(word) and not is_named and at and vocabulary.is_kind(tokens[at - 1]):
            raise NtpError(f"{head}: there is no '{tokens[at - 1]} {word}'")
