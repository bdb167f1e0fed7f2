"""An ellipsoid in the space of the parameters, in which responses are computed and approximated."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.portable import power, product
from damperlab.worker.fit.singular_values import covariance_of, inverse, length_of, principal

Matrix = NDArray[np.float64]

RADIUS, EDGE = 2.5, 1.2
"""Radius of a region in standard deviations. The polynomials are used up to `EDGE` times this radius."""
FULL, WIDER = 0.85, 2.0
"""Limit on the standard deviation of draws, relative to that of uniform draws, and growth factor of a region.

A region grows along each principal direction in which its draws exceed the limit.
"""
EVEN, WHOLE = 2000, 0.6
"""Number of uniform draws for comparison, and largest size of a region relative to the ranges."""
NARROWEST = 1e-4
"""Lower bound on the variance of draws relative to their region.

One move shrinks a region at most by the factor √1e-4 = 0.01.
"""


@dataclass(frozen=True)
class Region:
    """A point in the space of the parameters, with the standard deviations around the point.

    Parameters
    ----------
    centre : ndarray, shape (parameters,)
        Central point, as fractions of the ranges.
    frame : ndarray, shape (parameters, parameters)
        Matrix of the points centre + frame·z; the region is |z| ≤ `RADIUS`.
    """

    centre: Matrix
    frame: Matrix

    @cached_property
    def _unit(self) -> Matrix:
        return inverse(self.frame).T

    def local(self, places: Matrix) -> Matrix:
        """Return the coordinates z of points in the region, shape (n, parameters)."""
        return product(places - self.centre, self._unit)

    def holds(self, places: Matrix, radius: float = RADIUS) -> NDArray[np.bool_]:
        """Return whether points lie in the region."""
        return np.asarray(length_of(self.local(places)) <= radius)

    def draw(self, number: int, generator: np.random.Generator, radius: float = RADIUS) -> Matrix:
        """Draw points uniformly in the region, and reflect points outside the ranges at the ends of the ranges."""
        count = self.centre.size
        direction = generator.standard_normal((number, count))
        direction /= length_of(direction)[:, None]
        length = radius * power(generator.random((number, 1)), 1.0 / count)
        places = np.mod(self.centre + product(direction * length, self.frame.T), 2.0)
        return np.asarray(np.minimum(places, 2.0 - places))

    def resized(self, draws: Matrix, generator: np.random.Generator) -> tuple[Matrix, "Region"]:
        """Return a region centred on the mean of the samples `draws`, with a new size along each principal direction.

        If the samples fill the old region, the new region is larger, because the parameters are less certain than
        assumed.

        Returns
        -------
        sizes : ndarray, shape (parameters,)
            Size of the new region along each principal direction, relative to the old region.
        region : Region
            The new region.
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
