"""The parser, from tables that are built from the grammar once: building takes longer than most checks.

The tables lie beside the grammar as JSON, with its fingerprint: they are data, and are passed over where the
grammar has changed. To make them anew: python -m ntp_dsl.language.parsing.parser_tables
"""

from __future__ import annotations

import json
from hashlib import sha256
from pathlib import Path
from typing import Any

import lark
from lark import Lark
from lark.grammar import Rule
from lark.indenter import Indenter
from lark.lexer import TerminalDef

from ntp_dsl.common.files import written_whole
from ntp_dsl.common.resources import grammar_folder
from ntp_dsl.language.parsing.blocks import KEYWORDS


class Layout(Indenter):
    """Indentation as in Python; lines inside brackets are joined."""

    NL_type = "_NEWLINE"
    OPEN_PAREN_types = ["LPAR", "LSQB"]
    CLOSE_PAREN_types = ["RPAR", "RSQB"]
    INDENT_type = "_INDENT"
    DEDENT_type = "_DEDENT"
    tab_len = 8


def parser() -> Lark:
    """Return the parser from the tables, or, where there are none that fit, from the grammar."""
    tables = _read()
    if tables is None:
        return built()
    # As lark's own stand-alone parsers do; it has no public name.
    loaded: Lark = Lark._load_from_dict(  # type: ignore[no-untyped-call]
        tables["data"], tables["memo"], postlex=Layout()
    )
    return loaded


def built() -> Lark:
    """Return the parser from the grammar."""
    return Lark(
        _grammar(),
        parser="lalr",
        postlex=Layout(),
        propagate_positions=True,
        maybe_placeholders=True,
        start=list(KEYWORDS),
    )


def tables_path() -> Path:
    return grammar_folder() / "ntp.tables.json"


def fingerprint() -> str:
    """Return a hash of all that the tables depend on: the grammar and lark's version."""
    return sha256(f"{lark.__version__}\n{_grammar()}".encode()).hexdigest()


def write() -> None:
    """Build the tables and write them."""
    data, memo = built().memo_serialize([TerminalDef, Rule])
    data["options"]["postlex"] = None  # an object, which `parser` passes
    document = {"fingerprint": fingerprint(), "data": data, "memo": memo}
    with written_whole(tables_path()) as partial:
        partial.write_text(json.dumps(document, separators=(",", ":"), sort_keys=True) + "\n")


def _read() -> dict[str, Any] | None:
    try:
        text = tables_path().read_text(encoding="utf-8")
    except OSError:
        return None
    if fingerprint() not in text:
        return None
    document: dict[str, Any] = json.loads(text, object_hook=_with_numbers)
    return document


def _with_numbers(row: dict[str, Any]) -> dict[Any, Any]:
    """Turn JSON's text keys into numbers, as states and places of the tables are."""
    return {int(key) if key.isdecimal() else key: value for key, value in row.items()}


def _grammar() -> str:
    return (grammar_folder() / "ntp.lark").read_text(encoding="utf-8")


if __name__ == "__main__":
    write()
