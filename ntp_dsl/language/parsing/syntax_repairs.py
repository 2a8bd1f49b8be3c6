"""Fixes for a block that does not parse: guesses, of which one is proposed if the parser then gets further.

Guesses are words of other languages, typing errors, and marks that are missing, superfluous or foreign. A
guess is proposed only if the text then parses as far as the next line at least. First come those that are
certain if no other of their kind parses, too; then the first of the others is an offer.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix
from ntp_dsl.language.diagnostics.spelling import is_misspelt, nearest
from ntp_dsl.language.parsing import parse_messages
from ntp_dsl.language.parsing.blocks import PARTNERS, Block
from ntp_dsl.language.parsing.foreign_syntax import (
    FILLERS,
    SYNONYMS,
    UNCERTAIN,
    bracketed,
    certain_rewrites,
    rewrites,
)
from ntp_dsl.language.syntax.nodes import Span

Attempt = Callable[[Block], tuple[object, Sequence[Diagnostic]]]
Guess = tuple[int, str]  # the number of a row, and its new text

MAX_CHARACTERS = 12_000  # parsed for all guesses at one mistake together
MAX_TRIES = 60
WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
WORD_BEFORE = re.compile(r"[A-Z][A-Za-z0-9_]*$")
TWICE = re.compile(r"\b(?P<word>\w+)(\s+)(?P=word)\b")
# Words that never follow one another, and what no line ends with.
APART = re.compile(
    r"\bon with\b|\b(?:and|or|not|in) (?:and|or|in)\b|\b(?:and|or|not) (?:in|on|is|with)\b(?!\s*\()"
)
UNFINISHED = re.compile(r"(?:\b(?:in|on|is|and|with)|==|[.=])\s*$")
DECIMAL_COMMA = re.compile(r"(?<=\d),(?=\d)")
JOINED = re.compile(r"\w\w|[=<>!&|-]{2}")  # two characters of one word or sign
OPENING = ("requires", "achieves", "for", "when", "else", "calls", "scene", "initially", "goal", "run",
           "success")  # fmt: skip
INNER = ("and", "or", "not", "in", "if", "for", "is", "by", "on", "with", "all", "some", "exactly", "any",
         "list", "requires", "achieves")  # fmt: skip
MARKS: Mapping[str, str] = {
    "&&": "and", "&": "and", "||": "or", "|": "or", "=>": ">=", "=<": "<=", "<>": "!=", "=": "==",
    "!": "not ",
    "//": "#", ";": "", "?": "", "$": "", "@": "", "`": "", ",": "", ":": "", "...": "..",
    "-": "..", "{": "[", "}": "]", "≤": "<=", "≥": ">=", "≠": "!=", "¬": "not ", "∧": "and", "∨": "or",
    "–": "-", "×": "*", ">": "->", "..": "=", "--": "#", "…": "..", ":=": "==",
}  # fmt: skip
CERTAIN_MARKS = ("&", "|", "=", "–", "×", "...", "…")
MISSING = (", ", ":", ")", "]", "(goal)", "()", ".", "(", "[", " in ", " with ", " on table ", " on ", " is ",
           "..", "=", " and ", " == ")  # fmt: skip


def with_fix(diagnostic: Diagnostic, block: Block, attempt: Attempt) -> Diagnostic:
    """Return the diagnostic with a fix, if a guess proves right."""
    row = diagnostic.span.line - block.line
    rows = block.text.rstrip("\n").split("\n")
    if block.column_maps or not 0 <= row < len(rows):
        return diagnostic
    word = WORD.match(rows[row].strip())
    if diagnostic.code == "E001" and row and word and word.group() in parse_messages.FOREIGN:
        return _foreign(diagnostic, block, rows, row, word.group(), attempt)
    if diagnostic.fix is not None or diagnostic.code not in {"E001", "E003", "E004"}:
        return diagnostic
    certain = _only_certain(rows, row, diagnostic.span.column - 1, block, attempt)
    if certain is not None:
        return _fixed(diagnostic, block, rows, certain, certain=True)
    if (comma := DECIMAL_COMMA.search(rows[row])) and abs(comma.start() - diagnostic.span.column + 1) <= 1:
        help = "decimals follow a '.', and the digits of thousands are written without a mark"
        return replace(diagnostic, help=help)
    better: tuple[int, str] | None = None
    tried: set[tuple[int, str]] = set()
    for guess in _guesses(rows, row, diagnostic.span.column - 1):
        if guess in tried or guess == (guess[0], rows[guess[0]]) or _repeats(guess, rows):
            continue
        tried.add(guess)
        if len(tried) > min(MAX_TRIES, MAX_CHARACTERS // len(block.text)):
            break
        left = attempt(replace(block, text="\n".join(_with(rows, guess)) + "\n"))[1]
        if not left:
            return _fixed(diagnostic, block, rows, guess)
        if better is None and min(each.span.line for each in left) - block.line > max(row, guess[0]):
            better = guess
    return diagnostic if better is None else _fixed(diagnostic, block, rows, better)


def _only_certain(rows: list[str], row: int, column: int, block: Block, attempt: Attempt) -> Guess | None:
    """Return the one certain guess with which the block parses; or else the one that gets further.

    Guesses that mean the same are one.
    """
    whole: list[tuple[object, Guess]] = []
    further: list[Guess] = []
    guesses = [
        each for each in dict.fromkeys(_certain_guesses(rows, row, column)) if each[1] != rows[each[0]]
    ]
    for guess in guesses[: min(MAX_TRIES, MAX_CHARACTERS // len(block.text))]:
        item, left = attempt(replace(block, text="\n".join(_with(rows, guess)) + "\n"))
        if not left:
            whole.append((item, guess))
        elif _brackets(guess[1]) == _brackets(rows[guess[0]]) and (
            min(each.span.line for each in left) - block.line > max(row, guess[0])
        ):
            further.append(guess)
    if whole:
        return whole[0][1] if all(item == whole[0][0] for item, _ in whole) else None
    return further[0] if len(further) == 1 else None


def _brackets(text: str) -> str:
    return re.sub(r"[^()\[\]]", "", text)


def _foreign(
    diagnostic: Diagnostic, block: Block, rows: list[str], row: int, word: str, attempt: Attempt
) -> Diagnostic:
    """Report a line that begins with a word such as `return`; drop the word, or the line if it is all."""
    column = rows[row].index(word) + 1
    span = block.span(row + 1, column, len(word))
    rest = rows[row][column - 1 + len(word) :].lstrip()
    fix = None
    if not rest.strip(" :;"):
        others = [*rows[:row], *rows[row + 1 :]]
        if not attempt(replace(block, text="\n".join(others) + "\n"))[1]:
            line = block.line + row
            fix = Fix(Span(block.path, line, 1, line + 1, 1), "", certain=word == "pass")
    else:
        others = _with(rows, (row, rows[row][: column - 1] + rest))
        if not attempt(replace(block, text="\n".join(others) + "\n"))[1]:
            fix = Fix(block.span(row + 1, column, len(rows[row]) - len(rest) - column + 1), "")
    return parse_messages.foreign(word, span, fix)


def _repeats(guess: Guess, rows: Sequence[str]) -> bool:
    """Return whether the guess repeats a word, or joins two that never follow one another."""
    index, new = guess
    is_repeated = any(each.search(new) and not each.search(rows[index]) for each in (TWICE, UNFINISHED))
    return is_repeated or APART.search(new) is not None


def replaces_word(diagnostic: Diagnostic) -> bool:
    """Return whether its fix replaces one word by another: then it is certain what was meant."""
    fix = diagnostic.fix
    return fix is not None and diagnostic.span == fix.span and WORD.fullmatch(fix.replacement) is not None


def _with(rows: list[str], guess: Guess) -> list[str]:
    return [guess[1] if index == guess[0] else row for index, row in enumerate(rows)]


def _fixed(
    diagnostic: Diagnostic, block: Block, rows: list[str], guess: Guess, certain: bool = False
) -> Diagnostic:
    """Return the diagnostic with the smallest edit of whole words that makes the guess."""
    index, new = guess
    old = rows[index]
    start = _same(old, new)
    end = _same(old[start:][::-1], new[start:][::-1])
    while start and _splits_word(old, start, new, start):
        start -= 1
    while end and _splits_word(old, len(old) - end, new, len(new) - end):
        end -= 1
    span = block.span(index + 1, start + 1, len(old) - end - start)
    replacement = new[start : len(new) - end]
    fix = Fix(span, replacement, certain=certain)
    taken = old[start : len(old) - end]
    is_split = "\n" in new.strip()
    help = "each is on a line of its own" if is_split else f"did you mean '{new.strip()}'?"
    is_here = WORD.search(taken) is not None and index == diagnostic.span.line - block.line
    if is_here and WORD.fullmatch(taken) and WORD.fullmatch(replacement):
        message = f"'{taken}' is not the word for this; did you mean '{replacement}'?"
        return replace(diagnostic, message=message, span=span, fix=fix, help="")
    if is_here and taken.strip().lower() in FILLERS and not replacement.strip():
        message = f"'{taken.strip()}' is not allowed here"
        return replace(diagnostic, message=message, span=span, fix=fix, help=help)
    return replace(diagnostic, fix=fix, help=help)


def _same(one: str, other: str) -> int:
    """Return the length of the common beginning."""
    pairs = enumerate(zip(one, other, strict=False))
    return next((index for index, (a, b) in pairs if a != b), min(len(one), len(other)))


def _splits_word(old: str, at: int, new: str, there: int) -> bool:
    """Return whether an edit would begin or end within a word."""
    return any(
        0 < place < len(text) and JOINED.fullmatch(text[place - 1 : place + 1]) is not None
        for text, place in ((old, at), (new, there))
    )


def _put(text: str, place: int, mark: str) -> str:
    return text[:place] + mark + text[place:]


# Guesses, the likeliest first ---------------------------------------------------------------------


def _certain_guesses(rows: list[str], row: int, column: int) -> Iterator[Guess]:
    """Yield what is meant without doubt, if it is only one of these."""
    text = rows[row]
    if text.count('"""') == 1:
        yield row, text.rstrip() + '"""'
        return
    for new in certain_rewrites(text):
        yield row, new
    words = list(WORD.finditer(text))
    near = [each for each in words if each.start() <= column < each.end()]
    near += [each for each in words if each.end() <= column][-1:]
    for match in dict.fromkeys([*near, *words[:1]]):
        head, rest, found = text[: match.start()], text[match.end() :], match.group()
        for meant in _certain_words(found, match is words[0]):
            yield row, head + meant + rest
            yield row, head + meant + re.sub(r"^\s*:", "", rest)
        if found.lower() in FILLERS:
            yield row, head + rest.lstrip()
    twice = TWICE.search(text)
    if twice and twice["word"] in {*OPENING, *INNER}:
        yield row, text[: twice.end("word")] + text[twice.end() :]
    for mark in CERTAIN_MARKS:
        for start in {column, column - 1}:
            if start >= 0 and text.startswith(mark, start):
                rest = text[start + len(mark) :]
                yield row, text[:start] + MARKS[mark] + rest
    if text[column : column + 1] in PARTNERS:
        for match in reversed([*re.finditer(r"[\w)\]](?!\w)", text[column:])]):
            yield row, _put(text, column + match.end(), PARTNERS[text[column]])
    elif text[column : column + 1] in PARTNERS.values():
        yield from ((row, each) for each in _without_bracket(text, column))
    comma = re.match(r"(\s*\w+\s*:)", text[column:])
    if comma and re.search(r"[(,]\s*\w+\s*:\s*[\w\[\]]+\s*$", text[:column]):  # (a: Block b: Block)
        yield row, text[:column].rstrip() + ", " + text[column:].lstrip()
    yield from _shifted(rows, row)


