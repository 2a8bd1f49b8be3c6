"""Rows learnt from traces: of one program what it calls, and which of the calls that are due it prefers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from hashlib import sha256
from inspect import getsource
from pathlib import Path

import msgspec
from msgspec import Struct

from ntp_dsl.common.decoding import Count, Unreadable, decode
from ntp_dsl.common.files import written_whole
from ntp_dsl.core.learnt.bodies import ShownCall, fits, with_calls
from ntp_dsl.core.learnt.preferences import Preference
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Program, Registry
from ntp_dsl.language.syntax.formatter import hash_declaration
from ntp_dsl.language.syntax.visitors import predicates

FORMAT, VERSION = "ntp-rows", 1
SUFFIX = ".rows.json"
MADE_BY = "ntp train --program"


class LearntRow(Struct, frozen=True, kw_only=True):
    """What was learnt of one program. `of` names its declaration, and those of what it calls."""

    format: str = FORMAT
    version: int = VERSION
    program: str
    of: str
    function: str = ""  # names the text of the function that it was learnt from
    calls: tuple[ShownCall, ...]  # none where the program declares its body
    preference: Preference
    traces: Count
    decisions: Count
    due: Count  # of them, those in which the call was due by the declaration
    foreseen: float  # share of these that are foreseen by what other traces show


def declaration_of(registry: Registry, program: str, preference: Preference) -> str:
    """Return what tells declarations apart: of a program, of what it calls directly, and of the predicates
    that their contracts and its preference rest on.
    """
    row = registry.programs[program]
    rows = [row, *(registry[each] for each in row.callees)]
    names = {each.what for each in preference.quantities if each.is_declared}
    names |= {name for each in rows for side in (each.requires, each.achieves) for name in predicates(side)}
    reached: set[str] = set()
    while new := names - reached:
        reached |= new
        known = [registry.predicates[name] for name in new if name in registry.predicates]
        names |= {name for each in known for name in predicates(each.body)}
    told = [f"{name}={_hash(registry, name)}" for name in sorted(reached)]
    types = {parameter.type for each in rows for parameter in each.parameters}
    types |= {field.type for name in types for field in registry.records.get(name, ())}
    told += [f"{name}={_meaning(registry, name)}" for name in sorted(types)]
    return _digest(";".join([each.hash for each in rows] + told))


def function_of(registry: Registry, program: str) -> str:
    """Return what tells functions in Python apart: a hash of a program's own; empty where none is loaded."""
    function = registry.python.functions.get(("expert", program))
    try:
        return _digest(getsource(function)) if function is not None else ""
    except (OSError, TypeError):  # there is no text of it
        return ""


def _digest(text: str) -> str:
    return sha256(text.encode()).hexdigest()[:16]


def _meaning(registry: Registry, type_name: str) -> str:
    """Return what a type stands for: its ancestors, members or fields."""
    if type_name in registry.enums:
        return ", ".join(registry.enums[type_name])
    if type_name in registry.records:
        return ", ".join(f"{each.name}: {each.type}" for each in registry.records[type_name])
    return " is ".join(registry.ancestors(type_name)) if type_name in registry.parents else ""


def _hash(registry: Registry, predicate: str) -> str:
    declared = registry.predicates.get(predicate)
    return hash_declaration(declared) if declared is not None else ""


# Files ----------------------------------------------------------------------------------------------


def rows_file(program: Program) -> Path | None:
    """Return where a program's learnt row is kept: beside its library. None where that is no file."""
    path = program.span.path
    return path.parent / f"{program.name}{SUFFIX}" if path is not None else None


def save_row(row: LearntRow, path: Path) -> None:
    """Write a row, whole or not at all. Raises `OSError`."""
    with written_whole(path) as partial:
        partial.write_bytes(msgspec.json.format(msgspec.json.encode(row)) + b"\n")


def read_row(path: Path) -> LearntRow:
    """Read a row. Raises `NtpError` for anything else."""
    try:
        row = decode(path.read_bytes(), LearntRow)
    except (Unreadable, OSError) as error:
        raise NtpError(f"{path}: expected a row of `{MADE_BY}`: {error}") from error
    if (row.format, row.version) != (FORMAT, VERSION):
        raise NtpError(f"{path}: expected {FORMAT}, version {VERSION}; found {row.format}, {row.version}")
    return row


@dataclass(frozen=True)
class LearntRows:
    """The rows that lie beside a library, by program."""

    rows: Mapping[str, LearntRow]

    def applied(self, registry: Registry) -> Registry:
        """Return the registry in which programs in Python have the bodies that traces showed."""
        changed = {
            name: with_calls(registry, registry.programs[name], row.calls)
            for name, row in self.rows.items()
            if row.calls and registry.programs[name].in_python
        }
        return replace(registry, programs={**registry.programs, **changed}) if changed else registry

    @property
    def preferences(self) -> dict[str, Preference]:
        return {name: row.preference for name, row in self.rows.items()}


def rows_beside(registry: Registry) -> LearntRows:
    """Return the learnt rows that lie beside a library's files.

    Raises `NtpError` for a row that was learnt of another declaration.
    """
    found = {}
    for name, program in registry.programs.items():
        path = rows_file(program)
        if path is None or not path.is_file():
            continue
        row = read_row(path)
        if fault := _fault(registry, name, row):
            raise NtpError(f"{path}: {fault}: train it anew (`{MADE_BY} {name}`), or remove the file")
        found[name] = row
    return LearntRows(found)


def _fault(registry: Registry, name: str, row: LearntRow) -> str:
    """Return why a row is none of a program as it is declared; empty where it is."""
    program = registry.programs[name]
    if row.program != name or row.of != declaration_of(registry, name, row.preference):
        return f"was learnt of another declaration of '{name}', or of what it calls"
    function = function_of(registry, name)
    if row.function and function and row.function != function:
        return f"was learnt of another text of the function '{name}'"
    if bool(row.calls) != program.in_python or not fits(registry, program, row.calls):
        return f"has calls that '{name}' cannot make"
    return ""
