"""Every random choice hangs on a seed that is recorded; here is how one seed begets others."""

from __future__ import annotations

import numpy as np


def derived(*parts: int) -> int:
    """A seed of 32 bits from the numbers of what it is for: results do not depend on order or workers."""
    return int(np.random.SeedSequence(parts).generate_state(1)[0])