def _without_bracket(text: str, column: int) -> Iterator[str]:
    """Yield the line without a bracket that is too many, or with the right kind in place of another."""
    found = text[column]
    if sum(map(text.count, PARTNERS)) < sum(map(text.count, PARTNERS.values())):
        if text[:column].rstrip().endswith(found):  # doubled; otherwise one that opens may be missing
            yield text[:column] + text[column + 1 :]
        return
    for opening, closing in PARTNERS.items():
        place = text.rfind(opening, 0, column)
        if closing != found and place >= 0:
            partner = next(each for each, other in PARTNERS.items() if other == found)
            yield text[:place] + partner + text[place + 1 :]
            yield text[:column] + closing + text[column + 1 :]


def _certain_words(found: str, is_first: bool) -> Iterator[str]:
    known = OPENING if is_first else INNER
    word = found.lower()
    if word in SYNONYMS and word not in UNCERTAIN:
        yield SYNONYMS[word]
    if found not in known:
        yield from (each for each in known if is_misspelt(found, each, known))


def _shifted(rows: list[str], row: int) -> Iterator[Guess]:
    """Yield the line one column further left or right, where others begin; or with blanks for its tabs."""
    indent = len(rows[row]) - len(rows[row].lstrip())
    above = [each for each in rows[1:row] if each.strip()]
    others = {len(each) - len(each.lstrip()) for each in above}
    for other in {indent - 1, indent + 1} & others:
        yield row, " " * other + rows[row].lstrip()
    if rows[row].startswith("\t"):
        blank = [len(each) - len(each.lstrip()) for each in above if each.startswith(" ")]
        yield row, rows[row].expandtabs(min(blank, default=4))


