"""How often a process looks for cyclic garbage."""

from __future__ import annotations

import gc

ALLOCATIONS = 2_000  # of containers, between two looks at the newest; 700 by default


def collect_seldom() -> None:
    """Look for cyclic garbage less often than by default.

    A full look goes through all that a process holds. The states of a moment are many and no cycles: of
    reading a demonstration a fifth of the time was spent on looking.
    """
    newest, *older = gc.get_threshold()
    if newest:  # else somebody has turned it off
        gc.set_threshold(max(newest, ALLOCATIONS), *older)
