"""From declarations `by python` to the functions of the file beside the library.

Nothing is imported until a world is to run the library: `ntp check` reads declarations only.
"""

from __future__ import annotations

import inspect
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import wraps
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

from ntp_dsl.authoring import MARK
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import load
from ntp_dsl.language.registry import PythonCode, Registry, place_of
from ntp_dsl.language.syntax.nodes import PYTHON, Span
from ntp_dsl.user_code.return_checks import Test, answer_test

DECORATORS = "@expert, @predicate, @skill or @sampler"
LONGEST = 80  # of an answer in a message


def load_with_python(path_or_folder: Path | str) -> Registry:
    """Load a library, with the functions that it and the libraries it uses leave to Python.

    Raises `NtpError` for a file or function that is missing, or that cannot be imported.
    """
    return with_python(load(path_or_folder))


def with_python(registry: Registry) -> Registry:
    """Return the registry with its functions in Python."""
    code = PythonCode()
    modules: dict[Path, ModuleType] = {}
    for kind, name, span, takes in needed(registry):
        assert span.path is not None, "a library that is left to Python comes from a file"
        path = span.path.with_suffix(".py")
        if path not in modules:
            modules[path] = _imported(path, kind, name, span)
        function = _find(modules[path], path, kind, name, span)
        _check_takes(function, takes, path, name)
        code.functions[kind, name] = _guarded(function, path, name, answer_test(registry, kind, name))
    return replace(registry, python=code)


def with_functions(registry: Registry, functions: Iterable[Callable[..., Any]]) -> Registry:
    """Return the registry with marked functions that are there already, in place of a file's.

    Raises `NtpError` for a function that the library leaves to Python and that is not among them, and for
    one among them that it does not leave to Python.
    """
    marked = _by_mark(functions)
    code = PythonCode()
    for kind, name, span, takes in needed(registry):
        function = marked.pop((kind, name), None)
        if function is None:
            raise NtpError(f"{span}: no {kind} '{name}' was given; write @{kind} above: def {name}(...)")
        path = _source(function, name)
        _check_takes(function, takes, path, name)
        code.functions[kind, name] = _guarded(function, path, name, answer_test(registry, kind, name))
    _check_no_others(registry, marked)
    return replace(registry, python=code)


Marked = dict[tuple[str, str], Callable[..., Any]]


def _by_mark(functions: Iterable[Callable[..., Any]]) -> Marked:
    """Return functions by kind and name. Raises `NtpError` for two of one name."""
    if isinstance(functions, str) or not isinstance(functions, Iterable):
        raise NtpError(f"expected a list of functions: functions=[spin]; found {functions!r}")
    marked: Marked = {}
    for function in functions:
        kind, name = _mark_of(function)
        if (kind, name) in marked:
            raise NtpError(f"two functions were given for the {kind} '{name}'; give one")
        marked[kind, name] = function
    return marked


def _mark_of(function: Callable[..., Any]) -> tuple[str, str]:
    """Return what a function is marked as. Raises `NtpError` for what is not marked."""
    mark: tuple[str, str] | None = getattr(function, MARK, None)
    if mark is None:
        raise NtpError(
            f"expected a function marked with {DECORATORS}; found {function!r}: mark it, or omit it"
        )
    return mark


def _check_no_others(registry: Registry, others: Marked) -> None:
    """Raise `NtpError` where functions are left over that the library does not ask for."""
    for kind, name in others:
        asked = ", ".join(f"{kind} '{name}'" for kind, name, _, _ in needed(registry)) or "nothing"
        raise NtpError(
            f"the {kind} '{name}' was given, and library '{registry.name}' leaves {asked} to Python; "
            "declare it `by python`, or omit it"
        )


def _source(function: Callable[..., Any], name: str) -> Path:
    """Return the file of a function, or its name for an object that is called like one."""
    try:
        return Path(inspect.getsourcefile(inspect.unwrap(function)) or name)
    except TypeError:
        return Path(name)


