"""A sentence that changes what a demonstration shows: "but put the cup on the tray", "skip the last one"."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace

from ntp_dsl.common.text import shortened
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import Argument, Record
from ntp_dsl.sentences.consequences import values_of
from ntp_dsl.sentences.elements import Element
from ntp_dsl.sentences.english import words
from ntp_dsl.sentences.mentions import Mention
from ntp_dsl.sentences.understanding import SURE_ENOUGH, Listener

SWAPPED = re.compile(r"\b(swap\w*|switch\w*|exchang\w*|trad(e|es|ing)|interchang\w*)\b")
REPLACED = re.compile(
    r"\b(replac\w*|substitut\w*|where i (used|had|put)(?! (it|them)\b)"
    r"|(instead of|in place of|rather than)(?! (where|what|how)))\b"
)
LEFT_OUT = re.compile(
    r"\b(skip|omit|without|ignore|forget|never|do not|don't|leave\b.*\b(out|alone|be|where)|except(?! that)|"
    r"(everything|all|the rest) but|stop before|start with the (second|next)|not)\b"
)
ORDINALS = {"first": 0, "second": 1, "third": 2, "fourth": 3, "fifth": 4, "last": -1, "final": -1}
THINGS = r"(one|step|move|thing|element|action|placement|part|piece|item|object)\b"
ORDINAL = re.compile(rf"\b({'|'.join(ORDINALS)}) ?(two|three)?\b(?: {THINGS})?")


Changed = Callable[[tuple[Element, ...]], tuple[Element, ...]]


def amended(listener: Listener, arguments: Sequence[Argument], sentence: str) -> tuple[Argument, ...]:
    """Return a program's arguments with their lists changed as a sentence says.

    Raises `NtpError` for a sentence that says no change, or that may mean several.
    """
    text = " ".join(sentence.lower().replace("\u2019", "'").split())
    named = [each for each in listener.vocabulary.mentions(words(sentence)) if not each.is_many]
    named = [each for each in named if not any(sense.is_number for sense in each.senses)]
    for change in (_swapped, _replaced, _left_out):
        found = change(listener, text, sentence, named)
        if found is not None:
            after = tuple(found(each) if isinstance(each, tuple) else each for each in arguments)
            if after == tuple(arguments):
                raise NtpError(f"'{shortened(sentence)}': nothing of what was shown is about that")
            return after
    return _placed(listener, arguments, sentence)


def _swapped(listener: Listener, text: str, sentence: str, named: Sequence[Mention]) -> Changed | None:
    if not SWAPPED.search(text) or len(named) != 2:
        return None
    one, other = (_the_one(each, sentence) for each in named)
    return lambda elements: tuple(_with_names(each, {one: other, other: one}) for each in elements)


def _replaced(listener: Listener, text: str, sentence: str, named: Sequence[Mention]) -> Changed | None:
    found = REPLACED.search(text)
    if found is None or len(named) != 2:
        return None
    first, second = (_the_one(each, sentence) for each in named)
    at = _position(words(sentence), words(found[0]))
    after = next((each for each in named if each.begin > at), named[-1])
    if found[0].startswith("substitut"):
        after = named[-1]  # "substitute the new one for the old one"
    old, new = (first, second) if after is named[0] else (second, first)
    return lambda elements: tuple(_with_names(each, {old: new}) for each in elements)


def _left_out(listener: Listener, text: str, sentence: str, named: Sequence[Mention]) -> Changed | None:
    if not LEFT_OUT.search(text):
        return None
    if ordinal := ORDINAL.search(text):
        at = ORDINALS[ordinal[1]] - (1 if text[: ordinal.start()].rstrip().endswith("start with the") else 0)
        count = {"two": 2, "three": 3}.get(ordinal[2] or "", 1)
        return lambda elements: _without(elements, at, count)
    names = {str(value) for each in named for sense in each.senses for value in sense.values}
    return (lambda elements: _without_names(elements, names)) if names else None


def _without_names(elements: tuple[Element, ...], names: set[str]) -> tuple[Element, ...]:
    """Return the elements that are not about some things: that do not begin with them, or else name them."""
    first = tuple(each for each in elements if str(values_of(each)[0]) not in names)
    if first != elements:
        return first
    return tuple(each for each in elements if names.isdisjoint(map(str, values_of(each))))


def _without(elements: tuple[Element, ...], at: int, count: int) -> tuple[Element, ...]:
    if at < 0:
        return elements[:-count]
    return elements[:at] + elements[at + count :]


def _placed(listener: Listener, arguments: Sequence[Argument], sentence: str) -> tuple[Argument, ...]:
    """Put new elements in the place of those that were about the same thing, or after all."""
    understood, themes = listener.clauses_of(sentence)
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
    """Return whether two elements say something of the same thing, in the same field."""
    pairs = zip(values_of(one), values_of(other), strict=True)
    return any(a == b and b in themes for a, b in pairs)


def _with_names(element: Element, names: dict[str, str]) -> Element:
    if not isinstance(element, Record):
        return names.get(element, element)
    pairs = (
        (name, names.get(value, value) if isinstance(value, str) else value) for name, value in element.fields
    )
    return replace(element, fields=tuple(pairs))


def _the_one(mention: Mention, sentence: str) -> str:
    if len(mention.senses) != 1 or len(mention.senses[0].values) != 1:
        raise NtpError(
            f"'{shortened(sentence)}': it is not clear which '{mention.head}' is meant; say its name"
        )
    return str(mention.senses[0].values[0])


def _position(tokens: Sequence[str], wanted: Sequence[str]) -> int:
    at = (n for n in range(len(tokens)) if list(tokens[n : n + len(wanted)]) == list(wanted))
    return next(at, -1)
