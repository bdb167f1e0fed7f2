"""Approximates the responses at the measured rows by polynomials of the parameters near a point.

A response changes with the parameters in small jumps: the mean of a chaotic response has an error, and the start
decides between several responses. So the difference of two responses gives no derivative, but a second-degree
polynomial through many responses does. The residual of the polynomial is the scatter of the model, which is added to
the error of the measurement.
"""

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.portable import product
from damperlab.worker.fit.region import Region
from damperlab.worker.fit.singular_values import singular_values

Matrix = NDArray[np.float64]

LEAST = 1e-10
"""Fraction of the largest singular value below which singular values are treated as 0 in the regression."""


def terms(count: int) -> int:
    """Return the number of coefficients of a polynomial of second degree in `count` parameters."""
    return (count + 1) * (count + 2) // 2


@dataclass(frozen=True)
class Surface:
    """Polynomials that approximate the responses near a point.

    Attributes
    ----------
    region : Region
        Region whose coordinates z are the variables of the polynomials.
    coefficients : ndarray, shape (terms, rows)
        Coefficients of 1, z_i and z_i z_j.
    scatter : ndarray, shape (rows,)
        Standard deviation of the responses from the polynomials; infinite if there are too few responses.
    """

    region: Region
    coefficients: Matrix
    scatter: Matrix

    def at(self, places: Matrix) -> Matrix:
        """Return the approximate responses, shape (n, rows), at points of shape (n, parameters)."""
        return product(_powers(self.region.local(places)), self.coefficients)


def fit_surface(region: Region, places: Matrix, responses: Matrix) -> Surface:
    """Fit polynomials to responses.

    Parameters
    ----------
    region : Region
        Region in which the polynomials approximate the responses.
    places : ndarray, shape (n, parameters)
        Points at which the responses were computed.
    responses : ndarray, shape (n, rows)
        Responses at these points, NaN if a response failed.
    """
    powers = _powers(region.local(places))
    count, rows = powers.shape[1], responses.shape[1]
    coefficients, scatter = np.zeros((count, rows)), np.full(rows, np.inf)
    complete = np.isfinite(responses)
    alike = np.flatnonzero(complete.all(axis=0))
    if alike.size:
        coefficients[:, alike], scatter[alike] = _regress(powers, responses[:, alike])
    for row in np.flatnonzero(~complete.all(axis=0)):
        there = complete[:, row]
        if np.count_nonzero(there) > count + 2 and there.mean() > 0.5:
            found, left = _regress(powers[there], responses[there][:, [row]])
            coefficients[:, row], scatter[row] = found[:, 0], left[0]
    return Surface(region, coefficients, scatter)


def _regress(powers: Matrix, responses: Matrix) -> tuple[Matrix, Matrix]:
    found = singular_values(powers)
    coefficients = found.solve(responses, LEAST)
    left = responses - product(powers, coefficients)
    freedom = max(1, len(powers) - found.rank(LEAST))
    return coefficients, np.sqrt((left**2).sum(axis=0) / freedom)


def _powers(local: Matrix) -> Matrix:
    count = local.shape[1]
    columns = [np.ones(len(local)), *local.T]
    columns += [local[:, i] * local[:, j] for i, j in combinations_with_replacement(range(count), 2)]
    return np.stack(columns, axis=1)
