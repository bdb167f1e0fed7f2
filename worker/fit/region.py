"""A region of the parameters: an ellipsoid within their ranges, in which responses are computed and approximated."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.portable import power, product
from damperlab.worker.fit.singular_values import covariance_of, inverse, length_of, principal

Matrix = NDArray[np.float64]

RADIUS, EDGE = 2.5, 1.2
"""Radius of a region, in standard deviations of the parameters, and the multiple of this radius up to which its
polynomials are trusted.
"""
FULL, WIDER = 0.85, 2.0
"""If draws in a region reach this share of the spread of a uniform density, the region is too small, and grows by the
second factor.
"""
EVEN, WHOLE = 2000, 0.6
"""Number of uniform draws for this test, and the size, relative to the range, at which a region covers the complete
range.
"""
NARROWEST = 1e-4
"""Least variance of draws in a region, relative to that of the region, so that a region shrinks at most a hundredfold
in one round.
"""


@dataclass(frozen=True)
class Region:
    """A point, and the standard deviations around it.

    Parameters
    ----------
    centre : ndarray, shape (parameters,)
        As fractions of the ranges.
    frame : ndarray, shape (parameters, parameters)
        A point is centre + frame·z; the region is |z| ≤ `RADIUS`.
    """

    centre: Matrix
    frame: Matrix

    @cached_property
    def _unit(self) -> Matrix:
        return inverse(self.frame).T

    def local(self, places: Matrix) -> Matrix:
        """Convert points, shape (n, parameters), into z."""
        return product(places - self.centre, self._unit)

    def holds(self, places: Matrix, radius: float = RADIUS) -> NDArray[np.bool_]:
        """Whether points lie in the region."""
        return np.asarray(length_of(self.local(places)) <= radius)

    def draw(self, number: int, generator: np.random.Generator, radius: float = RADIUS) -> Matrix:
        """Draw points uniformly in the region, folded back into the ranges at their ends."""
        count = self.centre.size
        direction = generator.standard_normal((number, count))
        direction /= length_of(direction)[:, None]
        length = radius * power(generator.random((number, 1)), 1.0 / count)
        places = np.mod(self.centre + product(direction * length, self.frame.T), 2.0)
        return np.asarray(np.minimum(places, 2.0 - places))

    def resized(self, draws: Matrix, generator: np.random.Generator) -> tuple[Matrix, "Region"]:
        """Move the region to the middle of draws from it, and resize it along each principal direction.

        If the draws fill the region, because it is smaller than the parameters' uncertainty, it grows.

        Returns
        -------
        sizes : ndarray, shape (parameters,)
            Sizes of the new region over those of this one.
        region : Region
        """
        variances, directions = principal(covariance_of(self.local(draws)))
        sizes = np.sqrt(np.maximum(variances, NARROWEST))
        even = self.draw(EVEN, generator, EDGE * RADIUS)
        even = self.local(even[self.holds(even, EDGE * RADIUS)])
        spread = np.sqrt(np.diag(product(directions.T, product(covariance_of(even), directions))))
        turned = product(self.frame, directions)
        largest = WHOLE / length_of(turned.T)
        sizes = np.where(sizes > FULL * spread, WIDER, sizes)
        sizes = np.minimum(sizes, np.maximum(largest, NARROWEST))
        return sizes, Region(draws.mean(axis=0), turned * sizes)
