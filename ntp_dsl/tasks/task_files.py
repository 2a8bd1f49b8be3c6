"""Files of tasks: things and goals from outside, in our JSON or as the paper's authors wrote them.

Ours is `{"format": "ntp-tasks", "version": 1, "task": NAME or null, "tasks": [TASK...]}`, where a
TASK is `{"id", "things": [{"name", "type", "size"}...], "goal": [{"item", "support"}...]}`, the
goal in the order in which a demonstration is to show it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from math import inf
from pathlib import Path
from typing import Any, TypeVar

from ntp_dsl.common.files import written_whole
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import Thing, Vector

T = TypeVar("T")
FORMAT = "ntp-tasks"
VERSION = 1
EXPECTED = f"a file of tasks ('{FORMAT}', or the authors' 'stacking')"
AUTHORS_STACKING = "stacking"  # what the authors call the scene of their block-stacking tasks
AUTHORS_PLACEMENT = "pick_place"
AUTHORS_TYPES = {"cubes": "Block"}  # a model's folder -> its type in the standard library


@dataclass(frozen=True)
class TaskFileEntry:
    """One task of a file: what is in its scene, and which item goes on which support, in order."""

    id: str
    things: tuple[Thing, ...]
    goal: tuple[tuple[str, str], ...]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(thing.name for thing in self.things)


class Unexpected(Exception):
    """Something in a file is not what it should be; where it is, is added on the way up."""


def read_tasks(path: Path) -> list[TaskFileEntry]:
    """Both formats; `NtpError` says what was expected and what was found in anything else."""
    data = _read_json(path)
    try:
        return _entries(data)
    except Unexpected as error:
        raise NtpError(f"{path}: {error}") from error


def write_tasks(entries: Sequence[TaskFileEntry], path: Path) -> None:
    """In our own format, whole or not at all."""
    with written_whole(path) as partial:
        partial.write_text(json.dumps(to_json(entries), indent=1) + "\n", encoding="utf-8")


def to_json(entries: Sequence[TaskFileEntry]) -> dict[str, Any]:
    tasks = [
        {
            "id": entry.id,
            "things": [asdict(thing) for thing in entry.things],
            "goal": [{"item": item, "support": support} for item, support in entry.goal],
        }
        for entry in entries
    ]
    return {"format": FORMAT, "version": VERSION, "task": None, "tasks": tasks}


def _read_json(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise NtpError(f"{path}: cannot be read: {error.strerror or error}") from error
    except json.JSONDecodeError as error:
        found = f"something that breaks off or goes wrong at line {error.lineno}: {error.msg}"
        raise NtpError(f"{path}: expected {EXPECTED} in JSON, found {found}") from error
    except (UnicodeDecodeError, RecursionError) as error:
        raise NtpError(f"{path}: expected {EXPECTED} in JSON, found no JSON text") from error


def _entries(data: Any) -> list[TaskFileEntry]:
    if not isinstance(data, dict):
        raise Unexpected(f"expected {EXPECTED}, found {_shown(data)}")
    if data.get("format") == FORMAT:
        return _ours(data)
    if {"name", "scene", "tasks"} <= data.keys():
        return _authors(data)
    found = ", ".join(f"'{key}'" for key in list(data)[:6]) or "nothing"
    raise Unexpected(f"expected {EXPECTED}, found an object of {found}")


# Our own format ---------------------------------------------------------------------------------


def _ours(data: dict[str, Any]) -> list[TaskFileEntry]:
    if data.get("version") != VERSION:
        raise Unexpected(f"expected version {VERSION}, found {_shown(data.get('version'))}")
    return _each(data, "tasks", _our_task)


def _our_task(task: dict[str, Any]) -> TaskFileEntry:
    things = tuple(_each(task, "things", _our_thing))
    goal = _each(task, "goal", lambda p: (_text(p, "item"), _text(p, "support")))
    return _sound(TaskFileEntry(_text(task, "id"), things, tuple(goal)))


def _our_thing(thing: dict[str, Any]) -> Thing:
    return Thing(_text(thing, "name"), _text(thing, "type"), _size(thing, "size"))


# The authors' -----------------------------------------------------------------------------------


def _authors(data: dict[str, Any]) -> list[TaskFileEntry]:
    if data["name"] != AUTHORS_STACKING:
        raise Unexpected(f"expected tasks of '{AUTHORS_STACKING}', found {_shown(data['name'])}")
    if not isinstance(data["scene"], dict):
        raise Unexpected(f"expected an object at 'scene', found {_shown(data['scene'])}")
    things = tuple(_each(data["scene"], "objects", _authors_thing))

    def task(row: dict[str, Any]) -> TaskFileEntry:
        goal = tuple(_each(row, "goals", _authors_placement))
        return _sound(TaskFileEntry(_text(row, "id"), things, goal))

    return _each(data, "tasks", task)


def _authors_thing(thing: dict[str, Any]) -> Thing:
    model = _text(thing, "filename").split("/")[0]
    if model not in AUTHORS_TYPES:
        raise Unexpected(f"expected a model of {', '.join(AUTHORS_TYPES)}, found '{model}'")
    return Thing(_text(thing, "name"), AUTHORS_TYPES[model], _size(thing, "scale"))


def _authors_placement(goal: dict[str, Any]) -> tuple[str, str]:
    if goal.get("name") != AUTHORS_PLACEMENT:
        found = _shown(goal.get("name"))
        raise Unexpected(f"expected a goal '{AUTHORS_PLACEMENT}', found {found}")
    return _text(goal, "src"), _text(goal, "target")


# Pieces of either -------------------------------------------------------------------------------


def _sound(entry: TaskFileEntry) -> TaskFileEntry:
    if len(set(entry.names)) < len(entry.names):
        raise Unexpected("expected things of different names, found one name twice")
    for item, support in entry.goal:
        unknown = [name for name in (item, support) if name not in entry.names]
        if unknown:
            known = ", ".join(entry.names)
            raise Unexpected(f"expected a goal over {known}; found '{unknown[0]}'")
        if item == support:
            raise Unexpected(f"expected an item and its support, found '{item}' on itself")
    return entry


def _each(data: dict[str, Any], key: str, read: Callable[[dict[str, Any]], T]) -> list[T]:
    rows = data.get(key)
    if not isinstance(rows, list) or not rows:
        raise Unexpected(f"expected a list that is not empty at '{key}', found {_shown(rows)}")
    found = []
    for number, row in enumerate(rows):
        try:
            if not isinstance(row, dict):
                raise Unexpected(f"expected an object, found {_shown(row)}")
            found.append(read(row))
        except Unexpected as error:
            raise Unexpected(f"{key}[{number}]: {error}") from error
    return found


def _text(data: dict[str, Any], key: str) -> str:
    if not isinstance(data.get(key), str):
        raise Unexpected(f"expected a text at '{key}', found {_shown(data.get(key))}")
    return str(data[key])


def _size(data: dict[str, Any], key: str) -> Vector:
    match data.get(key):
        case [x, y, z] if all(type(side) in (int, float) and 0 < side < inf for side in (x, y, z)):
            return float(x), float(y), float(z)
    found = _shown(data.get(key))
    raise Unexpected(f"expected three positive numbers of metres at '{key}', found {found}")


def _shown(value: Any) -> str:
    text = "nothing" if value is None else json.dumps(value)
    return text if len(text) <= 40 else f"{text[:40]}..."
