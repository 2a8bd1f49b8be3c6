"""The parser's tables are those of the grammar."""

from __future__ import annotations

import json

from ntp_dsl.common.resources import examples_folder, library_folder
from ntp_dsl.language.parsing import parser_tables
from ntp_dsl.language.parsing.blocks import split_blocks


def test_the_tables_are_of_the_grammar_as_it_is() -> None:
    document = json.loads(parser_tables.tables_path().read_text())
    again = "python -m ntp_dsl.language.parsing.parser_tables"
    assert document["fingerprint"] == parser_tables.fingerprint(), f"the grammar has changed: {again}"


def test_what_is_read_by_the_tables_is_what_the_grammar_reads() -> None:
    quick, slow = parser_tables.parser(), parser_tables.built()
    for path in [*library_folder().glob("*.ntp"), *examples_folder().glob("*/*.ntp")]:
        for block in split_blocks(path.read_text(), path):
            trees = [each.parse(block.text, start=block.keyword) for each in (quick, slow)]
            assert trees[0] == trees[1]