Needed = tuple[str, str, Span, tuple[str, ...] | None]


def needed(registry: Registry) -> Iterator[Needed]:
    """Yield the functions left to Python: kind, name, the declaration's place, and the arguments."""
    for row in registry.programs.values():
        if row.in_python:
            names = (parameter.name for parameter in row.parameters)
            yield "expert", row.name, row.span, ("world", *names)
    for api in registry.apis.values():
        if api.skill == PYTHON:
            yield "skill", api.name, api.span, ("world", *(p.name for p in api.parameters))
    for declared in registry.predicates.values():
        if declared.by is not None and declared.by.id == PYTHON:
            names = (parameter.name for parameter in declared.parameters)
            yield "predicate", declared.name, declared.name_span, ("observation", *names)
    for task in registry.tasks.values():
        if task.sampler is not None and task.sampler.by is not None:
            yield "sampler", task.sampler.name, task.sampler.span, None


def _imported(path: Path, kind: str, name: str, span: Span) -> ModuleType:
    if not path.is_file():
        raise NtpError(f"{span}: the {kind} '{name}' is left to Python, and there is no file '{path}'")
    spec = spec_from_file_location(f"ntp_dsl_library_{path.stem}", path)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    # Bytecode beside a user's library would be litter, and a stale one a riddle.
    keep, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise NtpError(f"{_place(error, path)}: the file cannot be imported: {_said(error)}") from error
    finally:
        sys.dont_write_bytecode = keep
    return module


def _find(module: ModuleType, path: Path, kind: str, name: str, span: Span) -> Callable[..., Any]:
    for value in vars(module).values():
        if getattr(value, MARK, None) == (kind, name):
            return value  # type: ignore[no-any-return]
    raise NtpError(f"{span}: '{path}' has no {kind} '{name}'; write @{kind} above: def {name}(...)")


def _check_takes(function: Callable[..., Any], takes: tuple[str, ...] | None, path: Path, name: str) -> None:
    if takes is None:
        return
    try:
        inspect.signature(function).bind(*takes)
    except TypeError as error:
        raise NtpError(f"{path}: '{name}' is called as {name}({', '.join(takes)}): {error}") from error


class PythonFault(NtpError):
    """A function of a user's file failed, or returned what its kind may not; has the place.

    `name` is what it is declared as.
    """

    def __init__(self, place: str, name: str, message: str) -> None:
        self.name = name
        super().__init__(f"{place}: '{name}' {message}")


def _guarded(function: Callable[..., Any], path: Path, name: str, test: Test) -> Callable[..., Any]:
    """Return the function, with errors as one sentence that gives their place."""

    @wraps(function)
    def guarded(*arguments: Any, **parameters: Any) -> Any:
        try:
            answer = function(*arguments, **parameters)
            answer = _plain(answer)
        except PythonFault:
            raise
        except Exception as error:
            raise PythonFault(_place(error, path), name, f"failed: {_said(error)}") from error
        if expected := test(answer):
            raise PythonFault(place_of(function), name, f"answered {_brief(answer)}; expected {expected}")
        return answer

    return guarded


def _plain(answer: Any) -> Any:
    from ntp_dsl.semantics.value_checks import plain  # which needs numpy: loading a library does not

    return list(answer) if isinstance(answer, Iterator) else plain(answer)


def _brief(answer: Any) -> str:
    text = repr(answer)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


def _place(error: Exception, path: Path) -> str:
    """Return the innermost line of the user's file in the error's traceback."""
    if isinstance(error, SyntaxError) and error.lineno:
        return f"{path}:{error.lineno}"
    here = path.resolve()
    lines = [frame.lineno for frame in _frames(error) if Path(frame.filename).resolve() == here]
    return f"{path}:{lines[-1]}" if lines else str(path)


def _frames(error: Exception) -> Iterable[traceback.FrameSummary]:
    return traceback.extract_tb(error.__traceback__)


def _said(error: Exception) -> str:
    if isinstance(error, NtpError):
        return str(error)
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
