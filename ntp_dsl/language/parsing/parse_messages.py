"""Messages of the parser in a user's words: what was expected, found, and perhaps meant."""

from __future__ import annotations

import re
from collections.abc import Set

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix
from ntp_dsl.language.diagnostics.spelling import is_misspelt, nearest
from ntp_dsl.language.parsing.blocks import WORD, Block
from ntp_dsl.language.parsing.foreign_syntax import SYNONYMS, UNCERTAIN
from ntp_dsl.language.syntax.nodes import Span

LINE_END = "the end of the line"
BLOCK_END = "the end of the block"
INDENTED = "an indented line"
OPERATOR = "an operator"

TERMINALS = {
    "NAME": "a name",
    "NUMBER": "a number",
    "COMPARISON": OPERATOR,
    "SIGN": OPERATOR,
    "FACTOR": OPERATOR,
    "MINUS": "'-'",
    "_AT": "'at least'",
    "_LEAST": "'least'",
    "_SAYS": "'says'",
    "DOCSTRING": "a docstring",
    "STRING": "a text in quotes",
    "_NEWLINE": LINE_END,
    "_INDENT": INDENTED,
    "_DEDENT": BLOCK_END,
    "$END": BLOCK_END,
}
# The beginning of an expression is one idea for the reader, and ten terminals for the parser.
QUANTIFIERS = {"'all'", "'some'", "'exactly'", "'at least'"}
EXPRESSION = {"a name", "a number", "'-'", "'('", "'any'", "'not'", *QUANTIFIERS}
FOREIGN = frozenset("elif return pass break continue while try let var".split())
COUNTED = "a count is a number in the text, such as 2; it cannot be a parameter or a field"
LINE_WORDS = {
    "requires",
    "achieves",
    "says",
    "for",
    "when",
    "else",
    "scene",
    "initially",
    "goal",
    "run",
    "success",
}


def expectation(expected: Set[str]) -> str:
    """Return the expected words as one phrase, the likeliest first."""
    words = set(expected)
    if {"'not'", "'all'"} <= words:
        words = words - EXPRESSION | {"a condition"}
    elif {"a number", "'any'"} <= words:
        words = words - EXPRESSION | {"a value"}
    if len(words) > 1:
        words -= {BLOCK_END, "a docstring"}
    if len(words) > 3:
        words -= {OPERATOR, "'.'", "'and'", "'or'"}
    listing = sorted(words, key=lambda word: (not word.startswith("'"), word))
    if len(listing) <= 1:
        return "".join(listing) or "nothing more"
    return f"{', '.join(listing[:-1])} or {listing[-1]}"


def _found(kind: str, text: str) -> str:
    named = {"_NEWLINE": LINE_END, "_INDENT": "a line that is indented further"}
    if kind in {"_DEDENT", "$END"}:
        return "the end of the declaration"
    if kind == "DOCSTRING":
        return "a docstring"
    return named.get(kind, f"'{text}'")


def unexpected(block: Block, line: int, column: int, text: str, kind: str, expected: Set[str]) -> Diagnostic:
    """Report a word where the grammar has no place for it."""
    visible = not kind.startswith(("_", "$")) and "\n" not in text
    span = block.span(line, column, len(text) if visible else 1)
    row = block.text.split("\n")[line - 1]
    first = WORD.match(row.strip())
    if line > 1 and first and first.group() in FOREIGN:
        return foreign(first.group(), block.span(line, row.index(first.group()) + 1, len(first.group())))
    if text in FOREIGN:
        return foreign(text, span)
    misspelt_keyword = _misspelt_line(block, line, column, expected)
    if misspelt_keyword is not None:
        return misspelt_keyword
    message = f"expected {expectation(expected)}, found {_found(kind, text)}"
    fix = None
    untyped = re.search(r"[(,]\s*([A-Za-z_]\w*)\s*$", block.text.split("\n")[line - 1][: column - 1])
    if expected == {"':'"} and text in {")", ","} and untyped:
        name = untyped.group(1)
        message = f"'{name}' has no type"
        return Diagnostic("E001", message, span, help=f"for example: {name}: Object")
    if kind == "_INDENT":
        message = "this line is indented further than the one above, which opens no block"
        span = _next_line(block, line)
        if block.text.split("\n")[span.line - block.line].startswith("\t"):
            message = (
                "this line is indented by a tab, which counts as eight blanks: further than the one above"
            )
    if kind == "_NEWLINE" and "':'" in expected and _opens_block(block, line):
        message = "a ':' is missing at the end of this line"
        fix = Fix(block.span(line, column, 0), ":", certain=True)
    before = row[: column - 1].split()[-1:]
    help = COUNTED if before in (["exactly"], ["least"]) else _advice(kind, expected)
    return Diagnostic("E001", message, span, help=help, fix=fix)


