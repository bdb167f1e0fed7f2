"""The measured responses as smooth functions of the parameters, near a place: polynomials through many noisy responses.

A response changes with the parameters in small jumps: chaos is known to an error, and where several responses are
possible the start decides between them. So a difference of two responses is no derivative. A polynomial of second degree
through many is: what it leaves is scatter, and the scatter is the error of the model there, which joins that of the
measurement.
"""

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]


def terms(count: int) -> int:
    """Coefficients of a polynomial of second degree of so many parameters."""
    return (count + 1) * (count + 2) // 2


@dataclass(frozen=True)
class Surface:
    """Responses near a place.

    Attributes
    ----------
    centre : ndarray, shape (parameters,)
        The place.
    frame : ndarray, shape (parameters, parameters)
        A parameter is centre + frame·z.
    coefficients : ndarray, shape (terms, rows)
        Of 1, z_i, z_i z_j.
    scatter : ndarray, shape (rows,)
        Standard deviation of the responses about the polynomial; infinite where too few responses exist.
    """

    centre: Matrix
    frame: Matrix
    coefficients: Matrix
    scatter: Matrix

    def local(self, places: Matrix) -> Matrix:
        """Turn places, shape (n, parameters), into z."""
        return np.asarray(np.linalg.solve(self.frame, (places - self.centre).T).T)

    def at(self, places: Matrix) -> Matrix:
        """Responses at places of shape (n, parameters): shape (n, rows)."""
        return _powers(self.local(places)) @ self.coefficients


def fit_surface(centre: Matrix, frame: Matrix, places: Matrix, responses: Matrix) -> Surface:
    """Lay polynomials through responses.

    Parameters
    ----------
    centre, frame : ndarray
        As in `Surface`.
    places : ndarray, shape (n, parameters)
        Where there are responses.
    responses : ndarray, shape (n, rows)
        NaN where one failed.
    """
    powers = _powers(np.asarray(np.linalg.solve(frame, (places - centre).T).T, np.float64))
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
    return Surface(centre, frame, coefficients, scatter)


def _regress(powers: Matrix, responses: Matrix) -> tuple[Matrix, Matrix]:
    coefficients, _, rank, _ = np.linalg.lstsq(powers, responses, rcond=1e-10)
    left = responses - powers @ coefficients
    freedom = max(1, len(powers) - int(rank))
    return np.asarray(coefficients, np.float64), np.sqrt((left**2).sum(axis=0) / freedom)


def _powers(local: Matrix) -> Matrix:
    count = local.shape[1]
    columns = [np.ones(len(local)), *local.T]
    columns += [local[:, i] * local[:, j] for i, j in combinations_with_replacement(range(count), 2)]
    return np.stack(columns, axis=1)
