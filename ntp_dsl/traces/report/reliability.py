"""How well probabilities agree with what came true."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

BINS = 10


@dataclass
class Bin:
    """The probabilities of an interval."""

    count: int = 0
    probabilities: float = 0.0  # their sum
    true: int = 0

    @property
    def mean(self) -> float:
        """Return their mean, where there are any."""
        return self.probabilities / self.count

    @property
    def share(self) -> float:
        """Return the share that came true, where there are any."""
        return self.true / self.count


@dataclass
class Reliability:
    """Probabilities in ten bins, each with the share that came true."""

    bins: list[Bin] = field(default_factory=lambda: [Bin() for _ in range(BINS)])

    @classmethod
    def of(cls, rows: Iterable[tuple[float, bool]]) -> Reliability:
        """Return that of some probabilities, each with whether it came true."""
        found = cls()
        for probability, came_true in rows:
            found.add(probability, came_true)
        return found

    def add(self, probability: float, came_true: bool) -> None:
        """Count a probability, and whether it came true."""
        found = self.bins[min(int(BINS * probability), BINS - 1)]
        found.count += 1
        found.probabilities += probability
        found.true += came_true

    def filled(self) -> Iterator[Bin]:
        """Yield the bins that have probabilities, in order."""
        yield from (each for each in self.bins if each.count)

    @property
    def count(self) -> int:
        """Return the number of probabilities."""
        return sum(each.count for each in self.bins)

    @property
    def error(self) -> float:
        """Return the expected calibration error (Naeini et al., 2015); 0 without probabilities."""
        return sum(each.count * abs(each.mean - each.share) for each in self.filled()) / max(self.count, 1)
