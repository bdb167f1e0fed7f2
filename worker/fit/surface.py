"""The measured responses as smooth functions of the parameters near a place: polynomials through many noisy
responses.

A response changes with the parameters in small jumps: chaos has an error, and if several responses are possible the
start decides between them. So a difference of two responses is no derivative. A polynomial of second degree through
many is: its residual is scatter, which is the error of the model there, and it is added to that of the measurement.
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
"""Share of the largest singular value above which a coefficient is determined."""


def terms(count: int) -> int:
    """Number of coefficients of a polynomial of second degree in so many parameters."""
    return (count + 1) * (count + 2) // 2


@dataclass(frozen=True)
class Surface:
    """Responses near a place.

    Attributes
    ----------
    region : Region
        The place; its z are the variables of the polynomials.
    coefficients : ndarray, shape (terms, rows)
        Of 1, z_i, z_i z_j.
    scatter : ndarray, shape (rows,)
        Standard deviation of the responses about the polynomial; infinite if there are too few responses.
    """

    region: Region
    coefficients: Matrix
    scatter: Matrix

    def at(self, places: Matrix) -> Matrix:
        """Responses at places of shape (n, parameters): shape (n, rows)."""
        return product(_powers(self.region.local(places)), self.coefficients)


def fit_surface(region: Region, places: Matrix, responses: Matrix) -> Surface:
    """Fit polynomials to responses.

    Parameters
    ----------
    region : Region
        Place near which they approximate the responses.
    places : ndarray, shape (n, parameters)
        Places of the responses.
    responses : ndarray, shape (n, rows)
        NaN for a failed one.
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
