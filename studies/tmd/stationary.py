"""Stationary points of the amplitude ratio of a structure with an absorber, for many absorbers at once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
NARROWEST = 1e-150
"""Smallest width. The square of a smaller width would underflow."""
ROUNDING = 1e-15
PAIR = 1e-4
"""Largest relative imaginary part of a complex pair of roots that counts as a double root."""


@dataclass(frozen=True)
class Heights:
    """The amplitude ratio of n absorbers, each on its own structure or all on one structure.

    With s = λ², |H|² is a ratio N/D of polynomials in s (degrees 3 and 4), so its stationary points are roots of N′D −
    ND′. With a light absorber on a lightly damped structure, all these points lie within about √μ of s = 1.
    Near s = 1, polynomials in powers of s lose their accuracy by cancellation. So the polynomials are formed
    around a centre c, in t = (s − c)/δ, where δ is the width of the features near the centre. The centres are
    s = 1, and also s = 0 for an absorber that is tuned far below the structure. All roots are used: an
    additional point does no harm when the largest value is sought. An error in the position of a peak changes
    its height only to second order.

    Parameters
    ----------
    mass_ratio : float or ndarray, (n,)
        μ, 0 or more.
    square, offset : ndarray, (n,)
        γ², and γ² − 1 separately. A light absorber is tuned so close to 1 that γ² alone does not resolve γ² − 1. An
        absorber with a low natural frequency has γ² near 0.
    damping_ratio : ndarray, (n,)
        ζ = c/(2√(m k₁)).
    structural_damping : float or ndarray, (n,)
        ζ_s.
    base : bool
        True for base excitation, False for a force on the structure.
    """

    mass_ratio: float | Floats
    square: Floats
    offset: Floats
    damping_ratio: Floats
    structural_damping: float | Floats
    base: bool

    def candidates(self) -> tuple[Floats, Floats]:
        """Return λ and |H| at the real part s of every root, each of shape (n, roots).

        Where s is not positive, λ = 0 and |H| = 1.
        """
        widths = [
            (1.0, self.width()),
            (0.0, np.ones_like(self.square)),
            (0.0, np.clip(self.square, NARROWEST, 1.0)),
        ]
        found = [self._around(centre, width) for centre, width in widths]
        return tuple(np.concatenate(parts, axis=1) for parts in zip(*found, strict=True))  # type: ignore[return-value]

    def width(self) -> Floats:
        """Return the width δ of the features around the centre s = 1. The width is at most 1; shape (n,)."""
        near = np.sqrt(self.mass_ratio) + self.structural_damping + self.damping_ratio + np.abs(self.offset)
        return np.asarray(np.clip(near, NARROWEST, 1.0))

    def highest(self) -> Floats:
        """Return the largest |H| of each absorber, (n,). It is at least 1, the value at λ = 0."""
        return np.asarray(self.candidates()[1].max(axis=1, initial=1.0))

    def _around(self, centre: float, width: Floats) -> tuple[Floats, Floats]:
        roots = self._roots(centre, width)
        step = width[:, None] * roots.real
        positive = np.isfinite(step) & (centre + step > 0)
        step = np.where(positive, step, 0.0)
        from_one = step if centre == 1 else centre + step - 1
        values = self.at(centre + step, from_one)
        return np.where(positive, np.sqrt(centre + step), 0.0), np.where(positive, values, 1.0)

    def at(self, s: Floats, from_one: Floats) -> Floats:
        """Return |H| at s = λ², (n, m). `from_one` is s − 1, given separately so that it is accurate near 1."""
        mu, structural = _column(self.mass_ratio), _column(self.structural_damping)
        tuning, zeta = np.sqrt(self.square)[:, None], self.damping_ratio[:, None]
        # γ² − s is formed from γ² and s if s < 0.5, otherwise from γ² − 1 and s − 1
        spring = np.where(s < 0.5, tuning**2 - s, self.offset[:, None] - from_one)
        lam = np.sqrt(s)
        top = np.hypot(spring, 2 * zeta * tuning * lam)
        if self.base:
            top = top * np.hypot(1, 2 * structural * lam)
        real = -from_one * spring - mu * s * tuning**2 - 4 * structural * zeta * tuning * s
        imaginary = zeta * tuning * (-from_one - mu * s) + structural * spring
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = top / np.hypot(real, 2 * lam * imaginary)
        return np.asarray(np.nan_to_num(ratio, nan=0.0, posinf=np.inf))

    def _roots(self, centre: float, width: Floats) -> NDArray[np.complex128]:
        """Return the roots of N′D − ND′ in t = (s − c)/δ, (n, 6)."""
        mu, structural = self.mass_ratio, self.structural_damping
        tuning, zeta = np.sqrt(self.square), self.damping_ratio
        one = np.ones_like(width)
        # each row holds the coefficients of a polynomial, the constant term first, with factors scaled by powers of δ
        s = np.stack([centre * one, width], axis=1)
        unit = np.stack([(1 - centre) / width, -one], axis=1)  # (1 − s)/δ
        spring = np.stack([(self.offset if centre == 1 else tuning**2) / width, -one], axis=1)
        ours, theirs = (structural / width)[:, None], (zeta * tuning / width)[:, None]
        top = _times(spring, spring) + _long(4 * theirs**2 * s, 3)
        if self.base:
            top = _times(top, 4 * _column(structural) ** 2 * s + _constant(one))
        real = _times(unit, spring) - _long(((mu * tuning**2 / width) / width)[:, None] * s, 3)
        real = real - _long(4 * ours * theirs * s, 3)
        imaginary = theirs * (unit - (mu / width)[:, None] * s) + ours * spring
        bottom = _times(real, real) + 4 * _times(s, _times(imaginary, imaginary), 5)
        condition = _times(_derived(top), bottom) - _times(top, _derived(bottom))
        return _polynomial_roots(condition)


def all_stationary(heights: Heights) -> tuple[Floats, Floats]:
    """Return λ² − 1 and |H| of every stationary point of a single absorber, by ascending frequency, each point once."""
    width = heights.width()
    roots = heights._roots(1.0, width)[0]
    step = float(width[0]) * roots
    # rounding may turn a double root into a complex pair, with imaginary parts that are small relative to s and s − 1
    nearness = np.minimum(np.abs(1 + step), np.abs(step) + width[0])
    kept = np.isfinite(roots) & (np.abs(step.imag) < PAIR * nearness) & (step.real > -1)
    offset = np.sort(step.real[kept])[None]
    return offset[0], heights.at(1 + offset, offset)[0]


def _column(numbers: float | Floats) -> Floats:
    return np.reshape(numbers, (-1, 1))


def _constant(one: Floats) -> Floats:
    return np.stack([one, np.zeros_like(one)], axis=1)


def _long(rows: Floats, length: int) -> Floats:
    longer = np.zeros((rows.shape[0], length))
    longer[:, : rows.shape[1]] = rows
    return longer


def _times(a: Floats, b: Floats, length: int = 0) -> Floats:
    """Return the products of polynomials, row by row."""
    product = np.zeros((a.shape[0], max(length, a.shape[1] + b.shape[1] - 1)))
    for power in range(a.shape[1]):
        product[:, power : power + b.shape[1]] += a[:, power, None] * b
    return product


def _derived(a: Floats) -> Floats:
    return a[:, 1:] * np.arange(1, a.shape[1])


def _polynomial_roots(rows: Floats) -> NDArray[np.complex128]:
    """Return the roots of polynomials, row by row, as eigenvalues of companion matrices.

    If a polynomial has a lower degree, its row of roots ends with NaN. A leading coefficient below the rounding
    error of the largest coefficient is left out, because it gives a spurious root that makes the other roots
    inaccurate.
    """
    size = np.abs(rows)
    counts = size > ROUNDING * size.max(axis=1, keepdims=True)
    degrees = np.where(counts.any(axis=1), rows.shape[1] - 1 - counts[:, ::-1].argmax(axis=1), 0)
    found = np.full((rows.shape[0], rows.shape[1] - 1), np.nan + 0j)
    for degree in np.unique(degrees[degrees > 0]).tolist():
        of = np.flatnonzero(degrees == degree)
        companion = np.zeros((of.size, degree, degree))
        companion[:, 1:, :-1] = np.eye(degree - 1)
        companion[:, :, -1] = -rows[of, :degree] / rows[of, degree, None]
        found[of, :degree] = np.linalg.eigvals(companion)
    return found
