"""What a camera saw, taken from beside a trace."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ntp_dsl.traces.schema import Trace

MOST = 300  # pictures of one trace: of more, evenly chosen ones
LARGEST = 1_000_000  # bytes of one
KINDS = {b"\xff\xd8\xff": "image/jpeg", b"\x89PNG\r\n\x1a\n": "image/png"}


@dataclass(frozen=True)
class Picture:
    frame: int
    kind: str  # media type
    content: bytes

    @property
    def uri(self) -> str:
        return f"data:{self.kind};base64,{b64encode(self.content).decode()}"


def pictures(trace: Trace, folder: Path) -> Iterator[Picture]:
    """Of what is a picture and lies in the folder; a trace may name anything, and the rest is left out."""
    every = max(1, -(-len(trace.pictures) // MOST))
    for frame, name in trace.pictures[::every]:
        content = _content(folder, name)
        kind = next((kind for magic, kind in KINDS.items() if content.startswith(magic)), None)
        if kind is not None:
            yield Picture(frame, kind, content)


def _content(folder: Path, name: str) -> bytes:
    """Of a file in the folder, links followed; nothing where it is none, or too large."""
    try:
        path = (folder / name).resolve()
        inside = path.is_relative_to(folder.resolve()) and path.is_file()
        return path.read_bytes() if inside and path.stat().st_size <= LARGEST else b""
    except (OSError, ValueError):  # a name that no file can have
        return b""
