"""From the comments of a text to the rows of its canonical layout that they belong to.

A comment behind a line stays behind it, one above a line stays above, and one within brackets stays
with the word that it follows or precedes. Rows and text have the same words in the same order, except for
clauses and sections, which the layout sorts.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher

from ntp_dsl.language.parsing.tree_builder import clean
from ntp_dsl.language.syntax.formatter import EMPTY_DOCSTRING
from ntp_dsl.language.syntax.line_wrapping import WORD, Comment, Row

TOKEN = re.compile(
    rf'(?P<docstring>"""[\s\S]*?""")|(?P<comment>#[^\n]*)|(?P<newline>\n)'
    rf"|(?P<word>{WORD.pattern})|(?P<open>[(\[])|(?P<close>[)\]])",
    re.ASCII,
)
CLAUSES = ("says", "requires", "achieves")
SECTIONS = ("scene", "goal", "run", "success")


@dataclass(frozen=True)
class Token:
    """A word, a docstring or a comment.

    `leads` says that it is the first of its line, `spaced` that the line above is empty, `depth` in how
    many brackets it is, `closes` that only closing brackets follow.
    """

    kind: str
    text: str
    column: int
    leads: bool
    spaced: bool
    depth: int
    closes: bool = False

    @property
    def is_comment(self) -> bool:
        return self.kind == "comment"

    @property
    def is_above(self) -> bool:
        """Whether it is a comment on a line of its own."""
        return self.is_comment and self.leads


def scan(text: str) -> list[Token]:
    """Return the words and comments of a stretch of text that begins at a line's start."""
    found: list[Token] = []
    depth, newlines, line_start = 0, 1, 0
    carried = False  # an empty line above brackets counts as one above the first word in them
    for match in TOKEN.finditer(text):
        kind, written = str(match.lastgroup), match.group()
        if kind == "newline":
            newlines += 1
            line_start = match.end()
        elif kind in ("open", "close"):
            depth = depth + 1 if kind == "open" else max(0, depth - 1)
            if kind == "close":
                _mark_closing(found)
            carried = kind == "open" and (newlines > 1 or carried)
            newlines = 0
        else:
            column = match.start() - line_start
            spaced, carried = newlines > 1 or carried, False
            found.append(Token(kind, written.rstrip(), column, newlines > 0, spaced, depth))
            newlines = 0
    return found


def _mark_closing(found: list[Token]) -> None:
    """Mark the comments just above a closing bracket, which belong within."""
    index = len(found) - 1
    while index >= 0 and found[index].is_above:
        found[index] = replace(found[index], closes=True)
        index -= 1


def attach(tokens: Sequence[Token], rows: Sequence[Row], keyword: str) -> tuple[list[str], list[str]]:
    """Give the comments of one declaration to its rows.

    Returns the comments that are indented below it, and those below at the margin, above the next one.
    """
    end = max(index for index, token in enumerate(tokens) if not _may_follow(token)) + 1
    tail = tokens[end:]
    if keyword in ("library", "use"):
        cut = 0
    else:
        cut = next((at for at, token in enumerate(tail) if token.column == 0), len(tail))
    inside = _in_order(tokens[:end], keyword)
    if not any(row.text == EMPTY_DOCSTRING for row in rows):
        inside = [each for each in inside if not _is_empty_docstring(each)]
    places = [(row, index) for row in rows for index in range(len(_words(row.text)))]
    where = _alignment(
        [_normal(each.text) for each in inside if not each.is_comment],
        [word for row in rows for word in _words(row.text)],
    )
    count = 0  # of words so far
    for token in inside:
        if token.is_comment:
            follows = token.is_above and not token.closes
            row, index = places[where[min(count if follows else max(0, count - 1), len(where) - 1)]]
            _place(token, row, index, follows)
        else:
            row, index = places[where[count]]
            if token.spaced and index == 0:
                row.above.append("")
            count += 1
    return lines_of(tail[:cut]), lines_of(tail[cut:])


def _may_follow(token: Token) -> bool:
    return token.is_above and not token.closes


def lines_of(comments: Iterable[Token]) -> list[str]:
    """Return the comments, with an empty line where the text has some."""
    return [line for each in comments for line in ([""] if each.spaced else []) + [each.text]]


def _place(token: Token, row: Row, index: int, follows: bool) -> None:
    if token.closes:
        following = index + 1 if index + 1 < len(_words(row.text)) else -1
        row.within.append(Comment(token.text, following, is_above=True))
    elif follows and index == 0:
        row.above += lines_of([token])
    elif follows:
        row.within.append(Comment(token.text, index, is_above=True))
    elif token.depth:
        row.within.append(Comment(token.text, index, is_above=False))
    else:
        row.behind.append(token.text)


def _in_order(tokens: Sequence[Token], keyword: str) -> list[Token]:
    """Return the tokens with clauses and sections in the layout's order, each with the comments above it."""
    keys: list[int] = []
    key = 0
    block = next((each.column for each in tokens[1:] if each.leads and not each.is_comment), 0)
    for token in tokens:
        if not token.is_comment:
            key = _key(token, key, keyword, block)
        keys.append(key)
    for index in range(len(tokens) - 2, -1, -1):
        if _may_follow(tokens[index]):
            keys[index] = keys[index + 1]
    order = sorted(range(len(tokens)), key=lambda index: keys[index])
    return [tokens[index] for index in order]


def _key(token: Token, key: int, keyword: str, block: int) -> int:
    """Return the rank in the layout of the part that a word is in; `key` is that of the previous word."""
    if keyword in ("api", "program"):
        if token.text in CLAUSES:
            return 1 + CLAUSES.index(token.text)
        return 1 + len(CLAUSES) if key and token.leads and not token.depth else key
    begins = token.leads and token.column == block and not token.depth
    if keyword == "task" and begins and token.text in SECTIONS:
        return 1 + SECTIONS.index(token.text)
    return key


def _words(text: str) -> list[str]:
    return [_normal(text)] if text.startswith('"""') else [*map(_normal, WORD.findall(text))]


def _normal(word: str) -> str:
    """Return a word as it compares: a number by its value, a docstring by its text."""
    if word.startswith('"""'):
        return f'"""{clean(word[3:-3])}'
    return repr(float(word)) if word[0].isdigit() else word


def _is_empty_docstring(token: Token) -> bool:
    return token.kind == "docstring" and not clean(token.text[3:-3])


def _alignment(words: Sequence[str], canonical: Sequence[str]) -> list[int]:
    """Return for each word of the text its place in the layout; a near one if the layout drops it."""
    if words == canonical:
        return list(range(len(words)))
    matcher = SequenceMatcher(None, words, canonical, autojunk=False)
    return [*_matched(matcher, len(words), len(canonical))]


def _matched(matcher: SequenceMatcher[str], words: int, most: int) -> Iterator[int]:
    index = 0
    for start, target, size in matcher.get_matching_blocks():
        yield from [max(0, min(target, most) - 1)] * (start - index)
        yield from range(target, target + size)
        index = start + size
    assert index == words
