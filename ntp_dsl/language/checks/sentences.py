"""Sentences for calls: each names every object of the call once, and no two calls are said alike."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from itertools import combinations

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix
from ntp_dsl.language.diagnostics.spelling import nearest
from ntp_dsl.language.names.symbol_table import SymbolTable
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import Declaration, Span, Text

Spoken = nodes.ApiDeclaration | nodes.ProgramDeclaration
PLACE = re.compile(r"\{ *([^{}]*?) *\}")


def check_placeholders(declaration: Spoken, table: SymbolTable) -> Iterator[Diagnostic]:
    """Check that each sentence names the parameters of the call: every object, and each once."""
    parameters = dict(_parameters(declaration, table))
    objects = [name for name, kind in parameters.items() if kind in table.types]
    for text in declaration.says:
        found = [match.group(1) for match in PLACE.finditer(text.value)]
        unknown = [match for match in PLACE.finditer(text.value) if match.group(1) not in parameters]
        yield from (_unknown(match, text, parameters) for match in unknown)
        if "{" in PLACE.sub("", text.value) or "}" in PLACE.sub("", text.value):
            yield Diagnostic("E411", "a brace has no partner: a parameter is written {item}", text.span)
            continue
        twice = [name for name in parameters if found.count(name) > 1]
        lacking = [name for name in objects if name not in found]
        if twice:
            message = f"the sentence names {{{twice[0]}}} twice: each parameter stands for one noun phrase"
            yield Diagnostic("E411", message, text.span)
        elif lacking and not unknown:
            message = (
                f"the sentence does not name {{{lacking[0]}}}, which '{declaration.name}' is called with"
            )
            help = f"whoever says it cannot tell which object is meant: add {{{lacking[0]}}}"
            yield Diagnostic("E411", message, text.span, help=help)


def _parameters(declaration: Spoken, table: SymbolTable) -> Iterator[tuple[str, str]]:
    """Yield the parameters, records replaced by their fields, with their types."""
    for each in declaration.parameters:
        record = table.records.get(each.type.name)
        if each.type.is_list:
            continue
        if record is not None:
            yield from ((field.name, field.type.name) for field in record.fields)
        else:
            yield each.name, each.type.name


def _unknown(match: re.Match[str], text: Text, parameters: Iterable[str]) -> Diagnostic:
    name, known = match.group(1), list(parameters)
    meant = nearest(name, known)
    listing = ", ".join(known) or "none"
    message = f"there is no parameter '{name}' that can be said ({listing})"
    message += f"; did you mean '{meant}'?" if meant else ""
    at, start = text.span, text.span.column + 1 + match.start(1)
    place = Span(at.path, at.line, start, at.line, start + max(1, len(name)))
    return Diagnostic("E411", message, place, fix=Fix(place, meant) if meant else None)


def check_said_alike(declarations: Iterable[Declaration], table: SymbolTable) -> Iterator[Diagnostic]:
    """Warn of two declarations that one sentence may mean: the words are the same, and the types overlap."""
    own = [each for each in declarations if isinstance(each, Spoken) and each.says]
    spoken = [(each, text) for each in own for text in each.says]
    for (one, first), (other, second) in combinations(spoken, 2):
        if one is other or _words(first) != _words(second):
            continue
        kinds = zip(_kinds(one, first, table), _kinds(other, second, table), strict=True)
        if all(_overlap(table, a, b) for a, b in kinds):
            message = f"'{other.name}' is said just as '{one.name}' is, so that a sentence may mean either"
            yield Diagnostic("W407", message, second.span, help="reword one of them")


def _words(text: Text) -> list[str]:
    return PLACE.sub("{}", text.value).lower().split()


def _kinds(declaration: Spoken, text: Text, table: SymbolTable) -> list[str]:
    """Return the types of what a sentence names, in its order."""
    parameters = dict(_parameters(declaration, table))
    return [parameters.get(match.group(1), "") for match in PLACE.finditer(text.value)]


def _overlap(table: SymbolTable, one: str, other: str) -> bool:
    """Return whether one type is the other, or of its kind."""
    return one in {*table.ancestors(other)} or other in {*table.ancestors(one)}