def _guesses(rows: list[str], row: int, column: int) -> Iterator[Guess]:
    text = rows[row]
    if text.count('"""') == 1:
        yield row, text.rstrip() + '"""'
        return
    for new in rewrites(rows, row, column):
        yield row, new
    twice = TWICE.search(text)
    if twice:
        yield row, text[: twice.end("word")] + text[twice.end() :]
    if text[column : column + 1] in PARTNERS:
        for match in re.finditer(r"[\w)\]](?!\w)", text[column:]):
            yield row, _put(text, column + match.end(), PARTNERS[text[column]])
    others = _other_words(text, column), _other_marks(text, column), _missing(text, column)
    for new in chain(*others, bracketed(text, column)):
        yield row, new
    yield from _other_margins(rows, row)
    head, rest = text[:column], text[column + 1 :]
    if not WORD.match(text, column) and not (head[-1:].isalnum() and rest[:1].isalnum()):
        yield row, head.rstrip() + rest


def _other_words(text: str, column: int) -> Iterator[str]:
    """Guess keywords for the word at the place, the one before it, and the first of the line."""
    words = list(WORD.finditer(text))
    here = [each for each in words if each.start() <= column < each.end()]
    before = [each for each in words if each.end() <= column][-1:]
    for match in [*here, *before, *words[:1]]:
        is_first = match is words[0]
        known = OPENING if is_first else INNER
        found = match.group()
        near = [each for each in known if nearest(found, [each])] if found not in known else []
        for guess in (SYNONYMS.get(found), SYNONYMS.get(found.lower()), *near):
            if guess is not None and guess != found:
                yield text[: match.start()] + guess + text[match.end() :]
                yield text[: match.start()] + guess + text[match.end() :].replace(":", "", 1)


