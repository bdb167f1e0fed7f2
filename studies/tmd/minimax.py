"""The absorber with the least peak on a damped structure, where no closed form exists.

Three stages, each safe without the next: a coarse grid finds the valley, nested golden sections need nothing but
its being a valley, and Newton's method sharpens what they find where two peaks are level.
"""

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.transfer import Excitation, amplitude_ratio, highest, peaks

_GOLDEN = (math.sqrt(5) - 1) / 2
_TUNINGS = np.linspace(0.3, 1.3, 21)
"""Over Den Hartog's tuning; a heavily damped structure wants a slower absorber."""
_DAMPINGS = np.geomspace(0.1, 8.0, 13)
"""Over Den Hartog's damping."""
_WIDTHS = (1e-3, 1e-8)
"""Relative widths at which the golden sections end: for Newton's method to begin, and where it cannot."""


@lru_cache(maxsize=256)
def minimax(mass_ratio: float, structural_damping: float, excitation: Excitation = "base") -> Absorber:
    """Minimise the largest amplitude ratio over all frequencies.

    Parameters
    ----------
    mass_ratio : float
        μ > 0.
    structural_damping : float
        ζ_s of the structure, 0 or more.
    excitation : {"base", "force"}
        What the peak is a peak of.

    Returns
    -------
    Absorber
        With level peaks where the structure is lightly damped; then tuning and damping are known to about
        1e-10. Where a single maximum remains they are known to about 1e-7, and its height to rounding.
    """

    def height(tuning: float, damping: float) -> float:
        return highest(Absorber(mass_ratio, tuning, damping), structural_damping, excitation).value

    tunings = _TUNINGS / (1 + mass_ratio)
    dampings = _DAMPINGS * math.sqrt(3 * mass_ratio / (8 * (1 + mass_ratio)))
    row, column = _coarse(tunings, dampings, mass_ratio, structural_damping, excitation)
    around = float(tunings[max(row - 3, 0)]), float(tunings[min(row + 3, tunings.size - 1)])
    across = float(dampings[max(column - 2, 0)]), float(dampings[min(column + 2, dampings.size - 1)])
    found = np.empty(2)
    for width in _WIDTHS:

        def best_tuning(damping: float, width: float = width) -> float:
            return _golden(lambda tuning: height(tuning, damping), *around, width)

        damping = _golden(lambda damping: height(best_tuning(damping), damping), *across, width)
        found = np.array([best_tuning(damping), damping])
        sharp = _sharpen(found, mass_ratio, structural_damping, excitation)
        if sharp is not None and height(*sharp) <= height(*found):
            return Absorber(mass_ratio, float(sharp[0]), float(sharp[1]))
    return Absorber(mass_ratio, float(found[0]), float(found[1]))


def _coarse(
    tunings: NDArray[np.float64],
    dampings: NDArray[np.float64],
    mass_ratio: float,
    structural_damping: float,
    excitation: Excitation,
) -> tuple[int, int]:
    """Give row and column of the least peak, the frequencies sampled."""
    lam = np.linspace(0.05, 2.0, 118)
    heights = np.array(
        [
            [
                amplitude_ratio(lam, Absorber(mass_ratio, t, d), structural_damping, excitation).max()
                for d in dampings
            ]
            for t in tunings
        ]
    )
    row, column = np.unravel_index(heights.argmin(), heights.shape)
    return int(row), int(column)


def _golden(value: Callable[[float], float], low: float, high: float, width: float) -> float:
    """Place of the minimum of a function with one valley, by golden sections; a kink at it does not matter."""
    a, b = float(low), float(high)
    c, d = b - _GOLDEN * (b - a), a + _GOLDEN * (b - a)
    at_c, at_d = value(c), value(d)
    while b - a > width * (abs(a) + abs(b)):
        if at_c <= at_d:
            b, d, at_d = d, c, at_c
            c = b - _GOLDEN * (b - a)
            at_c = value(c)
        else:
            a, c, at_c = c, d, at_d
            d = a + _GOLDEN * (b - a)
            at_d = value(d)
    return (a + b) / 2


def _sharpen(
    start: NDArray[np.float64], mass_ratio: float, structural_damping: float, excitation: Excitation
) -> NDArray[np.float64] | None:
    """Newton's method for two level peaks whose gradients are parallel; None where there are not two."""

    def residual(x: NDArray[np.float64]) -> NDArray[np.float64] | None:
        absorber = Absorber(mass_ratio, float(x[0]), float(x[1]))
        stationary = peaks(absorber, structural_damping, excitation)
        if len(stationary) != 3:  # maximum, minimum, maximum
            return None
        left, right = stationary[0], stationary[2]
        slopes = [
            _gradient(absorber, structural_damping, excitation, p.frequency_ratio) for p in (left, right)
        ]
        (a, b), (c, d) = slopes
        return np.array([left.value - right.value, a * d - b * c])

    x = start
    for _ in range(20):
        here = residual(x)
        if here is None:
            return None
        jacobian = np.empty((2, 2))
        for k in range(2):
            step = np.zeros(2)
            step[k] = 1e-5 * x[k]
            up, down = residual(x + step), residual(x - step)
            if up is None or down is None:
                return None
            jacobian[:, k] = (up - down) / (2 * step[k])
        try:
            move = np.linalg.solve(jacobian, here)
        except np.linalg.LinAlgError:
            return None
        if not np.all(np.abs(move) < 0.1 * np.abs(x)):
            return None
        x = x - move
        if np.all(np.abs(move) < 1e-12 * np.abs(x)):
            break
    return x


def _gradient(
    absorber: Absorber, structural_damping: float, excitation: Excitation, lam: float
) -> tuple[float, float]:
    """Derivatives of a peak's height by tuning and by damping; the peak's place is stationary, so it may stay.

    The dynamic stiffness is K = s − λ² − μλ² L/(L − λ²), L = γ² + 2iζγλ, and |H| = |a/K|.
    """
    mu, gamma, zeta = absorber.mass_ratio, absorber.tuning, absorber.damping_ratio
    square = lam * lam
    link = gamma**2 + 2j * zeta * gamma * lam
    structure = 1 + 2j * structural_damping * lam
    stiffness = structure - square - mu * square * link / (link - square)
    height = abs((structure if excitation == "base" else 1.0) / stiffness)
    # d|H|/dq = −|H| Re(K_q/K), and dK/dL = μλ⁴/(L − λ²)²
    factor = -height * mu * square**2 / (link - square) ** 2 / stiffness
    return (
        float((factor * (2 * gamma + 2j * zeta * lam)).real),
        float((factor * 2j * gamma * lam).real),
    )
