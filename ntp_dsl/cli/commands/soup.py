"""`ntp soup`: random sound libraries, one a seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from ntp_dsl.cli.display import messages, print_json, progress
from ntp_dsl.cli.options import Json, Seed, Workers
from ntp_dsl.common.files import written_whole
from ntp_dsl.common.text import counted
from ntp_dsl.common.workers import in_order
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, NtpError
from ntp_dsl.language.loader import SUFFIX, diagnose
from ntp_dsl.soup import library_name, random_library


@dataclass(frozen=True)
class Row:
    """A library that was written, and what a check says about it; None where it was not checked."""

    path: Path
    errors: tuple[str, ...] | None = None


def command(
    out: Annotated[Path, typer.Option(help="Folder to write.")] = Path("runs/soup"),
    count: Annotated[int, typer.Option("-n", "--count", min=1, help="Number of libraries.")] = 10,
    seed: Seed = 0,
    check: Annotated[
        bool, typer.Option("--check", help="Check each one as `ntp check` does, by simulation too.")
    ] = False,
    workers: Workers = 1,
    json: Json = False,
) -> int:
    """Write random sound libraries, to train on and to test with.

    Library soup_S is a function of the seed S alone; --seed is the first one's. Each has types, records,
    predicates, programs and tasks of its own over the kinds of scenes that both worlds can make, needs no
    Python, and is in canonical layout. A file that exists is kept where it is the same; another text under
    its name is misuse. Exit status: 0 done, 1 with --check a library is not sound.

    Example: ntp soup --count 20 --seed 7 --out runs/soup
    """
    for number in range(seed, seed + count):
        _check_free(_path(out, number), number)
    rows = []
    with progress("writing", count) as bar:
        for row in in_order(partial(_writer, out, seed, check), count, workers):
            rows.append(row)
            for error in row.errors or ():
                messages.print(f"{row.path}: {error}")
            bar.advance()
    unsound = [row for row in rows if row.errors]
    if json:
        print_json(_document(rows, seed, out, check))
    else:
        judged = f", {count - len(unsound)} of them sound" if check else ""
        messages.print(f"{counted(count, 'file')} in {out}{judged}")
    return int(bool(unsound))


def _path(out: Path, seed: int) -> Path:
    return out / f"{library_name(seed)}{SUFFIX}"


def _check_free(path: Path, seed: int) -> None:
    """Raise `NtpError` where another text has the name of a library that is to be written."""
    if path.exists() and path.read_bytes() != random_library(seed).encode():
        raise NtpError(f"{path} exists and is another text; choose an empty folder with --out")


def _writer(out: Path, seed: int, check: bool) -> Callable[[int], Row]:
    return partial(_write, out, seed, check)


def _write(out: Path, seed: int, check: bool, number: int) -> Row:
    path = _path(out, seed + number)
    if not path.exists():
        with written_whole(path) as unfinished:
            unfinished.write_bytes(random_library(seed + number).encode())
    return Row(path, _errors(path) if check else None)


def _errors(path: Path) -> tuple[str, ...]:
    """Return the errors of a library, of its text or else of its simulation."""
    from ntp_dsl.dynamic.check import check_dynamically

    report = diagnose(path)
    found: list[Diagnostic] = [each for each in report.diagnostics if each.severity == "error"]
    if not found:
        found = [each for each in check_dynamically(report.checked(), path) if each.severity == "error"]
    return tuple(f"{each.code}: {each.message}" for each in found)


def _document(rows: list[Row], seed: int, out: Path, check: bool) -> dict[str, Any]:
    libraries = [{"path": str(row.path), "errors": row.errors} for row in rows]
    sound = sum(not row.errors for row in rows) if check else None
    return {"out": str(out), "count": len(rows), "seed": seed, "sound": sound, "libraries": libraries}