def _other_marks(text: str, column: int) -> Iterator[str]:
    """Replace signs of other languages."""
    for mark, ours in MARKS.items():
        for start in {column, column - 1}:
            if start >= 0 and text.startswith(mark, start):
                rest = text[start + len(mark) :]
                yield text[:start] + ours + rest
                if mark == ":":
                    yield f"{text[:start].rstrip()} with {rest.lstrip()}"
                if mark == ",":
                    yield f"{text[:start].rstrip()} and {rest.lstrip()}"
                if mark in {"-", ":"}:
                    yield text[:start] + "->" + rest
                    yield text[:start].rstrip() + ":" + rest
                if mark == ";" and not text[:start].strip():
                    yield text[:start] + "#" + rest
                if mark == "!":
                    yield text[:start] + ours + rest.lstrip()
                if mark in {"=", ":"}:
                    yield text[:start] + {"=": ":", ":": "="}[mark] + rest
                    yield text[:start] + {"=": "=", ":": " in"}[mark] + rest
    for quote in "\"'":
        if text.startswith(quote, column) and text.count(quote) > 1:
            yield text[:column] + text[column:].replace(quote, "", 2)
    if "<" in text[max(0, column - 1) :] and ">" in text[column:]:
        yield text[:column] + text[column:].replace("<", "[", 1).replace(">", "]", 1)


def _missing(text: str, column: int) -> Iterator[str]:
    """Insert marks that may be missing at the place, or at the line's end."""
    head, rest = text[:column], text[column:]
    bare = head.rstrip()
    word = WORD.match(rest)
    if word and bare.endswith("list"):
        yield f"{bare}[{word.group()}]{rest[word.end() :]}"
    before = WORD_BEFORE.search(bare)
    if word and before:  # `Drawer d`, as in other languages
        yield f"{bare[: before.start()]}{word.group()}: {before.group()}{rest[word.end() :]}"
    for mark in MISSING:
        if mark == "(goal)" and not bare.lstrip().startswith("run"):
            continue
        yield bare + mark + (rest.lstrip() if mark.endswith((" ", ".", "(", "[", "=")) else rest)
    if word:
        for mark in (")", "]"):
            yield head + word.group() + mark + rest[word.end() :]
    code = text.split("#")[0].rstrip()
    for ending in (")", "))", "]", "):", "])", "]):", ":"):
        yield code.removesuffix(":") + ending if ":" in ending else code + ending
    if text[column : column + 1] in {")", "]", ","}:
        yield text[:column] + text[column + 1 :]


def _other_margins(rows: list[str], row: int) -> Iterator[Guess]:
    """Indent the line, or the next one, as others are."""
    for index in (row, row + 1):
        if not 0 < index < len(rows) or not rows[index].strip():
            continue
        bare = rows[index].lstrip()
        indents = [len(each) - len(each.lstrip()) for each in rows[1:index] if each.strip()]
        for indent in dict.fromkeys([*indents[-1:], *(each + 4 for each in indents[-1:]), *indents, 4]):
            yield index, " " * indent + bare
