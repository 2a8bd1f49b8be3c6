"""What a recording of rerun holds, by its own reader."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest


def read_by_rerun(path: Path) -> dict[str, dict[str, list[Any]]]:
    """Return entity -> column -> values over all chunks, by rerun's own reader."""
    chunks = pytest.importorskip("rerun.chunk", reason="rerun is not here: pip install 'ntp_dsl[viz]'")
    found: dict[str, dict[str, list[Any]]] = {}
    for chunk in chunks.RrdReader(str(path)).stream():
        columns = found.setdefault(str(chunk.entity_path), {})
        batch = chunk.to_record_batch()
        for name in batch.schema.names:
            if ":" in name:  # a component; the others are times and numbers of rows
                columns.setdefault(name, []).extend(batch.column(name).to_pylist())
    return found
