"""From a file or a folder to a registry: finds the text, and the libraries that it uses."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from ntp_dsl.language import syntax
from ntp_dsl.language.checker import check, examine
from ntp_dsl.language.diagnostics import Diagnostic, NtpError, SourceError, unknown
from ntp_dsl.language.parser import parse
from ntp_dsl.registry import Registry
from ntp_dsl.resources import examples_folder, library_folder

SUFFIX = ".ntp"
USE = re.compile(r"use[ \t]+([A-Za-z_][A-Za-z0-9_]*)")


def load(path_or_folder: Path | str) -> Registry:
    """Parse and check a library and all that it uses.

    Args:
        path_or_folder: an `.ntp` file, a folder that holds one, or the name of an example or of a
            standard library.
    """
    libraries, sources = read_all(find(path_or_folder))
    return check(*libraries, sources=sources)


@dataclass(frozen=True)
class Report:
    """All that is to be said of a library and of those it uses, in the order of their texts."""

    diagnostics: tuple[Diagnostic, ...]
    sources: Mapping[Path | None, str]  # every text that was read, by its path

    @property
    def is_sound(self) -> bool:
        return not any(each.severity == "error" for each in self.diagnostics)


def diagnose(path: Path) -> Report:
    """Every mistake of form and meaning, in the file and in all that it uses."""
    try:
        libraries, sources = read_all(path)
    except SourceError as error:
        return Report(error.diagnostics, error.sources)
    _, mistakes = examine(*libraries)
    return Report(SourceError(mistakes).diagnostics, sources)


def find(path_or_folder: Path | str) -> Path:
    """The file that is meant; `NtpError` says what was looked for where there is none."""
    given = Path(path_or_folder)
    is_bare = len(given.parts) == 1 and not given.suffix
    if is_bare and not given.exists():
        named = [examples_folder() / given, library_folder() / f"{given}{SUFFIX}"]
        given = next((path for path in named if path.exists()), given)
    if given.is_dir():
        return _only_library(given)
    if not given.exists():
        known = ", ".join(
            sorted(path.parent.name for path in examples_folder().glob(f"*/*{SUFFIX}"))
        )
        hint = f"; the examples are: {known}" if is_bare and known else ""
        raise NtpError(f"there is no library at '{path_or_folder}'{hint}")
    return given


def _only_library(folder: Path) -> Path:
    found = sorted(folder.glob(f"*{SUFFIX}"))
    if len(found) == 1:
        return found[0]
    if not found:
        raise NtpError(f"the folder '{folder}' holds no {SUFFIX} file")
    # A folder that carries its own helper libraries still has one that is named after it.
    eponymous = folder / f"{folder.resolve().name}{SUFFIX}"
    if eponymous in found:
        return eponymous
    listing = ", ".join(path.name for path in found)
    raise NtpError(f"the folder '{folder}' holds several libraries ({listing}); name one of them")


def read(path: Path) -> str:
    """The text of a file; `NtpError` where it cannot be read or is not text."""
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise NtpError(f"'{path}' is not a text file (byte {error.start} is not UTF-8)") from error
    except OSError as error:
        raise NtpError(f"'{path}' cannot be read: {error.strerror or error}") from error
    if "\0" in text:
        raise NtpError(f"'{path}' is not a text file (it contains zero bytes)")
    return text


def read_all(path: Path) -> tuple[list[syntax.Library], dict[Path | None, str]]:
    """The library, then all that it uses, each once; all their syntax errors come together."""
    reading = _Reading()
    reading.visit(path, ())
    if reading.mistakes:
        raise SourceError(reading.mistakes, reading.sources)
    return list(reading.libraries.values()), reading.sources


class _Reading:
    """One walk along `use`, which collects libraries, texts and mistakes."""

    def __init__(self) -> None:
        self.libraries: dict[Path, syntax.Library] = {}
        self.sources: dict[Path | None, str] = {}
        self.mistakes: list[Diagnostic] = []

    def visit(self, path: Path, above: tuple[Path, ...]) -> None:
        text = read(path)
        self.sources[path] = text.replace("\r\n", "\n").replace("\r", "\n")
        try:
            library = parse(text, path)
        except SourceError as error:
            self.mistakes += error.diagnostics
            uses = _uses(self.sources[path], path)
        else:
            self.libraries[path] = library
            uses = library.uses
        for use in uses:
            self._follow(use, path, (*above, path))

    def _follow(self, use: syntax.Use, path: Path, above: tuple[Path, ...]) -> None:
        target = next((each for each in _places(use.library, path) if each.is_file()), None)
        if target is None:
            known = [each.stem for each in _neighbours(path)]
            self.mistakes.append(
                unknown("E110", "there is no library", use.library, use.span, known)
            )
        elif target.resolve() in [each.resolve() for each in above]:
            names = " -> ".join([each.stem for each in above] + [target.stem])
            message = f"libraries use one another in a circle: {names}"
            self.mistakes.append(Diagnostic("E304", message, use.span))
        elif target not in self.sources:
            self.visit(target, above)


def _uses(text: str, path: Path) -> tuple[syntax.Use, ...]:
    """What a text uses that does not parse, so that those libraries are read as well."""
    uses = []
    for line, row in enumerate(text.split("\n"), start=1):
        if match := USE.match(row):
            span = syntax.Span(path, line, match.start(1) + 1, line, match.end(1) + 1)
            uses.append(syntax.Use(match.group(1), span=span))
    return tuple(uses)


def _places(name: str, path: Path) -> Iterator[Path]:
    for folder in (path.parent, library_folder()):
        yield folder / f"{name}{SUFFIX}"


def _neighbours(path: Path) -> Iterator[Path]:
    for folder in (path.parent, library_folder()):
        yield from (each for each in folder.glob(f"*{SUFFIX}") if each != path)
