"""Lines of the library's source, from the copy that a trace carries."""

from __future__ import annotations

from ntp_dsl.language.registry import Registry
from ntp_dsl.traces.trace import Trace


def statement(trace: Trace, place: str) -> str:
    """Return the text at `file:line`, or an empty string where the trace lacks it."""
    file, _, line = place.rpartition(":")
    text = trace.header.sources.get(file)
    if text is None or not line.isdecimal():
        return ""
    rows = text.split("\n")
    return rows[int(line) - 1].strip() if 0 < int(line) <= len(rows) else ""


def library_sources(registry: Registry) -> dict[str, str]:
    """Return the texts of a library and of those it uses, by file name, as far as they are files."""
    paths = {row.span.path for row in registry.programs.values() if row.span.path}
    return {path.name: path.read_text(encoding="utf-8") for path in sorted(paths) if path.is_file()}
