"""Who decides for a program that is left to Python, or of which a row was learnt."""

from __future__ import annotations

from collections.abc import Iterator

from ntp_dsl.common.text import counted
from ntp_dsl.language.registry import Registry


def who_decides(registry: Registry, executes: bool) -> Iterator[str]:
    """Yield a line for each program that is left to Python, or of which a row was learnt.

    Args:
        executes: whether the library's functions may be run, to try whether the calls in order are enough.

    Raises `NtpError` for a row that was learnt of another declaration.
    """
    from ntp_dsl.core.default_bodies import with_default_bodies
    from ntp_dsl.core.learnt.learnt_rows import rows_beside, rows_file

    rows = rows_beside(registry).rows
    in_python = [name for name, each in registry.programs.items() if each.in_python]
    known = with_default_bodies(registry) if executes and {*in_python} - {*rows} else registry
    for name, program in registry.programs.items():
        if name in rows:
            share = f"{rows[name].foreseen:.0%} foreseen"
            from_traces = f"learnt from {counted(rows[name].traces, 'trace')}, {share} ({rows_file(program)})"
            what = "decided" if program.in_python else "its calls are ordered"
            yield f"{name}: {what} by its row, {from_traces}"
        elif not program.in_python:
            continue
        elif not known.programs[name].in_python:
            yield f"{name}: decided by its calls in order, which reach the goal as a simulation shows"
        elif executes:
            yield f"{name}: decided by the function; `ntp train --program {name}` learns from its traces"
        else:
            yield f"{name}: decided by its calls in order, or by the function: --execute says which"
