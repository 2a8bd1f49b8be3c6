"""The manifest of a folder of recorded episodes: its settings, and the outcome of each episode."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from ntp_dsl.common.decoding import Count, Unreadable, decode, decoding
from ntp_dsl.common.files import episode_files, sentences_file, written_whole
from ntp_dsl.common.text import shortened
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import Record

FORMAT = "ntp-dataset"
VERSION = 2
MANIFEST = "manifest.json"


class Recorded(StrEnum):
    """The outcome of recording an episode; only `DONE` ones are kept."""

    DONE = "done"
    NO_DEMONSTRATION = "the demonstration failed"
    EPISODE_FAILED = "the labelled episode failed"


class RecordedEpisode(Struct, frozen=True, omit_defaults=True, kw_only=True):
    """A row of the manifest."""

    number: Count
    seed: int
    goal: tuple[Record, ...]
    outcome: Recorded
    reason: str = ""  # of a failure
    frames: Count = 0  # of the demonstration
    primitives: Count = 0

    @property
    def is_kept(self) -> bool:
        """Return whether its two files are in the folder."""
        return self.outcome is Recorded.DONE


class Manifest(Struct, frozen=True, kw_only=True):
    """How a folder was recorded, with every episode, failed ones too."""

    format: str
    version: int
    library: str
    registry: str  # hash of its programs and apis
    task: str
    episodes: tuple[RecordedEpisode, ...]
    wanted: Count = 0  # episodes that were asked for; fewer where a recording was interrupted
    world: str = "kinematic"
    arm: str | None = None
    seed: int = 0
    perturbation_rate: float = 0.0
    command: str = ""  # as it was typed
    said: bool = False  # each demonstration has its sentences beside it
    excluded: Count = 0  # end configurations that were never drawn
    excluded_files: dict[str, str] = {}  # name -> sha256
    varied: dict[str, tuple[int, int]] = {}  # length, topology, semantics -> range
    versions: dict[str, str] = {}  # package -> version


def write_manifest(manifest: Manifest, folder: Path) -> None:
    """Write a folder's manifest; it appears under its name only when it is whole."""
    with written_whole(folder / MANIFEST) as unfinished:
        unfinished.write_bytes(msgspec.json.format(msgspec.json.encode(manifest), indent=1))


def read_manifest(folder: Path, registry: Registry) -> Manifest:
    """Read a folder's manifest. Raises `NtpError` where the folder was not recorded by this library."""
    path = folder / MANIFEST
    try:
        manifest = _decoded(path.read_bytes(), path)
    except OSError as error:
        raise NtpError(f"{folder}: holds no {MANIFEST}; `ntp record` makes such folders") from error
    if manifest.registry != registry.hash:
        raise NtpError(
            f"{folder}: was recorded with another library or version: '{shortened(manifest.library)}' "
            f"({shortened(manifest.registry)}); expected '{registry.name}' ({registry.hash}): record anew"
        )
    return manifest


def recorded_files(folder: Path) -> set[str]:
    """Return the manifest of a recording and the files that it names; none where there is no recording."""
    try:
        manifest = _decoded((folder / MANIFEST).read_bytes(), folder / MANIFEST)
    except (OSError, NtpError):
        return set()
    kept = [row.number for row in manifest.episodes if row.is_kept]
    said = {sentences_file(folder, number).name for number in kept if manifest.said}
    return {MANIFEST, *(path.name for number in kept for path in episode_files(folder, number)), *said}


def _decoded(text: bytes, path: Path) -> Manifest:
    try:
        row = decode(text, Any)
    except Unreadable as error:
        raise NtpError(f"{path}: expected JSON, found something else: {error}") from error
    if not isinstance(row, dict) or row.get("format") != FORMAT:
        raise NtpError(f"{path}: expected the manifest of `ntp record`, found something else")
    try:
        with decoding():
            return msgspec.convert(_present(row, path), Manifest)
    except Unreadable as error:
        raise NtpError(f"{path}: the manifest is damaged: {error}; record anew") from error


def _present(row: dict[str, Any], path: Path) -> dict[str, Any]:
    """Return a manifest in the present version. Raises `NtpError` for a version that is not read."""
    version = row.get("version")
    if type(version) is not int or not 1 <= version <= VERSION:
        newer = type(version) is int and version > VERSION
        advice = "it was written by a newer ntp: update ntp" if newer else "record anew"
        found = shortened(repr(version))
        raise NtpError(f"{path}: expected version {VERSION} of the format, found {found}; {advice}")
    return row if version == VERSION else _upgraded(row)


def _upgraded(row: dict[str, Any]) -> dict[str, Any]:
    """Return a manifest of the first version, whose outcomes were sentences, in the present one."""
    episodes = []
    for each in row["episodes"]:
        outcome, _, reason = each["outcome"].partition(": ")
        goal = [{"type": "", "fields": list(record.items())} for record in each["goal"]]
        episodes.append({**each, "outcome": outcome, "reason": reason, "goal": goal})
    kept = {name: value for name, value in row.items() if name != "trouble"}
    return {**kept, "version": VERSION, "episodes": episodes, "perturbation_rate": row.get("trouble", 0.0)}
