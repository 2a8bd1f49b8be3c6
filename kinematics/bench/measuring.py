"""Times and success rates of many queries, as the benchmarks report them."""

import math
import platform
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from importlib import metadata
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")
LIBRARIES = ("pin", "coal", "mujoco", "mink", "ompl", "pybullet", "numpy", "pin-pink", "pybullet_planning")


@dataclass
class Tally:
    """Success and time of each query."""

    solved: list[bool] = field(default_factory=list)
    wall: list[float] = field(default_factory=list)  # [s]
    busy: list[float] = field(default_factory=list)  # CPU time [s]

    def timed(self, query: Callable[[], T]) -> T:
        """Run a query, note its time, and return its answer."""
        busy, wall = time.process_time(), time.perf_counter()
        answer = query()
        self.wall.append(time.perf_counter() - wall)
        self.busy.append(time.process_time() - busy)
        return answer

    def figures(self) -> dict[str, Any]:
        """Return the figures: `solved` is a share; times are wall time, `cpu_median_ms` CPU time [ms]."""
        return {
            "queries": len(self.solved),
            "solved": share(self.solved),
            "median_ms": quantile_ms(self.wall, 0.5),
            "p95_ms": quantile_ms(self.wall, 0.95),
            "cpu_median_ms": quantile_ms(self.busy, 0.5),
        }


def share(found: Iterable[bool]) -> float:
    """Return the share of true values."""
    every = list(found)
    return round(sum(every) / len(every), 4) if every else math.nan


def quantile_ms(seconds: list[float], q: float) -> float:
    """Return a quantile of times [ms]."""
    return round(1000 * float(np.quantile(seconds, q)), 4) if seconds else math.nan


def machine() -> dict[str, Any]:
    """Return the processor, the Python version and the libraries of the measurement."""
    return {
        "processor": _processor(),
        "python": platform.python_version(),
        "libraries": {name: found for name in LIBRARIES if (found := version(name))},
    }


def version(library: str) -> str | None:
    """Return the version of a library, or None if it is not installed."""
    try:
        return metadata.version(library)
    except metadata.PackageNotFoundError:
        return None


def _processor() -> str:
    try:
        with open("/proc/cpuinfo") as lines:
            models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    except OSError:
        models = []
    return models[0] if models else platform.processor() or platform.machine()
