"""How far parameters may be from the best ones, and whether a response changes evenly over that."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from damperlab.studies.portable import product
from damperlab.worker.fit.history.trials import PRIOR, STEP, Matrix, Place, Trials
from damperlab.worker.fit.singular_values import principal

REACH = 2.0
"""Standard deviations to either side over which a response has to change evenly."""
LITTLE = 0.05
"""Standard deviation, as a share of the range, from which a parameter counts as known by a shorter beginning."""
FLATTEST, STEEPEST = 0.25, 4.0
"""Rise of chi-square over that which a linear response has: outside, the response is not predictable."""


@dataclass(frozen=True)
class Spread:
    """The parameters' covariance by its principal directions, in shares of the ranges.

    Parameters
    ----------
    centre : ndarray, shape (parameters,)
        The best parameters.
    directions : ndarray, shape (parameters, parameters)
        Columns of unit length.
    sizes : ndarray, shape (parameters,)
        Standard deviation along each.
    slopes : ndarray, shape (rows, parameters)
        Of the residuals, in their standard deviations.
    residual : ndarray, shape (rows,)
        At the centre, in standard deviations.
    """

    centre: Matrix
    directions: Matrix
    sizes: Matrix
    slopes: Matrix
    residual: Matrix

    @property
    def covariance(self) -> Matrix:
        """Of the parameters, where the residuals are white."""
        return product(self.directions * self.sizes**2, self.directions.T)

    def draw(self, number: int, generator: np.random.Generator) -> Matrix:
        """Draw places, half of them three times as far as they are likely: shape (number, parameters)."""
        far = self.sizes * generator.standard_normal((number, self.sizes.size))
        far[::2] *= 3.0
        return self.centre + product(far, self.directions.T)

    @classmethod
    def at(cls, trials: Trials, place: Place, rows: int) -> "Spread":
        """Make it from differences over one standard deviation, so that small jumps of a response are passed over."""
        residual = trials.residual(place.shares, rows)
        scatter = np.sqrt(trials.variance(float((residual**2).sum()), rows))
        sizes = np.full(place.shares.size, STEP)
        for _ in range(2):
            slopes = trials.slopes(place.shares, rows, sizes) / scatter
            pulls, directions = principal(product(slopes.T, slopes))
            along = np.sqrt(np.maximum(1.0 / (pulls + PRIOR), 1e-18))
            # what a parameter does alone, so that a pair that only acts together is not stepped out of its valley
            sizes = 1.0 / np.sqrt((slopes**2).sum(axis=0) + PRIOR)
        return cls(place.shares, directions, along, slopes, residual / scatter)


def spread_at(trials: Trials, place: Place, rows: int, before: Spread | None = None) -> Spread | None:
    """Find how far the parameters may be off; None where the response does not change evenly over that.

    Along each principal direction, `REACH` standard deviations to either side, chi-square has to rise about as it would if
    the response were linear. Where it rises less the direction is made longer by what is missing. It has to do so over what a
    shorter beginning left open as well (`before`), where that was little: only then is the longer one's best place the one
    that the shorter one's leads to, and not one of the countless others that impacts make.
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
    """Rise of chi-square over that of a linear response, to either side; none where the ranges end before it has risen."""
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
