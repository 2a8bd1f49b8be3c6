"""Who decides for a program that is left to Python: its learnt row, its calls in order, or the function."""

from __future__ import annotations

from collections.abc import Iterator

from ntp_dsl.common.text import counted
from ntp_dsl.language.registry import Registry


def who_decides(registry: Registry, executes: bool) -> Iterator[str]:
    """Yield a line for each program that is left to Python.

    Args:
        executes: whether the library's functions may be run, to try whether the calls in order are enough.

    Raises `NtpError` for a row that was learnt of another declaration.
    """
    names = [name for name, each in registry.programs.items() if each.in_python]
    if not names:
        return
    from ntp_dsl.core.default_bodies import with_default_bodies
    from ntp_dsl.core.learnt.learnt_rows import rows_beside, rows_file

    rows = rows_beside(registry).rows
    known = with_default_bodies(registry) if executes else registry
    for name in names:
        if name in rows:
            path = rows_file(registry.programs[name])
            yield f"{name}: decided by its row, learnt from {counted(rows[name].traces, 'trace')} ({path})"
        elif not known.programs[name].in_python:
            yield f"{name}: decided by its calls in order, which reach the goal as a simulation shows"
        elif executes:
            yield f"{name}: decided by the function; `ntp train --program {name}` learns from its traces"
        else:
            yield f"{name}: decided by its calls in order, or by the function: --execute says which"
