"""Where the package's data lie: the same from a checkout, an editable install and a wheel."""

from __future__ import annotations

from pathlib import Path

PACKAGE = Path(__file__).parents[1]


def grammar_folder() -> Path:
    """`ntp.lark` and the language reference."""
    return PACKAGE.parent / "grammar"


def library_folder() -> Path:
    """The standard library, where `use` looks last."""
    return PACKAGE / "library"


def examples_folder() -> Path:
    """One folder a domain; a wheel carries them inside the package, a checkout beside it."""
    inside = PACKAGE / "examples"
    return inside if inside.is_dir() else PACKAGE.parent / "examples"


def checkpoints_folder() -> Path:
    """The trained weights that ship with the package."""
    return PACKAGE / "checkpoints"


def templates_folder() -> Path:
    """What `ntp new` begins a domain with: a folder for each kind."""
    return PACKAGE / "templates"
