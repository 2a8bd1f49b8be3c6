"""A Pygments lexer, for documents and terminals."""

from __future__ import annotations

from pygments.lexer import RegexLexer, bygroups, words
from pygments.token import (
    Comment,
    Keyword,
    Name,
    Number,
    Operator,
    Punctuation,
    String,
    Whitespace,
)

from ntp_dsl.language.names.symbol_table import NUMBER_TYPES, UNITS
from ntp_dsl.language.parsing.blocks import KEYWORDS

CLAUSES = ("requires", "achieves", "says", "calls")
SECTIONS = ("scene", "initially", "goal", "run", "success")
FLOW = ("for", "when", "else", "if", "in", "is", "by", "on", "as", "with")
LOGIC = ("all", "some", "exactly", "at least", "not", "and", "or")
NAME = r"[A-Za-z_][A-Za-z0-9_]*"
BLANK = r"[ \t\f]"


class NtpLexer(RegexLexer):  # type: ignore[misc]  # Pygments has no type annotations
    """`.ntp`: libraries of robot tasks."""

    name = "NTP task language"
    aliases = ["ntp"]
    filenames = ["*.ntp"]
    mimetypes = ["text/x-ntp"]
    url = ""

    tokens = {
        "root": [
            (r"\n", Whitespace),
            (rf"^({BLANK}+)({'|'.join(SECTIONS)})(?=:)", bygroups(Whitespace, Keyword)),
            (rf"{BLANK}+", Whitespace),
            (r"#[^\n]*", Comment.Single),
            (r'"""[\s\S]*?"""', String.Doc),
            (r'"[^"\n]*"', String),
            (rf"^(library|use)({BLANK}+)({NAME})", bygroups(Keyword.Namespace, Whitespace, Name.Namespace)),
            (
                rf"^(type|enum|record)({BLANK}+)({NAME})",
                bygroups(Keyword.Declaration, Whitespace, Name.Class),
            ),
            (
                rf"^(constant)({BLANK}+)({NAME})",
                bygroups(Keyword.Declaration, Whitespace, Name.Constant),
            ),
            (
                rf"^({'|'.join(KEYWORDS)})({BLANK}+)({NAME})",
                bygroups(Keyword.Declaration, Whitespace, Name.Function),
            ),
            (words(CLAUSES, prefix=r"\b", suffix=r"\b"), Keyword),
            (words(LOGIC, prefix=r"\b", suffix=r"\b"), Operator.Word),
            (rf"\bat{BLANK}+least\b", Operator.Word),
            (rf"\b(by)({BLANK}+)(python)\b", bygroups(Keyword, Whitespace, Keyword.Pseudo)),
            (r"\blist(?=\[)", Keyword.Type),
            (words(NUMBER_TYPES, prefix=r"(?<=: )", suffix=r"\b"), Keyword.Type),
            (words(FLOW, prefix=r"\b", suffix=r"\b(?!\()"), Keyword),
            (r"\bany\b", Keyword.Constant),
            (
                rf"([0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?)({BLANK}*)({'|'.join(UNITS)})\b",
                bygroups(Number, Whitespace, Keyword.Type),
            ),
            (r"[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?", Number),
            (rf"{NAME}(?={BLANK}*\()", Name.Function),
            (NAME, Name),
            (r"->|\.\.|==|!=|<=|>=|[<>=+\-*/]", Operator),
            (r"[()\[\],:.]", Punctuation),
        ]
    }
