"""A sentence that changes what a demonstration shows: "but put the cup on the tray", "skip the last one"."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace

from ntp_dsl.common.text import shortened
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import Argument, Record
from ntp_dsl.sentences.elements import Element, values_of
from ntp_dsl.sentences.english import NUMBERS, POLITE, words
from ntp_dsl.sentences.senses import Mention, Sense
from ntp_dsl.sentences.understanding import SURE_ENOUGH, Listener

SWAPPED = re.compile(r"\b(swap\w*|switch\w*|exchang\w*|trad(e|es|ing)|interchang\w*|chang\w* places)\b")
REPLACED = re.compile(
    r"\b(replac\w*|substitut\w*|where i (used|had|put)(?! (it|them)\b)"
    r"|(instead of|in place of|rather than)(?! (where|what|how|on|in|at|to|onto|into)\b))\b"
)
LEFT_OUT = re.compile(
    r"\b(skip|omit|without|ignore|forget|never|do not|don't|leave\b.*\b(out|alone|be|where)|except(?! that)|"
    r"(everything|all|the rest) but|stop before|start with the (second|next)|not)\b"
)
NEGATED = re.compile(r"\b(not|never|don't|doesn't|mustn't|shouldn't|won't|can't|avoid|hate)\b")
ORDINALS = {"first": 0, "second": 1, "third": 2, "fourth": 3, "fifth": 4, "last": -1, "final": -1}
ORDINAL = re.compile(
    rf"\b(?<!to )(?<!to-)(?P<but>second[ -](?:to[ -])?)?(?P<place>{'|'.join(ORDINALS)})(?P<but_one> but one)?"
    rf"(?! to last| last)(?: (?P<count>\d+|{'|'.join(NUMBERS)})\b)?"
)
# Where a sentence says one change after another.
SEVERAL = re.compile(
    r"(?:^|[,.!]? )(?:and )?then |[;!]|\.(?: |$)|"
    r"[,.]? (?:and|but)(?: also)? "
    r"(?=(?:put|leave|skip|swap|use|replace|take|move|add|place|stack|omit|don't)\b)|"
    r", (?=(?:put|leave|skip|swap|replace|omit|don't)\b)",
    re.IGNORECASE,
)
ASIDE = re.compile(
    r"\b(rather than|instead of) (on|in|at|onto|into|to|where)\b.*$|\b(instead|this time)\b", re.IGNORECASE
)
PREAMBLE = re.compile(r"[,:;]|\bin addition\b|\bbut\b|\bexcept that\b|\bonly\b|\bbesides\b", re.IGNORECASE)
EXCEPTING = re.compile(r"\b(everything|all|the rest) but\b|\ball except\b|\beverything except\b")

# What consists of several elements, which no ordinal numbers.
WHOLES = re.compile(
    r"\b(?:first|second|third|fourth|last|next|other) (tower|pile|stack|heap|row|group|pair|half)s?\b"
)

Changed = Callable[[tuple[Element, ...]], tuple[Element, ...]]


def amended(listener: Listener, arguments: Sequence[Argument], sentence: str) -> tuple[Argument, ...]:
    """Return a program's arguments with their lists changed as a sentence says.

    Raises `NtpError` for a sentence that says no change, or that may mean several.
    """
    after = tuple(arguments)
    parts = _parts(" ".join(sentence.replace("\u2019", "'").split()))
    telling = [
        part for part in parts if listener.vocabulary.mentions(words(part)) or ORDINAL.search(part.lower())
    ]
    for part in telling or [sentence]:
        after = _changed(listener, after, part)
    return after


def _parts(sentence: str) -> list[str]:
    """Return the changes that a sentence says, one after the other."""
    if len(re.findall(r"\binstead of\b", sentence)) > 1:
        return re.split(r",? and ", sentence)
    return [part for part in SEVERAL.split(sentence) if part.strip()] or [sentence]


def _changed(listener: Listener, arguments: tuple[Argument, ...], sentence: str) -> tuple[Argument, ...]:
    text = POLITE.sub(" ", sentence.lower())
    negations = len(NEGATED.findall(text)) + len(re.findall(r"\b(leave out|skip|omit|only do)\b", text))
    negations += len(EXCEPTING.findall(text)) if negations else 0
    whole = WHOLES.search(text)
    if whole and whole[1] not in listener.vocabulary.own_nouns:
        raise NtpError(f"'{shortened(sentence)}': '{whole[0]}' may be several elements: name what is meant")
    if negations > 1 or "only do" in text or (NEGATED.search(text) and SWAPPED.search(text)):
        raise _unclear(sentence)
    found = listener.vocabulary.mentions(words(sentence))
    named = [each for each in found if not any(sense.is_number for sense in each.senses)]
    single = [each for each in named if not each.is_many]
    if NEGATED.search(text):
        changes = [(_left_out, named)]
    else:
        changes = [(_swapped, single or named), (_replaced, single), (_left_out, named)]
    for change, mentions in changes:
        effect = change(text, sentence, mentions)
        if effect is not None:
            filled = [each for each in arguments if isinstance(each, tuple) and each]
            if ORDINAL.search(text) and len(filled) > 1:
                raise NtpError(f"'{shortened(sentence)}': there are several lists: name what is left out")
            after = tuple(effect(each) if isinstance(each, tuple) and each else each for each in arguments)
            if after == arguments:
                raise NtpError(f"'{shortened(sentence)}': nothing of what was shown is about that")
            return after
    return _placed(listener, arguments, sentence)


def _unclear(sentence: str) -> NtpError:
    return NtpError(f"'{shortened(sentence)}' is not understood: say each change by itself, without 'not'")


def _swapped(text: str, sentence: str, named: Sequence[Mention]) -> Changed | None:
    is_pair = len(named) == 1 and len(named[0].senses) == 1 and len(named[0].senses[0].values) == 2
    if is_pair:  # "swap blocks 2 and 4"
        named = [replace(named[0], senses=(Sense((value,)),)) for value in named[0].senses[0].values]
    if not SWAPPED.search(text) or len(named) != 2:
        return None
    one, other = (_the_one(each, sentence) for each in named)
    return lambda elements: tuple(_with_names(each, {one: other, other: one}) for each in elements)


def _replaced(text: str, sentence: str, named: Sequence[Mention]) -> Changed | None:
    found = REPLACED.search(text)
    if found is None or len(named) != 2:
        return None
    first, second = (_the_one(each, sentence) for each in named)
    at = _position(words(sentence), words(found[0]))
    after = next((each for each in named if each.begin > at), named[-1])
    if found[0].startswith("substitut"):  # "substitute the new one for the old one"
        after = named[0] if re.search(r"\b(with|by)\b", text) else named[-1]
    old, new = (first, second) if after is named[0] else (second, first)
    return lambda elements: tuple(_with_names(each, {old: new}) for each in elements)


def _left_out(text: str, sentence: str, named: Sequence[Mention]) -> Changed | None:
    if not LEFT_OUT.search(text):
        return None
    if ordinals := [*ORDINAL.finditer(text)]:
        if named and not all(each.is_many for each in named):
            raise _unclear(sentence)
        return lambda elements: _without(elements, text, ordinals, sentence)
    if "stop before" in text:
        raise _unclear(sentence)
    if not named:
        return None
    for each in named:
        if len(each.senses) > 1 and not each.is_many:
            raise NtpError(
                f"'{shortened(sentence)}': it is not clear which '{each.head}' is meant; say its name"
            )
    groups = [{str(value) for sense in each.senses for value in sense.values} for each in named]
    if re.search(r"\b(and|or)\b", text):
        groups = [set().union(*groups)]
    return lambda elements: _without_names(elements, groups)


def _without_names(elements: tuple[Element, ...], groups: Sequence[set[str]]) -> tuple[Element, ...]:
    """Return the elements that are not about things: of one, those that begin with it, or else name it."""

    def is_meant(each: Element) -> bool:
        names = [str(value) for value in values_of(each)]
        return all(not group.isdisjoint(names) for group in groups)

    begins = tuple(n for n in elements if str(values_of(n)[0]) in groups[0] and is_meant(n))
    return tuple(each for each in elements if each not in begins and (begins or not is_meant(each)))


def _without(
    elements: tuple[Element, ...], text: str, ordinals: Sequence[re.Match[str]], sentence: str
) -> tuple[Element, ...]:
    """Return the elements but for the first, the last two, the last but one."""
    left_out: set[int] = set()
    for found in ordinals:
        number = found["count"] or "1"
        count, at = int(NUMBERS.get(number, number)), ORDINALS[found["place"]]
        if found["but"] or found["but_one"]:
            at = -2 if at < 0 else at
        if text[: found.start()].rstrip().endswith("start with the"):
            at -= 1
        start = at if at >= 0 else len(elements) + at - (count - 1)
        if "stop before" in text[: found.start()]:
            count = len(elements) - start
        if start < 0 or start + count > len(elements):
            raise NtpError(f"'{shortened(sentence)}': {len(elements)} were shown")
        left_out |= {*range(start, start + count)}
    return tuple(each for n, each in enumerate(elements) if n not in left_out)


def _placed(listener: Listener, arguments: Sequence[Argument], sentence: str) -> tuple[Argument, ...]:
    """Put new elements in the place of those that were about the same thing, or after all."""
    said = [part for part in PREAMBLE.split(ASIDE.sub(" ", sentence)) if "same" not in part.lower()]
    told = [part.strip() for part in said if listener.vocabulary.mentions(words(part))]
    understood, themes = listener.clauses_of(", ".join(told) or sentence)
    for choice in understood.choices:
        if choice.probability < SURE_ENOUGH:
            others = ", ".join(str(element) for element, _ in choice.others[:3])
            raise NtpError(
                f"'{shortened(sentence)}' may mean {choice.element} or {others}: say it more exactly"
            )
    after = list(arguments)
    for choice in understood.choices:
        at = next(n for n, each in enumerate(listener.program.parameters) if each.name == choice.parameter)
        elements = after[at]
        assert isinstance(elements, tuple)
        alike = [n for n, each in enumerate(elements) if _is_about(each, choice.element, themes)]
        kept = tuple(each for n, each in enumerate(elements) if n not in alike)
        place = alike[0] if alike else len(kept)
        after[at] = (*kept[:place], choice.element, *kept[place:])
    return tuple(after)


def _is_about(one: Element, other: Element, themes: frozenset[str]) -> bool:
    """Return whether two elements say something of the same thing, in the field where that is told."""
    values = values_of(other)
    at = next((n for n, value in enumerate(values) if value in themes), None)
    return at is not None and values_of(one)[at] == values[at]


def _with_names(element: Element, names: dict[str, str]) -> Element:
    if not isinstance(element, Record):
        return names.get(element, element)
    fields = ((name, names.get(v, v) if isinstance(v, str) else v) for name, v in element.fields)
    return replace(element, fields=tuple(fields))


def _the_one(mention: Mention, sentence: str) -> str:
    if len(mention.senses) != 1 or len(mention.senses[0].values) != 1:
        raise NtpError(
            f"'{shortened(sentence)}': it is not clear which '{mention.head}' is meant; say its name"
        )
    return str(mention.senses[0].values[0])


def _position(tokens: Sequence[str], wanted: Sequence[str]) -> int:
    at = (n for n in range(len(tokens)) if list(tokens[n : n + len(wanted)]) == list(wanted))
    return next(at, -1)
