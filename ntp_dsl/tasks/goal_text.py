"""The lists that a program is called with, as text: what `ntp read` prints, and `ntp run --goal` takes back.

# 4 of 4 acts of the hand are explained
goal: (block_0, block_1), (block_2, block_0)
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path

from ntp_dsl.common.text import shortened
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.names.symbol_table import UNITS
from ntp_dsl.language.registry import Callable, Parameter, Registry
from ntp_dsl.semantics.observation import Argument, Record, SceneObject
from ntp_dsl.semantics.value_checks import guess, misfit, strays

Element = Record | str
Lists = Mapping[str, tuple[Element, ...]]

TOKEN = re.compile(
    r"""\s*(?:
    (?P<number>[+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)\s*(?P<unit>[A-Za-z]+\b)?
    |(?P<name>[^\W\d][\w.-]*)
    |(?P<sign>[(),:])
    )""",
    re.VERBOSE,
)
BASE_UNITS = {"length": "m", "angle": "rad", "time": "s", "force": "N", "mass": "kg"}
LARGEST = 10**6  # characters of a file


def format_lists(registry: Registry, program: Callable, arguments: Sequence[Argument]) -> str:
    """Return the lists among a program's arguments as text, each by its parameter's name."""
    rows = []
    for parameter, value in zip(program.parameters, arguments, strict=True):
        if isinstance(value, tuple):
            elements = [format_element(registry, each) for each in value]
            separator = ",\n    " if sum(map(len, elements)) > 90 else ", "
            start = "\n    " if "\n" in separator else " "
            rows.append(f"{parameter.name}:{start if elements else ''}{separator.join(elements)}\n")
    return "".join(rows)


def format_element(registry: Registry, element: Element) -> str:
    """Return an element of a list as text: a name, or a record's values in brackets."""
    if isinstance(element, str):
        return element
    types = {field.name: field.type for field in registry.records[element.type]}
    values = [_format_value(value, types[name]) for name, value in element.fields]
    return f"({', '.join(values)})"


def _format_value(value: str | float, type_name: str) -> str:
    if isinstance(value, str):
        return value
    unit = BASE_UNITS.get(type_name, "")
    return f"{float(f'{value:.6g}')!r} {unit}".rstrip()


@dataclass(frozen=True)
class _Token:
    text: str
    kind: str  # name, number, sign
    value: float  # of a number [SI]
    line: int
    measures: str = ""  # what the unit of a number measures


def read_lists(path: Path, registry: Registry, program: Callable, objects: Sequence[SceneObject]) -> Lists:
    """Read what `format_lists` writes, edited or not.

    Raises `NtpError`, with the line, for anything that the program does not take.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise NtpError(f"{path}: expected text in UTF-8") from error
    except OSError as error:
        raise NtpError(f"{path}: {error.strerror}") from error
    if len(text) > LARGEST:
        raise NtpError(f"{path}: expected a goal, as `ntp read` prints; this is too long for one")
    return parse_lists(text, str(path), registry, program, objects)


def parse_lists(
    text: str, where: str, registry: Registry, program: Callable, objects: Sequence[SceneObject]
) -> Lists:
    """Return the lists of a text, as `read_lists` does of a file.

    Args:
        where: the text is from, for errors.
    """
    return _Parser(where, registry, program, objects).parse(list(_tokens(where, text)))


def _tokens(path: str, text: str) -> Iterator[_Token]:
    for number, row in enumerate(text.split("\n"), start=1):
        row = row.split("#")[0].rstrip()
        at = 0
        while at < len(row):
            match = TOKEN.match(row, at)
            if match is None:
                raise NtpError(
                    f"{path}:{number}: expected a name or a number, found '{shortened(row[at:].strip())}'"
                )
            at = match.end()
            if match["number"]:
                unit = match["unit"] or ""
                if unit and unit not in UNITS:
                    raise NtpError(f"{path}:{number}: there is no unit '{unit}'{guess(unit, UNITS)}")
                measures, scale = UNITS[unit] if unit else ("", 1.0)
                yield _Token(match[0].strip(), "number", float(match["number"]) * scale, number, measures)
            else:
                kind = "name" if match["name"] else "sign"
                yield _Token(match["name"] or match["sign"], kind, 0.0, number)


class _Parser:
    def __init__(
        self, path: str, registry: Registry, program: Callable, objects: Sequence[SceneObject]
    ) -> None:
        self.path, self.registry, self.program = path, registry, program
        self.types = dict(registry.constants) | {obj.name: obj.type for obj in objects}

    def parse(self, tokens: list[_Token]) -> Lists:
        lists = {each.name: each for each in self.program.parameters if each.is_list}
        found: dict[str, tuple[Element, ...]] = {}
        while tokens:
            name = tokens.pop(0)
            if name.text not in lists:
                known = ", ".join(lists) or "none"
                raise self._error(
                    name, f"expected a list of '{self.program.name}' ({known}), found '{name.text}'"
                )
            if name.text in found:
                raise self._error(name, f"'{name.text}' is there twice")
            self._take(tokens, ":", name)
            found[name.text] = tuple(self._elements(tokens, lists[name.text], name))
        for missing in lists:
            if missing not in found:
                raise NtpError(
                    f"{self.path}: expected '{missing}: …', a list that '{self.program.name}' takes"
                )
        return found

    def _elements(self, tokens: list[_Token], parameter: Parameter, last: _Token) -> Iterator[Element]:
        while tokens and not (len(tokens) > 1 and tokens[1].text == ":"):
            last = tokens[0]
            if parameter.type in self.registry.records:
                yield self._record(tokens, parameter.type)
            else:
                value = self._value(tokens.pop(0), replace(parameter, is_list=False))
                assert isinstance(value, str), "lists are of objects, members and records"
                yield value
            if not tokens or tokens[0].text != ",":
                return
            last = tokens.pop(0)
            if not tokens or (len(tokens) > 1 and tokens[1].text == ":"):
                raise self._error(last, "expected another element after the comma")

    def _record(self, tokens: list[_Token], name: str) -> Record:
        fields = self.registry.records[name]
        last = tokens[0]
        self._take(tokens, "(", last)
        values: list[tuple[str, str | float]] = []
        for index, field in enumerate(fields):
            if index:
                last = self._take(tokens, ",", last)
            if not tokens or tokens[0].kind == "sign":
                names = ", ".join(each.name for each in fields)
                raise self._error(tokens[0] if tokens else last, f"expected ({names}) of {name}")
            last = tokens.pop(0)
            values.append((field.name, self._value(last, field)))
        self._take(tokens, ")", last)
        return Record(name, tuple(values))

    def _value(self, token: _Token, parameter: Parameter) -> str | float:
        value: str | float = token.value if token.kind == "number" else token.text
        if token.kind == "number" and parameter.type not in self.registry.parents:
            wanted = parameter.type if parameter.type in BASE_UNITS else ""
            if token.measures != wanted or not isfinite(token.value):
                unit = (
                    f"a {wanted}, such as 1.5 {BASE_UNITS[wanted]}," if wanted else "a number without a unit"
                )
                raise self._error(token, f"expected {unit} for '{parameter.name}', found '{token.text}'")
        if expected := misfit(self.registry, parameter, value, self.types) or strays(parameter, value):
            hint = (
                guess(token.text, self.types) if token.kind == "name" and token.text not in self.types else ""
            )
            raise self._error(
                token, f"expected {expected} for '{parameter.name}', found '{token.text}'{hint}"
            )
        return value

    def _take(self, tokens: list[_Token], sign: str, last: _Token) -> _Token:
        if not tokens or tokens[0].text != sign:
            found = f"found '{tokens[0].text}'" if tokens else "found the end"
            raise self._error(tokens[0] if tokens else last, f"expected '{sign}', {found}")
        return tokens.pop(0)

    def _error(self, token: _Token, message: str) -> NtpError:
        return NtpError(f"{self.path}:{token.line}: {shortened(message)}")
