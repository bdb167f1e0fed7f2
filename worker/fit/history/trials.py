"""Residuals of a time history for trial parameters, and least squares over its beginning."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.fit.history.question import HistoryQuestion
from damperlab.studies.portable import product
from damperlab.worker.fit.history.march import displacement
from damperlab.worker.fit.singular_values import principal

Matrix = NDArray[np.float64]

STEP = 1e-5
"""Step of a difference, as a share of the range; it is so small that rarely an impact appears or vanishes within it."""
PRIOR = 12.0
"""Inverse variance of the prior of a parameter: a uniform distribution over its range."""
MOST_STEPS, ENOUGH = 20, 1e-8
"""Iterations of a refinement, and relative gain below which it ends."""
LEAST_VARIANCE = 1e-14
"""Least variance of residuals, in their unit."""
DAMPINGS = (0.0, 1e-3, 1e-1, 10.0)
"""Damping factors that are tried in turn, relative to the curvature (Levenberg 1944, Marquardt 1963)."""


@dataclass(frozen=True)
class Place:
    """Parameters, and the distance of their history from the measured one.

    Parameters
    ----------
    shares : ndarray, shape (parameters,)
        As fractions of the ranges.
    squares : float
        Sum of the squared residuals; infinite if the integration failed.
    """

    shares: Matrix
    squares: float


class Trials:
    """All histories that a fit computes.

    Parameters
    ----------
    question : HistoryQuestion
        What is fitted.
    progress : callable, optional
        Called with the number of computed histories.
    """

    def __init__(self, question: HistoryQuestion, progress: Callable[[int], None] | None) -> None:
        self.question = question
        measured = question.measured
        # without a given deviation, the residuals have a unit of their own, the same for all rows
        self.unit = np.full(measured.rows, 0.01 * measured.largest_m)
        if measured.deviation_m is not None:
            self.unit = measured.deviation_m
        self.evaluations = 0
        self._progress = progress

    def residual(self, shares: Matrix, rows: int) -> Matrix:
        """Measured minus computed over the unit, shape (rows,); NaN if the integration failed."""
        self.evaluations += 1
        if self._progress is not None:
            self._progress(self.evaluations)
        found = displacement(self.question, self.question.values(shares), rows)
        return np.asarray((self.question.measured.displacement_m[:rows] - found) / self.unit[:rows])

    def variance(self, squares: float, rows: int) -> float:
        """Variance of the residuals in their unit: 1 if the deviation was given, else from their scatter."""
        if self.question.measured.deviation_m is not None:
            return 1.0
        # computed data agree to rounding
        return max(squares / (rows - len(self.question.free)), LEAST_VARIANCE)

    def place(self, shares: Matrix, rows: int) -> Place:
        """Compute one place."""
        return Place(shares, _squares(self.residual(shares, rows)))

    def slopes(self, shares: Matrix, rows: int, steps: Matrix) -> Matrix:
        """Derivative of the residuals by the parameters, from differences to both sides within the ranges.

        Returns
        -------
        ndarray, shape (rows, parameters)
        """
        columns = []
        for i, step in enumerate(steps):
            ends = []
            for side in (-1.0, 1.0):
                moved = shares.copy()
                moved[i] = np.clip(moved[i] + side * step, 0.0, 1.0)
                ends.append((moved[i], self.residual(moved, rows)))
            (low, before), (high, after) = ends
            columns.append(np.nan_to_num((after - before) / (high - low)))
        return np.stack(columns, axis=1)

    def descend(self, shares: Matrix, rows: int) -> Place:
        """Minimise the sum of squares over the first rows by damped Gauss–Newton steps, within the ranges."""
        here = self.residual(shares, rows)
        best = Place(shares, _squares(here))
        if not np.isfinite(best.squares):
            return best
        for _ in range(MOST_STEPS):
            slopes = self.slopes(best.shares, rows, np.full(shares.size, STEP))
            curvature, gradient = product(slopes.T, slopes), product(slopes.T, here)
            before = best
            pulls, directions = principal(curvature)
            # no step is made along a direction in which the residuals change by rounding only
            changes = pulls > shares.size * np.finfo(float).eps * pulls.max()
            along = np.where(changes, product(directions.T, _free(best.shares, gradient)), 0.0)
            for damping in DAMPINGS:
                added = damping * np.diag(curvature).max() + 1e-12
                step = product(directions, along / (pulls + added))
                tried = np.clip(best.shares - step, 0.0, 1.0)
                found = self.residual(tried, rows)
                if _squares(found) < best.squares:
                    best, here = Place(tried, _squares(found)), found
                    break
            if best.squares > (1.0 - ENOUGH) * before.squares:
                break
        return best


def _free(shares: Matrix, gradient: Matrix) -> Matrix:
    """The gradient without components that lead out of the ranges."""
    outwards = ((shares <= 0.0) & (gradient > 0.0)) | ((shares >= 1.0) & (gradient < 0.0))
    return np.where(outwards, 0.0, gradient)


def _squares(residual: Matrix) -> float:
    total = float((residual**2).sum())
    return total if np.isfinite(total) else np.inf
