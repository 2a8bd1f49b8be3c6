"""Seeds derived from a recorded seed."""

from __future__ import annotations

import numpy as np


def derived(*parts: int) -> int:
    """Return a 32-bit seed from numbers, so that results do not depend on order or workers."""
    return int(np.random.SeedSequence(parts).generate_state(1)[0])
