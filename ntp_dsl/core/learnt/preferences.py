"""Preferences: a score of calls, as a weighted sum of few numbers; of those due, the best is likeliest.

A conditional logit (McFadden, 1974), whose columns are chosen one after the other, as long as the likelihood
of what was chosen grows by more than a column costs: half the logarithm of the number of choices (the
Bayesian information criterion), and the logarithm of the number of columns that could have been chosen.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from math import log
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray

from ntp_dsl.core.learnt.quantities import Number, Quantity

RIDGE = 0.01  # penalty of a weight's square, for columns of unit variance
STEPS = 30  # of Newton's method, at most
HALVINGS = 20  # of a step that is too long
MOST_COLUMNS = 12
LEAST_SPREAD = 1e-9  # of a column that differs at all

Matrix = NDArray[np.float64]


class Transform(StrEnum):
    """What is done to a measure: sums of these are weighted scores, ratios, distances from a best value."""

    NONE = "none"
    SQUARE = "square"
    LOG = "log"


class Column(Struct, frozen=True, order=True):
    """A quantity as a score looks at it."""

    quantity: Quantity
    transform: Transform = Transform.NONE
    callee: str = ""  # of whose calls alone it says something; of all calls where it is empty

    def __str__(self) -> str:
        of = f" of {self.callee}" if self.callee else ""
        match self.transform:
            case Transform.SQUARE:
                return f"{self.quantity} squared{of}"
            case Transform.LOG:
                return f"log {self.quantity}{of}"
        return f"{self.quantity}{of}"


Columns = Mapping[Column, float]


def columns_of(numbers: Iterable[Number], callee: str = "") -> dict[Column, float]:
    """Return the columns of a call: its numbers, and of measures the squares and logarithms.

    Each is there twice, for all calls and for those of the same callee: what speaks for one of these may
    speak against another.
    """
    found: dict[Column, float] = {}
    for quantity, value, is_measure in numbers:
        for whose in dict.fromkeys(("", callee)):
            found[Column(quantity, callee=whose)] = value
            if is_measure:
                found[Column(quantity, Transform.SQUARE, whose)] = value * value
                if value > 0:
                    found[Column(quantity, Transform.LOG, whose)] = log(value)
    return found


class Term(Struct, frozen=True):
    """A column that a preference looks at: how it is scaled, and its weight."""

    column: Column
    mean: float
    deviation: Annotated[float, Meta(gt=0)]
    weight: float


class Preference(Struct, frozen=True, dict=True):
    """What makes a call preferred among those that are due."""

    terms: tuple[Term, ...]

    @cached_property
    def quantities(self) -> frozenset[Quantity]:
        """What it looks at."""
        return frozenset(each.column.quantity for each in self.terms)

    def score(self, columns: Columns) -> float:
        """Return the score of a call, up to a constant, as a logarithm of a probability.

        Of what cannot be said of the call, as of another statement's, nothing is added.
        """
        return sum(
            each.weight * (columns[each.column] - each.mean) / each.deviation
            for each in self.terms
            if each.column in columns
        )

    def __str__(self) -> str:
        return ", ".join(f"{'large' if each.weight > 0 else 'small'} {each.column}" for each in self.terms)


@dataclass(frozen=True)
class Choice:
    """The calls that were due in one decision, and which one was made."""

    calls: Sequence[Columns]
    chosen: int


def preferred(choices: Sequence[Choice]) -> Preference:
    """Return what the choices have in common; no terms where nothing tells them from chance."""
    choices = [each for each in choices if len(each.calls) > 1]
    names = _usable(choices)
    if not choices or not names:
        return Preference(())
    matrices = [_matrix(each.calls, names) for each in choices]
    stacked = np.concatenate(matrices)
    means, deviations = np.nanmean(stacked, axis=0), np.nanstd(stacked, axis=0)
    varies = [at for at in range(len(names)) if deviations[at] > LEAST_SPREAD and _tells(matrices, at)]
    scale = np.where(deviations > LEAST_SPREAD, deviations, 1.0)
    fit = _Fit(
        [np.nan_to_num((each - means) / scale) for each in matrices], [each.chosen for each in choices]
    )
    cost = log(len(choices)) / 2 + log(max(1, len(varies)))
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
            Term(names[at], _rounded(means[at]), _rounded(deviations[at]), _rounded(weight))
            for at, weight in zip(used, weights, strict=True)
        )
    )


def _rounded(value: float) -> float:
    """Return a number to six digits: more hang on the order in which sums are added up."""
    return float(f"{value:.6g}")


def _usable(choices: Sequence[Choice]) -> list[Column]:
    """Return the columns, in their order; logarithms only of what is positive wherever it is a number."""
    calls = [columns for each in choices for columns in each.calls]
    names = sorted({name for columns in calls for name in columns})
    return [name for name in names if name.transform is not Transform.LOG or _is_positive(name, calls)]


def _is_positive(name: Column, calls: Sequence[Columns]) -> bool:
    plain = Column(name.quantity, callee=name.callee)
    return all(name in columns or plain not in columns for columns in calls)


def _matrix(calls: Sequence[Columns], names: Sequence[Column]) -> Matrix:
    """Return a row for each call; NaN where a column says nothing of it."""
    return np.array([[columns.get(name, np.nan) for name in names] for columns in calls])


def _tells(matrices: Sequence[Matrix], at: int) -> bool:
    """Return whether a column differs between the calls of any one choice."""
    return any(np.ptp(np.nan_to_num(matrix[:, at])) > LEAST_SPREAD for matrix in matrices)


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
        """Return the penalised negative log likelihood, and the weights with the least (Newton's method)."""
        values = self._values[:, :, list(columns)]
        weights = np.zeros(len(columns))
        loss, chances = self._loss(values, weights)
        for _ in range(STEPS if columns else 0):
            step = self._step(values, weights, chances)
            for _ in range(HALVINGS):
                new, new_chances = self._loss(values, weights - step)
                if new < loss:
                    break
                step = step / 2
            else:
                break
            gained = loss - new
            weights, loss, chances = weights - step, new, new_chances
            if gained < 1e-9:
                break
        return loss, weights

    def _step(self, values: Matrix, weights: NDArray[np.float64], chances: Matrix) -> NDArray[np.float64]:
        means = np.einsum("nc,nck->nk", chances, values)
        gradient = (means - values[self._rows, self._chosen]).sum(0) + 2 * RIDGE * weights
        second = np.einsum("nc,nck,ncl->kl", chances, values, values) - means.T @ means
        return np.linalg.solve(second + 2 * RIDGE * np.eye(len(weights)), gradient)

    def _loss(self, values: Matrix, weights: NDArray[np.float64]) -> tuple[float, Matrix]:
        scores = values @ weights + self._absent
        scores = scores - scores.max(1, keepdims=True)
        chances = np.exp(scores)
        total = chances.sum(1)
        picked = scores[self._rows, self._chosen] - np.log(total)
        return float(-picked.sum() + RIDGE * (weights**2).sum()), chances / total[:, None]
