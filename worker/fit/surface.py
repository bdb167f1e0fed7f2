"""The responses at the measured rows as smooth functions of the parameters: polynomials through many noisy responses
near a point.

A response changes with the parameters in small jumps: a chaotic mean has an error, and if several responses are
possible, the start decides between them. So the difference of two responses does not give a derivative, but a
polynomial of second degree through many responses does. Its residual is the scatter of the model, which is added to the
error of the measurement.
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
    """Number of coefficients of a polynomial of second degree in this number of parameters."""
    return (count + 1) * (count + 2) // 2


@dataclass(frozen=True)
class Surface:
    """Responses near a point.

    Attributes
    ----------
    region : Region
        The region; its z are the variables of the polynomials.
    coefficients : ndarray, shape (terms, rows)
        Of 1, z_i, z_i z_j.
    scatter : ndarray, shape (rows,)
        Standard deviation of the responses about the polynomial; infinite if there are too few responses.
    """

    region: Region
    coefficients: Matrix
    scatter: Matrix

    def at(self, places: Matrix) -> Matrix:
        """Responses at points of shape (n, parameters): shape (n, rows)."""
        return product(_powers(self.region.local(places)), self.coefficients)


def fit_surface(region: Region, places: Matrix, responses: Matrix) -> Surface:
    """Fit polynomials to responses.

    Parameters
    ----------
    region : Region
        Where the polynomials approximate the responses.
    places : ndarray, shape (n, parameters)
        Points of the responses.
    responses : ndarray, shape (n, rows)
        Responses at these points; NaN for a failed one.
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
