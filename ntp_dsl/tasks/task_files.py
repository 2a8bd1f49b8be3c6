"""Files of tasks: objects and goals from outside, in our JSON or as the paper's authors wrote them.

Ours is `{"format": "ntp-tasks", "version": 2, "tasks": [TASK...]}`, where a TASK is
`{"id", "objects": [OBJECT...], "goal": [{"item", "support"}...]}`. An OBJECT has a `name`, a `type` and a
`size` [m], and if need be a `shape`, `file`, `fixed` and `traits`; an element of the goal has the fields of
the record that the task's program takes. Their order is that of a demonstration.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta, Struct

from ntp_dsl.common.decoding import Unreadable, decode, decoding
from ntp_dsl.common.files import written_whole
from ntp_dsl.common.text import printable
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import SceneObject
from ntp_dsl.tasks.authors_files import AUTHORS_SCENE, AuthorsFile

FORMAT = "ntp-tasks"
VERSION = 2
EXPECTED = f"a file of tasks ('{FORMAT}', or the authors' '{AUTHORS_SCENE}')"

MIN_SIDE, MAX_SIDE = 1e-4, 100.0  # of an object [m]

GoalRow = Mapping[str, str | float]  # of a record: field -> object, member or number [SI]


class TaskFileEntry(Struct, frozen=True, omit_defaults=True):
    """One task of a file: the objects of its scene, and its goal, in order."""

    id: str
    objects: Annotated[tuple[SceneObject, ...], Meta(min_length=1)]
    goal: Annotated[tuple[dict[str, str | float], ...], Meta(min_length=1)]

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the objects."""
        return tuple(each.name for each in self.objects)


class TaskFile(Struct, frozen=True):
    """A whole file."""

    format: str
    version: int
    tasks: Annotated[tuple[TaskFileEntry, ...], Meta(min_length=1)]


def read_tasks(path: Path) -> list[TaskFileEntry]:
    """Read a file of either format. Raises `NtpError`, with what was expected and found, for any other."""
    data = _read_json(path)
    try:
        with decoding():
            entries = _entries(data)
            for number, entry in enumerate(entries):
                _check(entry, number)
            return entries
    except Unreadable as error:
        raise NtpError(f"{path}: {error}") from error


def write_tasks(entries: Sequence[TaskFileEntry], path: Path) -> None:
    """Write a file of our own format, whole or not at all."""
    with written_whole(path) as partial:
        partial.write_bytes(msgspec.json.format(msgspec.json.encode(as_file(entries)), indent=1) + b"\n")


def as_file(entries: Sequence[TaskFileEntry]) -> TaskFile:
    """Return tasks as a file of our own format."""
    return TaskFile(FORMAT, VERSION, tuple(entries))


def _read_json(path: Path) -> Any:
    try:
        return decode(path.read_bytes(), Any)
    except OSError as error:
        raise NtpError(f"{path}: cannot be read: {error.strerror or error}") from error
    except Unreadable as error:
        raise NtpError(f"{path}: expected {EXPECTED} in JSON, found something else: {error}") from error


def _entries(data: Any) -> list[TaskFileEntry]:
    if not isinstance(data, dict):
        raise Unreadable(f"expected {EXPECTED}, found {_shown(data)}")
    if data.get("format") == FORMAT:
        version = data.get("version")
        if type(version) is not int or not 1 <= version <= VERSION:
            raise Unreadable(f"expected version {VERSION}, found {_shown(version)}")
        data = data if version == VERSION else _upgraded(data)
        return list(msgspec.convert(data, TaskFile).tasks)
    if {"name", "scene", "tasks"} <= data.keys():
        if data["name"] != AUTHORS_SCENE:
            raise Unreadable(f"expected tasks of '{AUTHORS_SCENE}', found {_shown(data['name'])}")
        authors = msgspec.convert(data, AuthorsFile)
        objects = authors.scene.as_ours()
        return [TaskFileEntry(task.id, objects, task.goal()) for task in authors.tasks]
    found = ", ".join(f"'{key}'" for key in list(data)[:6]) or "nothing"
    raise Unreadable(f"expected {EXPECTED}, found an object of {found}")


def _upgraded(data: dict[str, Any]) -> dict[str, Any]:
    """Return a file of the first version, which called objects things, in the present one."""
    tasks = data.get("tasks")
    if not isinstance(tasks, list):
        return {**data, "version": VERSION}
    renamed = [
        {("objects" if name == "things" else name): value for name, value in each.items()}
        if isinstance(each, dict)
        else each
        for each in tasks
    ]
    return {**data, "version": VERSION, "tasks": renamed}


def _check(entry: TaskFileEntry, number: int) -> None:
    """Raise `Unreadable` for impossible objects, and for a goal over unknown ones."""
    where = f"tasks[{number}] ('{printable(entry.id)}')"
    if len(set(entry.names)) < len(entry.names):
        raise Unreadable(f"{where}: expected objects of different names, found one name twice")
    for each in entry.objects:
        if not (each.name.isprintable() and each.name.strip()):
            raise Unreadable(f"{where}: expected a printable name, found {each.name!r}")
        if not all(MIN_SIDE <= side <= MAX_SIDE for side in each.size):
            raise Unreadable(
                f"{where}: expected three positive sizes of '{each.name}' from {MIN_SIDE:g} to "
                f"{MAX_SIDE:g} m, found {each.size}"
            )
    for row in entry.goal:
        values = [value for value in row.values() if value in entry.names]
        if len(set(values)) < len(values):
            raise Unreadable(f"{where}: expected different objects in one row, found {_shown(row)}")


def _shown(value: Any) -> str:
    text = "nothing" if value is None else msgspec.json.encode(value).decode()
    return text if len(text) <= 40 else f"{text[:40]}..."
