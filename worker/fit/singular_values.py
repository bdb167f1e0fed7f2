"""Singular values of small matrices, computed without OpenBLAS so that every processor returns the same bits."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.portable import product

Matrix = NDArray[np.float64]

MOST_SWEEPS = 60


@dataclass(frozen=True)
class SingularValues:
    """Singular value decomposition U·diag(s)·Vᵀ of a matrix.

    Attributes
    ----------
    left : ndarray, shape (rows, columns)
        Matrix U. A column has unit length, or is zero if its singular value is 0.
    values : ndarray, shape (columns,)
        Singular values s, the largest first.
    right : ndarray, shape (columns, columns)
        Orthogonal matrix V.
    """

    left: Matrix
    values: Matrix
    right: Matrix

    def rank(self, least: float) -> int:
        """Return the number of singular values above `least` times the largest."""
        return int(np.count_nonzero(self.values > least * self.values[0]))

    def solve(self, known: Matrix, least: float = 0.0) -> Matrix:
        """Return the shortest of all least-squares solutions x, for which the matrix times x is closest to `known`.

        Parameters
        ----------
        known : ndarray, shape (rows,) or (rows, n)
            Right-hand side.
        least : float
            Singular values below `least` times the largest are treated as 0.
        """
        kept = slice(0, self.rank(least))
        across = product(self.left[:, kept].T, known)
        over = self.values[kept] if known.ndim == 1 else self.values[kept, None]
        return product(self.right[:, kept], across / over)


def singular_values(matrix: Matrix) -> SingularValues:
    """Decompose a matrix by rotating pairs of columns until all are orthogonal (M. R. Hestenes, J. SIAM 6 (1958) 51).

    Parameters
    ----------
    matrix : ndarray, shape (rows, columns)
        Matrix whose elements are 0 or have a magnitude from 1e-300 to 1e300.

    Raises
    ------
    ArithmeticError
        If an element is not finite, or the rotations do not converge.
    """
    count = matrix.shape[1]
    if not np.isfinite(matrix).all():
        raise ArithmeticError("A matrix that is not finite has no singular values.")
    # the division by a power of two is exact, and keeps the squares of the elements finite
    unit = 2.0 ** float(np.frexp(np.abs(matrix).max(initial=0.0))[1])
    matrix = matrix / unit
    rows = matrix.shape[0]
    # rounding errors of the cosine of a right angle, and of the squared length of a zero column
    rounding = max(rows, count) * float(np.finfo(float).eps)
    nothing = (rounding * float(length_of(np.ravel(matrix)))) ** 2
    # row i holds column i of the matrix, followed by column i of V
    turned = np.concatenate([np.array(matrix.T, np.float64), np.eye(count)], axis=1)
    for _ in range(MOST_SWEEPS):
        still = True
        for i in range(count - 1):
            for j in range(i + 1, count):
                a, b = turned[i, :rows], turned[j, :rows]
                own, other, both = float((a * a).sum()), float((b * b).sum()), float((a * b).sum())
                if min(own, other) <= nothing or abs(both) <= rounding * np.sqrt(own * other):
                    continue
                still = False
                half = (other - own) / (2.0 * both)
                tangent = (1.0 if half >= 0.0 else -1.0) / (abs(half) + np.sqrt(1.0 + half * half))
                cosine = 1.0 / np.sqrt(1.0 + tangent * tangent)
                first = turned[i].copy()
                turned[i] = cosine * (first - tangent * turned[j])
                turned[j] = cosine * (tangent * first + turned[j])
        if still:
            return _sorted(unit * turned[:, :rows], turned[:, rows:])
    raise ArithmeticError(f"The singular values of a matrix of {rows} by {count} do not converge.")


def inverse(matrix: Matrix) -> Matrix:
    """Return the inverse of a square matrix."""
    return singular_values(matrix).solve(np.eye(len(matrix)))


def principal(covariance: Matrix) -> tuple[Matrix, Matrix]:
    """Return the variances in ascending order, and the principal directions as columns, of a covariance matrix."""
    found = singular_values(covariance)
    return found.values[::-1], found.right[:, ::-1]


def covariance_of(places: Matrix) -> Matrix:
    """Return the covariance matrix of points, shape (n, parameters)."""
    off = places - places.mean(axis=0)
    return product(off.T, off) / (len(places) - 1)


def length_of(vectors: Matrix) -> Matrix:
    """Return the lengths of vectors, shape (..., parameters)."""
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=-1)))


def _sorted(columns: Matrix, right: Matrix) -> SingularValues:
    longest = float(np.abs(columns).max(initial=0.0)) or 1.0
    values = longest * length_of(columns / longest)
    order = np.argsort(-values, kind="stable")
    values = values[order]
    unit = columns[order] / np.where(values > 0.0, values, 1.0)[:, None]
    return SingularValues(unit.T, values, right[order].T)
