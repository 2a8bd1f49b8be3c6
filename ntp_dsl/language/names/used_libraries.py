"""From a path to units: a library and all that it uses, found beside it or among the standard libraries."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from ntp_dsl.common.resources import library_folder
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, NtpError
from ntp_dsl.language.names.unknown_names import names_in, standard_names
from ntp_dsl.language.names.use_statements import circular_use, unknown_library
from ntp_dsl.language.names.visibility import Unit
from ntp_dsl.language.parsing import parser
from ntp_dsl.language.parsing.partial_library import Key, PartialLibrary
from ntp_dsl.language.syntax.nodes import Use

SUFFIX = ".ntp"

ReadLibrary = Callable[[str, Path | None], PartialLibrary]


def read(path: Path) -> str:
    """Return the text of a file; `NtpError` where it cannot be read or is not text."""
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
    """One walk along `use`: the libraries that were read, their texts, and what is wrong with them.

    Args:
        path: of the library; None for a text that is in no file, which uses standard libraries alone.
        texts: in place of what is on the disk.
        read_library: what to call in place of the parser, such as a function with a cache.
    """

    def __init__(
        self,
        path: Path | None,
        texts: Mapping[Path | None, str],
        read_library: ReadLibrary = parser.read,
    ) -> None:
        self._texts = texts
        self._read_library = read_library
        self.sources: dict[Path | None, str] = {}
        self.diagnostics: list[Diagnostic] = []
        self._libraries: dict[Path | None, PartialLibrary] = {}
        self._uses: dict[Path | None, list[Path | None]] = {}  # None stands for one that is not there
        self._visit(path, ())

    def units(self) -> list[Unit]:
        """Return the library that was asked for, then all that it uses."""
        number = {path: index for index, path in enumerate(self._libraries)}
        return [
            Unit(partial, tuple(None if used is None else number[used] for used in self._uses[path]))
            for path, partial in self._libraries.items()
        ]

    def _visit(self, path: Path | None, above: tuple[Path | None, ...]) -> None:
        text = self._texts[path] if path is None or path in self._texts else read(path)
        self.sources[path] = parser.lines(text)
        self._libraries[path] = partial = self._read_library(text, path)
        self.diagnostics += partial.diagnostics
        self._uses[path] = [self._follow(use, path, (*above, path)) for use in partial.library.uses]

    def _follow(self, use: Use, path: Path | None, above: tuple[Path | None, ...]) -> Path | None:
        target = _find_used(use.library, path)
        if target is None:
            wrong = unknown_library(use, [each.stem for each in _neighbours(path)])
            self.diagnostics.append(wrong)
            target = _find_used(wrong.fix.replacement, path) if wrong.fix else None
        if target is None:
            return None
        files = [each for each in above if each is not None]
        entered = [each.resolve() for each in files]
        if target.resolve() in entered:
            way = files[entered.index(target.resolve()) :]
            self.diagnostics.append(circular_use(use, [*(each.stem for each in way), target.stem]))
            return way[0]
        if target not in self._libraries:
            self._visit(target, above)
        return target


def available_names(path: Path | None) -> Mapping[Key, str]:
    """Return which library that a file could use declares a name; the standard ones come first."""
    return {**names_in(sorted(_neighbours(path))), **standard_names()}


def _find_used(name: str, path: Path | None) -> Path | None:
    places = (folder / f"{name}{SUFFIX}" for folder in _folders(path))
    return next((each for each in places if _is_there(each)), None)


def _is_there(path: Path) -> bool:
    """Return whether there is a file of exactly that name, on systems that ignore case too."""
    return path.is_file() and path.name in {each.name for each in path.parent.iterdir()}


def _neighbours(path: Path | None) -> Iterator[Path]:
    for folder in _folders(path):
        yield from (each for each in folder.glob(f"*{SUFFIX}") if each != path)


def _folders(path: Path | None) -> list[Path]:
    return [library_folder()] if path is None else [path.parent, library_folder()]
