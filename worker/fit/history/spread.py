"""Uncertainty of the parameters, and a test of whether the response changes smoothly within this uncertainty."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from damperlab.studies.portable import product
from damperlab.worker.fit.history.trials import PRIOR, STEP, Matrix, Place, Trials
from damperlab.worker.fit.singular_values import principal

REACH = 2.0
"""Distance to either side over which a response must change smoothly [standard deviations]."""
LITTLE = 0.05
"""Standard deviation from a shorter part of the history, as a fraction of the ranges, below which chi-square
is tested along the principal direction.
"""
FLATTEST, STEEPEST = 0.25, 4.0
"""Smallest and largest allowed rise of chi-square, divided by the rise for a linear response. Outside these
bounds, the response changes too abruptly for a prediction.
"""


@dataclass(frozen=True)
class Spread:
    """Principal directions and standard deviations of the parameters, as fractions of the ranges.

    Parameters
    ----------
    centre : ndarray, shape (parameters,)
        The best parameter set.
    directions : ndarray, shape (parameters, parameters)
        Principal directions as columns of unit length.
    sizes : ndarray, shape (parameters,)
        Standard deviation along each principal direction.
    slopes : ndarray, shape (rows, parameters)
        Derivatives of the residuals, in standard deviations, with respect to the parameters.
    residual : ndarray, shape (rows,)
        Residuals at the centre, in standard deviations.
    """

    centre: Matrix
    directions: Matrix
    sizes: Matrix
    slopes: Matrix
    residual: Matrix

    @property
    def covariance(self) -> Matrix:
        """Covariance of the parameters for white residuals."""
        return product(self.directions * self.sizes**2, self.directions.T)

    def draw(self, number: int, generator: np.random.Generator) -> Matrix:
        """Draw parameter sets, shape (number, parameters), half of them with three times the standard deviation."""
        far = self.sizes * generator.standard_normal((number, self.sizes.size))
        far[::2] *= 3.0
        return self.centre + product(far, self.directions.T)

    @classmethod
    def at(cls, trials: Trials, place: Place, rows: int) -> "Spread":
        """Compute the spread from differences over one standard deviation, so that small jumps have little effect."""
        residual = trials.residual(place.shares, rows)
        scatter = np.sqrt(trials.variance(float((residual**2).sum()), rows))
        sizes = np.full(place.shares.size, STEP)
        for _ in range(2):
            slopes = trials.slopes(place.shares, rows, sizes) / scatter
            pulls, directions = principal(product(slopes.T, slopes))
            along = np.sqrt(np.maximum(1.0 / (pulls + PRIOR), 1e-18))
            # standard deviations with the other parameters fixed: such steps stay in the valley of chi-square
            sizes = 1.0 / np.sqrt((slopes**2).sum(axis=0) + PRIOR)
        return cls(place.shares, directions, along, slopes, residual / scatter)


def spread_at(trials: Trials, place: Place, rows: int, before: Spread | None = None) -> Spread | None:
    """Return the uncertainty of the parameters, or None if the response changes abruptly within this uncertainty.

    Chi-square is computed `REACH` standard deviations to either side along each principal direction. There,
    chi-square must have risen about as much as for a linear response. If it has risen less, the standard deviation
    along this direction is increased accordingly.

    `before` is the uncertainty from a shorter part of the history, with its own principal directions. Some of these
    directions have a standard deviation below `LITTLE`. Along these directions too, chi-square must rise as it does
    for a linear response. Otherwise the best parameter set may be one of the countless minima that impacts create.
    """
    spread = Spread.at(trials, place, rows)
    sizes = spread.sizes.copy()
    for i, size in enumerate(spread.sizes):
        shares = list(_rises(trials, place, rows, spread, size * spread.directions[:, i]))
        if not all(FLATTEST <= share <= STEEPEST for share in shares):
            return None
        sizes[i] = size / np.sqrt(min([1.0, *shares]))
    if before is not None:
        for i in np.flatnonzero(before.sizes < LITTLE).tolist():
            away = before.sizes[i] * before.directions[:, i]
            if not all(FLATTEST <= share <= STEEPEST for share in _rises(trials, place, rows, spread, away)):
                return None
    return replace(spread, sizes=sizes)


def _rises(trials: Trials, place: Place, rows: int, spread: Spread, away: Matrix) -> Iterator[float]:
    """Yield the rise of chi-square on both sides of the centre, divided by the rise for a linear response.

    A side is omitted if a parameter's range ends there too close to the centre.
    """
    variance = trials.variance(place.squares, rows)
    for side in (-REACH, REACH):
        inside = np.clip(place.shares + side * away, 0.0, 1.0)
        step = inside - place.shares
        changed = product(spread.slopes, step)
        known = PRIOR * float((step**2).sum())
        linear = float((changed**2).sum() + 2.0 * (spread.residual * changed).sum()) + known
        if linear >= 0.5 * REACH**2:
            rise = (trials.place(inside, rows).squares - place.squares) / variance
            yield (rise + known) / linear
