"""The camera's pictures that a trace refers to."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ntp_dsl.traces.trace import Trace

MAX_PICTURES = 300  # of one trace; of more, evenly spaced ones are taken
MAX_SIZE = 1_000_000  # [bytes] of one picture
MEDIA_TYPES = {b"\xff\xd8\xff": "image/jpeg", b"\x89PNG\r\n\x1a\n": "image/png"}


@dataclass(frozen=True)
class Picture:
    """A picture of a frame."""

    frame: int
    media_type: str
    content: bytes

    @property
    def uri(self) -> str:
        return f"data:{self.media_type};base64,{b64encode(self.content).decode()}"


def pictures(trace: Trace, folder: Path, after: int = -1) -> Iterator[Picture]:
    """Yield the trace's pictures that lie in the folder; anything else that the trace names is left out.

    Args:
        after: the frame after which they are; by default all.
    """
    every = max(1, -(-len(trace.pictures) // MAX_PICTURES))
    for frame, name in trace.pictures[::every]:
        if frame <= after:
            continue
        content = _content(folder, name)
        media_type = next((each for magic, each in MEDIA_TYPES.items() if content.startswith(magic)), None)
        if media_type is not None:
            yield Picture(frame, media_type, content)


def _content(folder: Path, name: str) -> bytes:
    """Return the content of a file in the folder, links followed; empty where outside it or too large."""
    try:
        path = (folder / name).resolve()
        inside = path.is_relative_to(folder.resolve()) and path.is_file()
        return path.read_bytes() if inside and path.stat().st_size <= MAX_SIZE else b""
    except (OSError, ValueError):  # not a file name
        return b""
