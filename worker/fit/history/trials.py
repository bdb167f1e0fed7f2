"""Computes the residuals of a time history, and minimises their squares over a beginning of the history."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.fit.history.question import HistoryQuestion
from damperlab.studies.portable import product
from damperlab.worker.fit.archive import Progress
from damperlab.worker.fit.history.march import displacement
from damperlab.worker.fit.singular_values import principal

Matrix = NDArray[np.float64]

STEP = 1e-5
"""Step of a finite difference, as a fraction of the range, so small that impacts rarely appear or vanish."""
PRIOR = 12.0
"""Inverse variance of a uniform distribution over the range, the prior of a parameter."""
MOST_STEPS, ENOUGH = 20, 1e-8
"""Largest number of iterations of a refinement, and relative gain below which the iterations end."""
LEAST_VARIANCE = 1e-14
"""Smallest variance of the residuals, in squared units of the residuals."""
DAMPINGS = (0.0, 1e-3, 1e-1, 10.0)
"""Damping factors, relative to the curvature, that are tried one after the other (Levenberg 1944, Marquardt 1963)."""


@dataclass(frozen=True)
class Place:
    """A parameter set, and the misfit of its computed history.

    Parameters
    ----------
    shares : ndarray, shape (parameters,)
        Parameter values, as fractions of the ranges.
    squares : float
        Sum of the squared residuals; infinite if the integration failed.
    """

    shares: Matrix
    squares: float


class Trials:
    """Computes histories with parameter sets, and compares these histories with the measured history.

    Parameters
    ----------
    question : HistoryQuestion
        Question with the measured history, the known values and the ranges.
    progress : callable, optional
        Function called with the number of computed histories.
    """

    def __init__(self, question: HistoryQuestion, progress: Progress | None) -> None:
        self.question = question
        measured = question.measured
        # without a given deviation, the unit of all residuals is a fraction of the largest displacement
        self.unit = np.full(measured.rows, 0.01 * measured.largest_m)
        if measured.deviation_m is not None:
            self.unit = measured.deviation_m
        self.evaluations = 0
        self._progress = progress

    def residual(self, shares: Matrix, rows: int) -> Matrix:
        """Return (measured − computed displacement)/unit, shape (rows,); NaN if the integration failed."""
        self.evaluations += 1
        if self._progress is not None:
            self._progress(self.evaluations)
        found = displacement(self.question, self.question.values(shares), rows)
        return np.asarray((self.question.measured.displacement_m[:rows] - found) / self.unit[:rows])

    def variance(self, squares: float, rows: int) -> float:
        """Return the variance of the residuals.

        It is 1 if the deviation is given; otherwise it follows from `squares`.
        """
        if self.question.measured.deviation_m is not None:
            return 1.0
        # data computed by the model itself agree to rounding
        return max(squares / (rows - len(self.question.free)), LEAST_VARIANCE)

    def place(self, shares: Matrix, rows: int) -> Place:
        """Return one parameter set with the sum of its squared residuals."""
        return Place(shares, _squares(self.residual(shares, rows)))

    def slopes(self, shares: Matrix, rows: int, steps: Matrix) -> Matrix:
        """Return derivatives of the residuals, shape (rows, parameters), from central differences within the ranges."""
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
        """Minimise the sum of squares over the first `rows` samples by damped Gauss–Newton steps within the ranges."""
        here = self.residual(shares, rows)
        best = Place(shares, _squares(here))
        if not np.isfinite(best.squares):
            return best
        for _ in range(MOST_STEPS):
            slopes = self.slopes(best.shares, rows, np.full(shares.size, STEP))
            curvature, gradient = product(slopes.T, slopes), product(slopes.T, here)
            before = best
            pulls, directions = principal(curvature)
            # directions in which the residuals change only by rounding are left out
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
    """Return the gradient without components that lead out of the ranges."""
    outwards = ((shares <= 0.0) & (gradient > 0.0)) | ((shares >= 1.0) & (gradient < 0.0))
    return np.where(outwards, 0.0, gradient)


def _squares(residual: Matrix) -> float:
    total = float((residual**2).sum())
    return total if np.isfinite(total) else np.inf
