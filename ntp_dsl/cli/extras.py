"""What to say where a command lacks a module of an extra."""

from __future__ import annotations

import sys

from ntp_dsl import extras

# Of the commands: none needs pandas, which other libraries look for and do without.
EXTRAS = {module: extra for module, extra in extras.EXTRAS.items() if extra != "notebook"}
CHOSEN = " (--world mujoco, --world kinematic)"
INSTEAD = {"ntp check": "; --static needs nothing more"}  # what a command can do without the module


def missing(command: str, module: str | None) -> str | None:
    """Return the sentence for a command that lacks a module, or None where no extra installs it."""
    sentence = extras.missing(command, module, sys.version_info[:2], CHOSEN)
    return sentence and sentence + INSTEAD.get(command, "")
