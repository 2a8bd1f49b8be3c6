"""From a file or a folder to a registry: finds the text, and the libraries that it uses."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ntp_dsl.common.resources import examples_folder, library_folder
from ntp_dsl.language.checker import check
from ntp_dsl.language.checks.check_library import examine
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, NtpError, SourceError
from ntp_dsl.language.diagnostics.rendering import plain, render
from ntp_dsl.language.names.unknown_names import names_in, standard_names
from ntp_dsl.language.names.use_statements import circle, unknown_library
from ntp_dsl.language.names.visibility import Unit
from ntp_dsl.language.parsing.parser import lines
from ntp_dsl.language.parsing.parser import read as read_draft
from ntp_dsl.language.parsing.partial_library import Draft, Key
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax import nodes

SUFFIX = ".ntp"


def load(path_or_folder: Path | str) -> Registry:
    """Parse and check a library and all that it uses.

    Args:
        path_or_folder: an `.ntp` file, a folder that holds one, or the name of an example or of a
            standard library.
    """
    return _load(find(path_or_folder), {})


def load_text(text: str, name: str = "text") -> Registry:
    """Load a library from a string; what it uses comes from the folder at hand and the standard library.

    Args:
        name: in place of a file's, in diagnostics.

    Raises `SourceError`, which carries every diagnostic, where it is not sound.
    """
    path = Path(f"{name}{SUFFIX}")
    return _load(path, {path: text})


def _load(path: Path, texts: Mapping[Path, str]) -> Registry:
    with _uncollected():
        reading = Reading(path, texts)
    if reading.mistakes:
        report = _diagnose(path, texts)
        raise SourceError(report.diagnostics, report.sources)
    libraries = [unit.draft.whole() for unit in reading.units()]
    return check(*libraries, sources=reading.sources)


@dataclass(frozen=True, repr=False)
class Report:
    """All that is to be said of a library and of those it uses, in the order of their texts."""

    diagnostics: tuple[Diagnostic, ...]
    sources: Mapping[Path | None, str]  # every text that was read, by its path

    @property
    def is_sound(self) -> bool:
        return not any(each.severity == "error" for each in self.diagnostics)

    def __repr__(self) -> str:
        """Return the diagnostics as the terminal shows them, without its colours."""
        if not self.diagnostics:
            return "<Report: nothing to say>"
        return "\n".join(plain(render(each, self.sources)) for each in self.diagnostics)


def diagnose(path: Path) -> Report:
    """Return every mistake of form and meaning, in the file and in all that it uses."""
    return _diagnose(path, {})


def diagnose_text(text: str, name: str = "text") -> Report:
    """Return every mistake of form and meaning in a string; see `load_text`."""
    path = Path(f"{name}{SUFFIX}")
    return _diagnose(path, {path: text})


def _diagnose(path: Path, texts: Mapping[Path, str]) -> Report:
    with _uncollected():
        reading = Reading(path, texts)
        found = examine(reading.units(), lambda: shelf(path))
    return Report(SourceError([*reading.mistakes, *found]).diagnostics, reading.sources)


@contextmanager
def _uncollected() -> Iterator[None]:
    """Reading makes many things and drops few: to look for garbage meanwhile takes a third of the time."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


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
        known = ", ".join(sorted(path.parent.name for path in examples_folder().glob(f"*/*{SUFFIX}")))
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


class Reading:
    """One walk along `use`, which collects drafts, texts and mistakes."""

    def __init__(
        self,
        path: Path,
        texts: Mapping[Path, str] | None = None,
        read_draft: Callable[[str, Path | None], Draft] = read_draft,
    ) -> None:
        self._texts = texts or {}
        self._read_draft = read_draft
        self.sources: dict[Path | None, str] = {}
        self.mistakes: list[Diagnostic] = []
        self._drafts: dict[Path, Draft] = {}
        self._uses: dict[Path, list[Path | None]] = {}
        self._visit(path, ())

    def units(self) -> list[Unit]:
        """The library that was asked for, then all that it uses."""
        number = {path: index for index, path in enumerate(self._drafts)}
        return [
            Unit(draft, tuple(None if used is None else number[used] for used in self._uses[path]))
            for path, draft in self._drafts.items()
        ]

    def _visit(self, path: Path, above: tuple[Path, ...]) -> None:
        text = self._texts[path] if path in self._texts else read(path)
        self.sources[path] = lines(text)
        self._drafts[path] = draft = self._read_draft(text, path)
        self.mistakes += draft.mistakes
        self._uses[path] = [self._follow(use, path, (*above, path)) for use in draft.uses]

    def _follow(self, use: nodes.Use, path: Path, above: tuple[Path, ...]) -> Path | None:
        target = _find_used(use.library, path)
        if target is None:
            mistake = unknown_library(use, [each.stem for each in _neighbours(path)])
            self.mistakes.append(mistake)
            target = _find_used(mistake.fix.replacement, path) if mistake.fix else None
        if target is None:
            return None
        entered = [each.resolve() for each in above]
        if target.resolve() in entered:
            way = above[entered.index(target.resolve()) :]
            self.mistakes.append(circle(use, [*(each.stem for each in way), target.stem]))
            return way[0]
        if target not in self._drafts:
            self._visit(target, above)
        return target


def _find_used(name: str, path: Path) -> Path | None:
    return next((each for each in _places(name, path) if _is_there(each)), None)


def _is_there(path: Path) -> bool:
    """Whether there is such a file, spelt so: where case does not count, it counts here."""
    return path.is_file() and path.name in {each.name for each in path.parent.iterdir()}


def shelf(path: Path) -> Mapping[Key, str]:
    """Which library that a file could use declares a name."""
    return {**standard_names(), **names_in(sorted(_neighbours(path)))}


def _places(name: str, path: Path) -> Iterator[Path]:
    for folder in (path.parent, library_folder()):
        yield folder / f"{name}{SUFFIX}"


def _neighbours(path: Path) -> Iterator[Path]:
    for folder in (path.parent, library_folder()):
        yield from (each for each in folder.glob(f"*{SUFFIX}") if each != path)