def foreign(word: str, span: Span, fix: Fix | None = None) -> Diagnostic:
    """Report a word such as `return` or `elif`."""
    help = "a body consists of calls, 'for', 'when' and 'else'"
    if word == "try":
        help = "what fails is tried anew while it is due; 'failures(x)', of the library 'attempts', counts it"
    if word == "elif":
        help = "write another 'when'; for the opposite of the one before, 'else:'"
    return Diagnostic("E001", f"there is no '{word}' in the language", span, help=help, fix=fix)


def _next_line(block: Block, line: int) -> Span:
    """Return where the next line that has text begins."""
    rows = block.text.split("\n")
    for number, row in enumerate(rows[line:], start=line + 1):
        if row.strip() and not row.lstrip().startswith("#"):
            return block.span(number, len(row) - len(row.lstrip()) + 1)
    return block.span(line, len(rows[line - 1]) + 1)


def _advice(kind: str, expected: Set[str]) -> str:
    if kind in {"_DEDENT", "$END", "_NEWLINE"} and INDENTED in expected:
        return "what belongs to this declaration is indented below it"
    if kind == "_INDENT":
        return "indent it as the one above; only expressions in brackets continue over several lines"
    return ""


def _opens_block(block: Block, line: int) -> bool:
    words = block.text.split("\n")[line - 1].split()
    return bool(words) and words[0] in {"program", "task", "for", "when"}


def _misspelt_line(block: Block, line: int, column: int, expected: Set[str]) -> Diagnostic | None:
    """Report a line such as `require present(x)`, which fails at its second word for the first one."""
    row = block.text.split("\n")[line - 1]
    first = WORD.match(row.strip())
    start = len(row) - len(row.lstrip()) + 1
    if first is None or first.group() in LINE_WORDS or (line == 1 and start == 1):
        return None
    end = start + len(first.group())
    between = row[end - 1 : column - 1].strip()
    allowed = {word.strip("'") for word in expected} & LINE_WORDS if column == start else LINE_WORDS
    word = first.group()
    meant = SYNONYMS.get(word.lower())
    certain = word.lower() not in UNCERTAIN
    if meant not in allowed:
        meant = nearest(word, allowed)
        certain = meant is not None and is_misspelt(word, meant, LINE_WORDS)
    if meant is None or between or "(" in row[end - 1 : end]:
        return None
    span = block.span(line, start, len(first.group()))
    message = f"'{first.group()}' is not a word of the language; did you mean '{meant}'?"
    is_clause = meant in {"requires", "achieves"} and row[end - 1 : end] == ":"
    taken = block.span(line, start, len(first.group()) + is_clause)
    return Diagnostic("E001", message, span, fix=Fix(taken, meant, certain=certain))


def unreadable(block: Block, line: int, column: int, letter: str) -> Diagnostic:
    """Report a character that occurs nowhere in the language."""
    message = f"the character {letter!r} does not belong to the language"
    help = "only a docstring is text in quotes: three double quotes" if letter in "\"'" else ""
    return Diagnostic("E001", message, block.span(line, column), help=help)


def dedent(block: Block) -> Diagnostic:
    """Report a line that is indented less than the body above it, but more than the header of that."""
    rows = [
        (number, row)
        for number, row in enumerate(block.text.split("\n"), start=1)
        if row.strip() and not row.lstrip().startswith("#")
    ]
    levels, above = [0], 0
    number, row = rows[-1]  # where none is found, since brackets may hide it
    for candidate, text in rows:
        indent = _indent(text)
        while levels and indent < levels[-1]:
            levels.pop()
        if indent not in levels and levels and above > indent:
            number, row = candidate, text
            break
        levels.append(indent)
        above = indent
    column = len(row) - len(row.lstrip()) + 1
    message = "the indentation of this line matches no line above that it could belong to"
    return Diagnostic("E001", message, block.span(number, column))


def _indent(row: str) -> int:
    """Return the indentation as the parser counts it: a tab for eight blanks, a form feed for none."""
    margin = row[: len(row) - len(row.lstrip())]
    return margin.count(" ") + 8 * margin.count("\t")
