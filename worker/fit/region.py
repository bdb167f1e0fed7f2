"""A region of the parameters: an ellipsoid within their ranges, in which responses are drawn and described."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.portable import power, product
from damperlab.worker.fit.singular_values import covariance_of, inverse, length_of, principal

Matrix = NDArray[np.float64]

RADIUS, EDGE = 2.5, 1.2
"""Of a region, in standard deviations of the parameters; and how much further its polynomials are believed."""
FULL, WIDER = 0.85, 2.0
"""Share of the spread of an even density from which a region is too small, and by how much it is then made wider."""
EVEN, WHOLE = 2000, 0.6
"""Even draws that this is judged by; and the size, over the range, at which a region covers all of it."""
NARROWEST = 1e-4
"""Least variance of draws in a region, over its own: a region shrinks a hundredfold at most in one round."""


@dataclass(frozen=True)
class Region:
    """A place, and the standard deviations about it.

    Parameters
    ----------
    centre : ndarray, shape (parameters,)
        In shares of the ranges.
    frame : ndarray, shape (parameters, parameters)
        A place is centre + frame·z; the region is |z| ≤ `RADIUS`.
    """

    centre: Matrix
    frame: Matrix

    @cached_property
    def _unit(self) -> Matrix:
        return inverse(self.frame).T

    def local(self, places: Matrix) -> Matrix:
        """Turn places, shape (n, parameters), into z."""
        return product(places - self.centre, self._unit)

    def holds(self, places: Matrix, radius: float = RADIUS) -> NDArray[np.bool_]:
        """Whether places lie in the region."""
        return np.asarray(length_of(self.local(places)) <= radius)

    def draw(self, number: int, generator: np.random.Generator, radius: float = RADIUS) -> Matrix:
        """Draw places evenly in the region, folded back into the ranges at their ends."""
        count = self.centre.size
        direction = generator.standard_normal((number, count))
        direction /= length_of(direction)[:, None]
        length = radius * power(generator.random((number, 1)), 1.0 / count)
        places = np.mod(self.centre + product(direction * length, self.frame.T), 2.0)
        return np.asarray(np.minimum(places, 2.0 - places))

    def resized(self, draws: Matrix, generator: np.random.Generator) -> tuple[Matrix, "Region"]:
        """Move the region to the middle of draws from it, and give it their size along each principal direction.

        Where they fill it, as they do where it is smaller than the parameters' uncertainty, it becomes larger.

        Returns
        -------
        sizes : ndarray, shape (parameters,)
            Of the new region over those of this one.
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
