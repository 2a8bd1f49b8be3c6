"""Where the package's data lie: the same from a checkout, an editable install and a wheel."""

from __future__ import annotations

from pathlib import Path

PACKAGE = Path(__file__).parents[1]


def grammar_folder() -> Path:
    """Return the folder of `ntp.lark` and the language reference."""
    return PACKAGE.parent / "grammar"


def library_folder() -> Path:
    """Return the folder of the standard library, where `use` looks last."""
    return PACKAGE / "library"


def examples_folder() -> Path:
    """Return the folder of the examples: inside the package in a wheel, beside it in a checkout."""
    inside = PACKAGE / "examples"
    return inside if inside.is_dir() else PACKAGE.parent / "examples"


def checkpoints_folder() -> Path:
    """Return the folder of the trained weights that ship with the package."""
    return PACKAGE / "checkpoints"


def templates_folder() -> Path:
    """Return the folder of the templates of `ntp new`, one folder for each kind."""
    return PACKAGE / "templates"
