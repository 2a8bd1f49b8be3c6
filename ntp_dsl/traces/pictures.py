"""What a camera saw, taken from beside a trace into a page."""

from __future__ import annotations

from base64 import b64encode
from pathlib import Path

from ntp_dsl.traces.schema import Trace

MOST = 300  # pictures of one trace: of more, evenly chosen ones
LARGEST = 1_000_000  # bytes of one
KINDS = {b"\xff\xd8\xff": "image/jpeg", b"\x89PNG\r\n\x1a\n": "image/png"}


def embedded(trace: Trace, folder: Path) -> list[tuple[int, str]]:
    """Frames and data URIs of what is a picture and lies in the folder; the rest is left out."""
    every = -(-len(trace.pictures) // MOST)
    found = []
    for frame, name in trace.pictures[:: max(every, 1)]:
        uri = _uri(folder, name)
        if uri is not None:
            found.append((frame, uri))
    return found


def _uri(folder: Path, name: str) -> str | None:
    try:
        path = (folder / name).resolve()
        if not path.is_relative_to(folder.resolve()) or not path.is_file():
            return None
        if path.stat().st_size > LARGEST:
            return None
        content = path.read_bytes()
    except (OSError, ValueError):  # a name that no file can have
        return None
    kind = next((kind for magic, kind in KINDS.items() if content.startswith(magic)), None)
    return f"data:{kind};base64,{b64encode(content).decode()}" if kind else None
