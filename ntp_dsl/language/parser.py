"""From text to syntax tree. Says nothing about meaning: see `check`."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import cast

from lark import Lark, Token
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken
from lark.indenter import DedentError, Indenter
from lark.lexer import PatternStr
from lark.tree import Meta
from lark.visitors import Transformer_NonRecursive

from ntp_dsl.language import build, pieces, wording
from ntp_dsl.language.build_terms import Word
from ntp_dsl.language.diagnostics import Diagnostic, Fix, SourceError
from ntp_dsl.language.pieces import KEYWORDS, Piece
from ntp_dsl.language.syntax import NOWHERE, Declaration, Library, Span, Use
from ntp_dsl.resources import grammar_folder


class _Layout(Indenter):
    """Indentation as in Python; lines inside brackets are joined."""

    NL_type = "_NEWLINE"
    OPEN_PAREN_types = ["LPAR", "LSQB"]
    CLOSE_PAREN_types = ["RPAR", "RSQB"]
    INDENT_type = "_INDENT"
    DEDENT_type = "_DEDENT"
    tab_len = 8


@cache
def _lark() -> Lark:
    grammar = (grammar_folder() / "ntp.lark").read_text(encoding="utf-8")
    return Lark(
        grammar,
        parser="lalr",
        postlex=_Layout(),
        propagate_positions=True,
        maybe_placeholders=True,
        start=list(KEYWORDS),
    )


@cache
def _words() -> dict[str, str]:
    """What a user calls each of the grammar's terminals."""
    words = {
        terminal.name: f"'{terminal.pattern.value}'"
        for terminal in _lark().terminals
        if isinstance(terminal.pattern, PatternStr)
    }
    return words | wording.TERMINALS


def parse(text: str, path: Path | str | None = None) -> Library:
    """Read a library; `SourceError` carries every mistake of the text, one a declaration at most.

    Args:
        path: where the text comes from, for the spans; the file is not opened.
    """
    where = None if path is None else Path(path)
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    mistakes: list[Diagnostic] = []
    parsed = [_parse_piece(piece, mistakes) for piece in pieces.cut(text, where)]
    headers = [node for node in parsed if isinstance(node, build.Header)]
    mistakes += _header_mistakes(headers, parsed, where)
    if mistakes:
        raise SourceError(mistakes, {where: text})
    return Library(
        headers[0].name,
        tuple(node for node in parsed if isinstance(node, Use)),
        tuple(node for node in parsed if isinstance(node, Declaration)),
        headers[0].docstring,
        where,
    )


def _header_mistakes(
    headers: list[build.Header], parsed: list[build.Item | None], path: Path | None
) -> list[Diagnostic]:
    stem = path.stem if path and path.stem.isidentifier() else "NAME"
    top = Span(path, 1, 1, 1, 1)
    if not headers and None in parsed:
        return []  # the header may be among what did not parse
    if not headers:
        help = f"write 'library {stem}' above everything else"
        fix = Fix(top, f"library {stem}\n\n")
        return [
            Diagnostic("E005", "the text does not say which library it is", top, help=help, fix=fix)
        ]
    mistakes = [
        Diagnostic("E005", "a text is one library; this is another header", header.span)
        for header in headers[1:]
    ]
    if parsed[0] is not headers[0] and parsed[0] is not None:
        mistakes.append(
            Diagnostic("E005", "'library' comes before everything else", headers[0].span)
        )
    return mistakes


def _parse_piece(piece: Piece, mistakes: list[Diagnostic]) -> build.Item | None:
    problems = [pieces.misspelt(piece)] if piece.keyword not in KEYWORDS else []
    problems += pieces.unbalanced(piece)
    if problems:
        mistakes += problems
        return None
    try:
        tree = _lark().parse(piece.text, start=piece.keyword)
    except UnexpectedInput as unexpected:
        mistakes.append(_explain(unexpected, piece))
        return None
    except DedentError:
        mistakes.append(wording.dedent(piece))
        return None
    builder = build.Builder()
    item = _Transformer(builder, piece).transform(tree)
    mistakes += builder.mistakes
    return None if builder.mistakes else item


def _explain(unexpected: UnexpectedInput, piece: Piece) -> Diagnostic:
    line, column = unexpected.line, unexpected.column
    if isinstance(unexpected, UnexpectedToken):
        accepted = unexpected.accepts or unexpected.expected
        token = unexpected.token
        expected = {_words().get(name, name) for name in accepted}
        if token.type == "$END":
            line, column = piece.text.count("\n"), len(piece.text.rstrip("\n").split("\n")[-1]) + 1
        return wording.unexpected(piece, line, column, str(token), token.type, expected)
    assert isinstance(unexpected, UnexpectedCharacters)
    return wording.unreadable(piece, line, column, piece.text[unexpected.pos_in_stream or 0])


class _Transformer(Transformer_NonRecursive[Token, build.Item]):
    """Hands every rule of the grammar to the builder's method of the same name, with its place."""

    def __init__(self, builder: build.Builder, piece: Piece) -> None:
        super().__init__(visit_tokens=False)
        self._builder = builder
        self._piece = piece

    def __default__(self, data: str, children: list[object], meta: Meta | Token) -> build.Item:
        words = [self._word(child) if isinstance(child, Token) else child for child in children]
        return cast(build.Item, getattr(self._builder, str(data))(self._span(meta), *words))

    def _word(self, token: Token) -> Word:
        return Word(str(token), self._span(token))

    def _span(self, place: Meta | Token) -> Span:
        if getattr(place, "line", None) is None:
            return NOWHERE
        above = self._piece.line - 1
        start, end = (place.line or 0) + above, (place.end_line or 0) + above
        return Span(self._piece.path, start, place.column or 0, end, place.end_column or 0)
