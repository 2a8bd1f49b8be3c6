"""Preferences: a score of calls, as a weighted sum of few numbers; of those due, the best is likeliest.

A conditional logit (McFadden, 1974), whose columns are chosen one after the other, as long as the likelihood
of what was chosen grows by more than a column costs (the Bayesian information criterion, and the number of
columns that could have been chosen).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from ntp_dsl.core.learnt.columns import Columns, columns_of

if TYPE_CHECKING:  # both bring torch, and whoever only reads a row needs none
    from ntp_dsl.core.dispatch.rows import Row
    from ntp_dsl.core.perception.perceived import Believed

RIDGE = 0.01  # penalty of a weight's square, for columns of unit variance
STEPS = 30  # of Newton's method, at most
MOST_COLUMNS = 12

Matrix = NDArray[np.float64]


class Term(Struct, frozen=True):
    """A number that a preference looks at: how it is scaled, and its weight."""

    column: str
    mean: float
    deviation: float
    weight: float


class Preference(Struct, frozen=True):
    """What makes a call preferred among those that are due."""

    terms: tuple[Term, ...]

    def score(self, columns: Columns) -> float:
        """Return the score of a call, up to a constant, as a logarithm of a probability."""
        return sum(
            each.weight * (columns.get(each.column, 0.0) - each.mean) / each.deviation for each in self.terms
        )

    def __str__(self) -> str:
        return ", ".join(f"{'large' if each.weight > 0 else 'small'} {each.column}" for each in self.terms)


def scores(preference: Preference, row: Row, state: Believed) -> tuple[float, ...]:
    """Return the score of each call of a row."""
    calls = zip(row.calls, row.statements, strict=True)
    return tuple(preference.score(columns_of(call, statement, state)) for call, statement in calls)


@dataclass(frozen=True)
class Choice:
    """The calls that were due in one decision, and which one was made."""

    calls: Sequence[Columns]
    chosen: int


def preferred(choices: Sequence[Choice]) -> Preference:
    """Return what the choices have in common; no terms where nothing tells them from chance."""
    choices = [each for each in choices if len(each.calls) > 1]
    names = sorted({name for each in choices for columns in each.calls for name in columns})
    matrices = [_matrix(each.calls, names) for each in choices]
    if not matrices:
        return Preference(())
    stacked = np.concatenate(matrices)
    means, deviations = stacked.mean(0), stacked.std(0)
    varies = [at for at in range(len(names)) if deviations[at] > 1e-9 and _tells(matrices, at)]
    scaled = [(matrix - means) / np.where(deviations > 1e-9, deviations, 1.0) for matrix in matrices]
    fit = _Fit(scaled, [each.chosen for each in choices])
    cost = log(max(2, len(choices))) / 2 + log(max(2, len(varies)))
    used: list[int] = []
    loss, weights = fit.solve(used)
    while len(used) < MOST_COLUMNS:
        tried = [(fit.solve([*used, at])[0], at) for at in varies if at not in used]
        best = min(tried, default=None)
        if best is None or loss - best[0] < cost:
            break
        used.append(best[1])
        loss, weights = fit.solve(used)
    return Preference(
        tuple(
            Term(names[at], float(means[at]), float(deviations[at]), float(weight))
            for at, weight in zip(used, weights, strict=True)
        )
    )


def _matrix(calls: Sequence[Columns], names: Sequence[str]) -> Matrix:
    return np.array([[columns.get(name, 0.0) for name in names] for columns in calls])


def _tells(matrices: Sequence[Matrix], at: int) -> bool:
    """Return whether a column differs between the calls of any one choice."""
    return any(np.ptp(matrix[:, at]) > 1e-9 for matrix in matrices)


class _Fit:
    """Fits weights of some columns to choices: all choices at once, padded to the same number of calls."""

    def __init__(self, matrices: Sequence[Matrix], chosen: Sequence[int]) -> None:
        most = max(len(matrix) for matrix in matrices)
        self._values = np.zeros((len(matrices), most, matrices[0].shape[1]))
        self._absent = np.zeros((len(matrices), most))
        for number, matrix in enumerate(matrices):
            self._values[number, : len(matrix)] = matrix
            self._absent[number, len(matrix) :] = -np.inf
        self._chosen = np.asarray(chosen)
        self._rows = np.arange(len(matrices))

    def solve(self, columns: Sequence[int]) -> tuple[float, NDArray[np.float64]]:
        """Return the negative log likelihood of the choices, and the weights (Newton's method)."""
        values = self._values[:, :, list(columns)]
        weights = np.zeros(len(columns))
        loss, chances = self._loss(values, weights)
        for _ in range(STEPS if columns else 0):
            means = np.einsum("nc,nck->nk", chances, values)
            gradient = (means - values[self._rows, self._chosen]).sum(0) + 2 * RIDGE * weights
            second = np.einsum("nc,nck,ncl->kl", chances, values, values) - means.T @ means
            step = np.linalg.solve(second + 2 * RIDGE * np.eye(len(columns)), gradient)
            size, (new, _) = 1.0, self._loss(values, weights - step)
            while new > loss and size > 1e-6:
                size /= 2
                new, _ = self._loss(values, weights - size * step)
            weights = weights - size * step
            done = loss - new < 1e-9
            loss, chances = self._loss(values, weights)
            if done:
                break
        return loss, weights

    def _loss(self, values: Matrix, weights: NDArray[np.float64]) -> tuple[float, Matrix]:
        scores = values @ weights + self._absent
        scores = scores - scores.max(1, keepdims=True)
        chances = np.exp(scores)
        total = chances.sum(1)
        picked = scores[self._rows, self._chosen] - np.log(total)
        return float(-picked.sum() + RIDGE * (weights**2).sum()), chances / total[:, None]
