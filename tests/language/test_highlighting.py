"""Editors and documents see what is a keyword, a name, a number and a comment."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from pygments.token import Comment, Error, Keyword, Name, Number, Operator, String

from ntp_dsl.common.resources import examples_folder, grammar_folder, library_folder
from ntp_dsl.language.formatting.pygments_lexer import CLAUSES, FLOW, LOGIC, SECTIONS, NtpLexer
from ntp_dsl.language.names.symbol_table import NUMBER_TYPES, UNITS
from ntp_dsl.language.parsing.blocks import KEYWORDS
from ntp_dsl.language.parsing.parser import _lark

REFERENCE = (grammar_folder() / "README.md").read_text(encoding="utf-8")
TEXTS = {
    path.stem: path.read_text()
    for path in [*library_folder().glob("*.ntp"), *examples_folder().glob("*/*.ntp")]
}
TEXTS["reference"] = "\n".join(re.findall(r"^ {4}(.*)", REFERENCE, flags=re.MULTILINE))
EXAMPLE = """library a  # so
use b
type Cup is Movable
enum Side: left, right
predicate full(c: Cup) -> length by python
api pull(d: Drawer, distance: length in 0 .. 0.3 m) by tug
    requires not holding(any) and all on(o, d) for o in Object if clear(o)
program go(goal: list[Placement]) by python:
    \"\"\"Goes.\"\"\"
    calls pull
task t:
    scene:   cups: 2..4 Cup on table with urdf("cup.urdf")
    goal:    towers(cups, height=2)
"""


def spoken(text: str) -> list[tuple[object, str]]:
    return [(kind, word) for kind, word in NtpLexer().get_tokens(text) if word.strip()]


@pytest.mark.parametrize("name", TEXTS)
def test_nothing_of_the_language_is_unknown_to_the_lexer(name: str) -> None:
    tokens = list(NtpLexer(stripnl=False, ensurenl=False).get_tokens(TEXTS[name]))
    assert "".join(word for _, word in tokens) == TEXTS[name]
    assert [word for kind, word in tokens if kind is Error] == []


@pytest.mark.parametrize(
    "kind, word",
    [
        (Keyword.Namespace, "library"), (Name.Namespace, "b"), (Comment.Single, "# so"),
        (Keyword.Declaration, "type"), (Name.Class, "Cup"), (Keyword, "is"), (Name, "left"),
        (Name.Function, "full"), (Keyword.Pseudo, "python"), (Keyword.Type, "length"),
        (Number, "0.3"), (Keyword.Type, "m"), (Keyword, "by"), (Name, "tug"), (Keyword, "requires"),
        (Operator.Word, "not"), (Keyword.Constant, "any"), (Operator.Word, "all"), (Keyword, "if"),
        (Keyword.Type, "list"), (String.Doc, '\"\"\"Goes.\"\"\"'), (Keyword, "calls"), (Keyword, "scene"),
        (Keyword, "with"), (String, '"cup.urdf"'), (Name.Function, "towers"), (Operator, ".."),
    ],
)  # fmt: skip
def test_a_word_is_what_it_is_in_the_language(kind: object, word: str) -> None:
    assert (kind, word) in spoken(EXAMPLE)


def test_a_section_is_a_keyword_only_where_it_is_one() -> None:
    assert (Name, "goal") in spoken("    for p in goal:\n") and (Keyword, "goal") in spoken("    goal: t()\n")


def test_pygments_finds_the_lexer_by_its_name() -> None:
    from importlib.metadata import EntryPoint

    project = (Path(__file__).parents[2] / "pyproject.toml").read_text()
    found = re.search(r'"pygments.lexers"\]\n(\w+) = "([\w.:]+)"', project)
    assert found and EntryPoint(found[1], found[2], "pygments.lexers").load() is NtpLexer


def grammar_words() -> set[str]:
    """Every word that the grammar itself spells, and every two that belong together."""
    patterns = [str(terminal.pattern.value) for terminal in _lark().terminals]
    words = [re.sub(r"(?s)\(\?=.*\)\+(\w+)\\b\)$", r" \1", each).removesuffix(r"\b") for each in patterns]
    words = [re.sub(r"(?s)\(\?=.*\)$", "", each) for each in words]
    found = {word for word in words if re.fullmatch(r"[a-z]+( [a-z]+)?", word)}
    return found - {second for _, blank, second in (word.partition(" ") for word in found) if blank}


TEXTMATE = json.loads((grammar_folder() / "ntp.tmLanguage.json").read_text(encoding="utf-8"))


def matches() -> list[str]:
    """Every regular expression of the TextMate grammar."""
    rules = list(TEXTMATE["repository"].values())
    rules += [rule for each in rules for rule in each.get("patterns", [])]
    return [each[key] for each in rules for key in ("match", "begin", "end") if key in each]


def test_both_know_every_word_of_the_grammar() -> None:
    ours = {*KEYWORDS, *CLAUSES, *SECTIONS, *FLOW, *LOGIC, "any", "list"}
    assert grammar_words() == ours
    spelt = " ".join(matches()).replace("\\b", " ")
    assert [word for word in ours if not re.search(rf"\b{word}\b", spelt)] == []
    for word in [*UNITS, *NUMBER_TYPES]:
        assert any(re.search(rf"[(|]{word}[)|]", each) for each in matches())


def test_the_textmate_grammar_is_whole() -> None:
    assert [re.compile(each) for each in matches()]
    included = [each["include"].removeprefix("#") for each in TEXTMATE["patterns"]]
    assert sorted(included) == sorted(TEXTMATE["repository"])
    assert (TEXTMATE["scopeName"], TEXTMATE["fileTypes"]) == ("source.ntp", ["ntp"])


@pytest.mark.parametrize("name", TEXTS)
def test_the_textmate_grammar_leaves_no_mark_of_the_language_out(name: str) -> None:
    text = re.sub(r'"""[\s\S]*?"""', "", TEXTS[name])
    found = re.compile("|".join(f"(?:{each})" for each in matches() if each != '"""'), re.MULTILINE)
    assert set(re.sub(r"\s", "", found.sub("", text))) <= set("()[],:.")
