"""From text to syntax tree; `check` is for its meaning."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import cast

from lark import Lark, Token
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken
from lark.indenter import DedentError
from lark.lexer import PatternStr
from lark.tree import Meta
from lark.visitors import Transformer_NonRecursive

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, SourceError
from ntp_dsl.language.parsing import blocks, parser_tables, tree_builder
from ntp_dsl.language.parsing.blocks import KEYWORDS, Block
from ntp_dsl.language.parsing.parsed import Parsed
from ntp_dsl.language.parsing.partial_library import PartialLibrary, assemble
from ntp_dsl.language.parsing.term_builder import Word
from ntp_dsl.language.syntax.nodes import NOWHERE, Library, Span


@cache
def _lark() -> Lark:
    return parser_tables.parser()


@cache
def _words() -> dict[str, str]:
    """Return what a user calls each of the grammar's terminals."""
    from ntp_dsl.language.parsing.parse_messages import TERMINALS

    words = {
        terminal.name: f"'{terminal.pattern.value}'"
        for terminal in _lark().terminals
        if isinstance(terminal.pattern, PatternStr)
    }
    return words | TERMINALS


def parse(text: str, path: Path | str | None = None) -> Library:
    """Read a library; `SourceError` carries every syntax error.

    Args:
        path: where the text comes from, for the spans; the file is not opened.
    """
    where = None if path is None else Path(path)
    partial = read(text, where)
    if partial.diagnostics:
        raise SourceError(partial.diagnostics, {where: lines(text)})
    return partial.library


def read(text: str, path: Path | None, read_block: Callable[[Block], Parsed] | None = None) -> PartialLibrary:
    """Read what can be read of a library; its diagnostics say what cannot.

    Args:
        read_block: what to call in place of the parser for one declaration, such as a function with a cache.
    """
    found = [(read_block or parse_block)(block) for block in blocks.split_blocks(lines(text), path)]
    return assemble(found, path)


def lines(text: str) -> str:
    """Return the text with line ends of one kind, as all spans count them."""
    return text.replace("\r\n", "\n").replace("\r", "\n")


def parse_block(block: Block) -> Parsed:
    """Read one declaration, as far as it can be read.

    What explains mistakes is imported where there is one: that takes longer than to read a sound text.
    """
    first = _attempt(block)
    item, found = first
    if item is not None and not found and not block.diagnostics:
        return Parsed(block, item)
    from ntp_dsl.language.parsing.error_recovery import recover

    return recover(block, _attempt, first)


def _attempt(block: Block) -> tuple[tree_builder.Item | None, Sequence[Diagnostic]]:
    diagnostics = [blocks.misspelt_keyword(block)] if block.keyword not in KEYWORDS else []
    diagnostics += blocks.unbalanced(block)
    if diagnostics:
        return None, diagnostics
    try:
        tree = _lark().parse(block.text, start=block.keyword)
    except (UnexpectedInput, DedentError) as unexpected:
        return None, [_explain(unexpected, block)]
    builder = tree_builder.Builder()
    return _Transformer(builder, block).transform(tree), builder.diagnostics


def _explain(unexpected: UnexpectedInput | DedentError, block: Block) -> Diagnostic:
    from ntp_dsl.language.parsing import parse_messages

    if isinstance(unexpected, DedentError):
        return parse_messages.dedent(block)
    line, column = unexpected.line, unexpected.column
    if isinstance(unexpected, UnexpectedToken):
        accepted = unexpected.accepts or unexpected.expected
        token = unexpected.token
        expected = {_words().get(name, name) for name in accepted}
        if token.type == "$END":
            line, column = block.text.count("\n"), len(block.text.rstrip("\n").split("\n")[-1]) + 1
        return parse_messages.unexpected(block, line, column, str(token), token.type, expected)
    assert isinstance(unexpected, UnexpectedCharacters)
    return parse_messages.unreadable(block, line, column, block.text[unexpected.pos_in_stream or 0])


class _Transformer(Transformer_NonRecursive[Token, tree_builder.Item]):
    """Passes every rule of the grammar to the builder's method of the same name, with its span."""

    def __init__(self, builder: tree_builder.Builder, block: Block) -> None:
        super().__init__(visit_tokens=False)
        self._builder = builder
        self._block = block

    def __default__(self, data: str, children: list[object], meta: Meta | Token) -> tree_builder.Item:
        words = [self._word(child) if isinstance(child, Token) else child for child in children]
        return cast(tree_builder.Item, getattr(self._builder, str(data))(self._span(meta), *words))

    def _word(self, token: Token) -> Word:
        return Word(str(token), self._span(token))

    def _span(self, place: Meta | Token) -> Span:
        if getattr(place, "line", None) is None:
            return NOWHERE
        return self._block.stretch(
            place.line or 0, place.column or 0, place.end_line or 0, place.end_column or 0
        )
