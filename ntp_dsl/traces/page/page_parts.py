"""Styles and scripts of pages: joined from their files, and named in a content security policy."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable
from hashlib import sha256
from pathlib import Path


def joined(folder: Path, names: Iterable[str]) -> str:
    """Return the text of several files."""
    return "\n".join((folder / name).read_text(encoding="utf-8") for name in names)


def content_hash(text: str) -> str:
    """Return how a content security policy names a style or script."""
    return "sha256-" + b64encode(sha256(text.encode()).digest()).decode()
