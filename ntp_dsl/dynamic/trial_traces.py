"""The traces of trials that failed, as files that `ntp trace show`, `explain` and `view` take."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from ntp_dsl.common.files import written_whole
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.tasks.instances import Instance
from ntp_dsl.traces.reader import parse_trace
from ntp_dsl.traces.schema import FORMAT, VERSION, Header, PolicyKind
from ntp_dsl.traces.sources import library_sources
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.protocol import World


def header(registry: Registry, instance: Instance, program: str, arguments: tuple[Argument, ...]) -> Header:
    """Return the header of a trace of the scripted policy in a scene, in the world that checks run in."""
    return Header(
        format=FORMAT,
        version=VERSION,
        library=registry.name,
        registry=registry.hash,
        task=instance.name,
        program=program,
        arguments=arguments,
        policy=PolicyKind.SCRIPTED,
        world="kinematic",
        objects=instance.objects,
        sources=library_sources(registry),
    )


def write_frame(writer: TraceWriter, world: World, seen: Observation) -> None:
    """Write the motion of a world; its `on_frame`, with the first two bound."""
    writer.frame(world.time, seen)


@dataclass
class TrialTraces:
    """A folder for traces; those of an earlier check of the same libraries are replaced, and nothing else is.

    Without a folder, nothing is kept.
    """

    folder: Path | None = None
    written: list[Path] = field(default_factory=list)
    _counts: Counter[str] = field(default_factory=Counter)

    def clear(self, libraries: Iterable[str]) -> None:
        """Delete the traces of an earlier check.

        Raises `NtpError`, and deletes nothing, where a file has the name of one and is none.
        """
        if self.folder is None:
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        earlier = [path for library in libraries for path in self._earlier(self.folder, library)]
        for path in earlier:
            path.unlink()

    def _earlier(self, folder: Path, library: str) -> Iterator[Path]:
        ours = re.compile(rf"{re.escape(library)}\.\w+_\d{{5,}}\.trace\.jsonl")
        for path in sorted(each for each in folder.iterdir() if ours.fullmatch(each.name)):
            if not _is_of(path, library):
                raise NtpError(
                    f"{path} is no trace of '{library}' and would be replaced; choose another --out"
                )
            yield path

    def write(self, library: str, name: str, text: str) -> Path | None:
        """Write the trace of the next failed trial of a task or program, and return its file."""
        if self.folder is None:
            return None
        stem = f"{library}.{name}"
        path = self.folder / f"{stem}_{self._counts[stem]:05d}.trace.jsonl"
        self._counts[stem] += 1
        with written_whole(path) as unfinished:
            unfinished.write_text(text, encoding="utf-8")
        self.written.append(path)
        return path


def _is_of(path: Path, library: str) -> bool:
    """Return whether a file begins as a trace of the library does."""
    try:
        with path.open("rb") as stream:
            return parse_trace(stream.readline(), path).header.library == library
    except (NtpError, OSError):
        return False
