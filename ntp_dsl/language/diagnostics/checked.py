"""Checks as generators: they yield diagnostics and return what they establish, such as a value's type."""

from __future__ import annotations

from collections.abc import Generator
from typing import TypeVar

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic

T = TypeVar("T")
Checked = Generator[Diagnostic, None, T]


def outcome(check: Checked[T]) -> tuple[T, list[Diagnostic]]:
    """Run a check to its end; return what it returns, and the diagnostics that it yields."""
    found: list[Diagnostic] = []
    while True:
        try:
            found.append(next(check))
        except StopIteration as end:
            return end.value, found
