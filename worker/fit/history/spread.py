"""Uncertainty of the parameters, and whether a response changes smoothly over it."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from damperlab.studies.portable import product
from damperlab.worker.fit.history.trials import PRIOR, STEP, Matrix, Place, Trials
from damperlab.worker.fit.singular_values import principal

REACH = 2.0
"""Standard deviations to either side over which a response must change smoothly."""
LITTLE = 0.05
"""Standard deviation, as a share of the ranges, below which a shorter beginning determines a principal direction."""
FLATTEST, STEEPEST = 0.25, 4.0
"""Allowed rise of chi-square relative to that of a linear response; outside these bounds the response is not
predictable.
"""


@dataclass(frozen=True)
class Spread:
    """The parameters' covariance by its principal directions, as fractions of the ranges.

    Parameters
    ----------
    centre : ndarray, shape (parameters,)
        The best parameters.
    directions : ndarray, shape (parameters, parameters)
        Columns of unit length.
    sizes : ndarray, shape (parameters,)
        Standard deviation along each direction.
    slopes : ndarray, shape (rows, parameters)
        Derivatives of the residuals by the parameters; residuals are in their standard deviations.
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
        """Covariance of the parameters, if the residuals are white."""
        return product(self.directions * self.sizes**2, self.directions.T)

    def draw(self, number: int, generator: np.random.Generator) -> Matrix:
        """Draw places, half of them with three times the spread: shape (number, parameters)."""
        far = self.sizes * generator.standard_normal((number, self.sizes.size))
        far[::2] *= 3.0
        return self.centre + product(far, self.directions.T)

    @classmethod
    def at(cls, trials: Trials, place: Place, rows: int) -> "Spread":
        """Compute the spread from differences over one standard deviation, so that small jumps of a response do not
        matter.
        """
        residual = trials.residual(place.shares, rows)
        scatter = np.sqrt(trials.variance(float((residual**2).sum()), rows))
        sizes = np.full(place.shares.size, STEP)
        for _ in range(2):
            slopes = trials.slopes(place.shares, rows, sizes) / scatter
            pulls, directions = principal(product(slopes.T, slopes))
            along = np.sqrt(np.maximum(1.0 / (pulls + PRIOR), 1e-18))
            # scaled by the effect of each parameter alone, so that parameters that act only together stay in their
            # valley
            sizes = 1.0 / np.sqrt((slopes**2).sum(axis=0) + PRIOR)
        return cls(place.shares, directions, along, slopes, residual / scatter)


def spread_at(trials: Trials, place: Place, rows: int, before: Spread | None = None) -> Spread | None:
    """Find the uncertainty of the parameters; None if the response does not change smoothly over it.

    Along each principal direction, `REACH` standard deviations to either side, chi-square must rise about as for a
    linear response. If it rises less, the direction is lengthened accordingly.

    Along each direction that a shorter part of the history already determined well (`before`, standard deviation below
    `LITTLE`), chi-square must also rise as for a linear response, over `REACH` of the earlier standard deviations.
    Only then does the best parameter set of the longer part follow from that of the shorter one. Otherwise it may be
    one of the countless minima that impacts create.
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
    return Spread(spread.centre, spread.directions, sizes, spread.slopes, spread.residual)


def _rises(trials: Trials, place: Place, rows: int, spread: Spread, away: Matrix) -> Iterator[float]:
    """Rise of chi-square relative to that of a linear response, to either side; empty if the ranges end before it has
    risen.
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
