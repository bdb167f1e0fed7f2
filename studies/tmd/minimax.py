"""The absorber with the least peak on a damped structure, where no closed form exists.

Two stages: a grid that is laid ever closer around its least point, and Newton's method, which sharpens what that finds
where two peaks are level. Both work in units of the width of the resonance, √μ + ζ_s, so that a light absorber is tuned
as well as a heavy one.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.stationary import Heights, all_stationary
from damperlab.studies.vocabulary import Excitation

Floats = NDArray[np.float64]
_TUNINGS = np.linspace(-4.0, 2.0, 37)
"""Of the tuning, see `_Problem`; a heavily damped structure wants a slower absorber."""
_DAMPINGS = np.linspace(math.log(0.05), math.log(30.0), 25)
_SIDE = np.linspace(-2.0, 2.0, 9)
"""The grid laid around the least point so far, in steps of the one before."""
_LOOKS = 200
_ENOUGH = 1e-4, 1e-8
"""Steps at which Newton's method is tried, and at which the grid ends."""


class _Problem(NamedTuple):
    """What is tuned: x = (p, q) stands for γ² = γ_D²·exp(w·p) and ζ = ζ_D·exp(q).

    γ_D = 1/(1 + μ) is Den Hartog's tuning, ζ_D his damping plus ζ_s, w the width of the resonance.
    """

    mass_ratio: float
    structural_damping: float
    base: bool

    @property
    def width(self) -> float:
        return min(1.0, math.sqrt(self.mass_ratio) + self.structural_damping)

    def heights(self, x: Floats) -> Heights:
        """Give the amplitude ratios of absorbers, x of shape (n, 2)."""
        mu = self.mass_ratio
        # by logarithms, so that γ² − 1 loses no digit of a light absorber's tuning
        logarithm = self.width * x[:, 0] - 2 * math.log1p(mu)
        damping = math.sqrt(3 * mu / (8 * (1 + mu))) + self.structural_damping
        return Heights(
            mu,
            np.exp(logarithm),
            np.expm1(logarithm),
            damping * np.exp(x[:, 1]),
            self.structural_damping,
            self.base,
        )

    def highest(self, x: Floats) -> Floats:
        return self.heights(np.atleast_2d(x)).highest()

    def absorber(self, x: Floats) -> Absorber:
        heights = self.heights(np.atleast_2d(x))
        return Absorber(self.mass_ratio, math.sqrt(float(heights.square[0])), float(heights.damping_ratio[0]))


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
        1e-10 of the width of the resonance, √μ + ζ_s. Where a single maximum remains they are known to about 1e-7, and
        its height to rounding.
    """
    problem = _Problem(mass_ratio, structural_damping, excitation == "base")
    x, step = _coarse(problem)
    lowest = problem.highest(x)[0]
    tried = False
    for _ in range(_LOOKS):
        grid = x + np.stack(np.meshgrid(_SIDE * step[0], _SIDE * step[1]), axis=-1).reshape(-1, 2)
        values = problem.highest(grid)
        place = int(values.argmin())
        if values[place] < lowest:
            lowest, x = values[place], grid[place]
        across, down = place % _SIDE.size, place // _SIDE.size
        if 0 < across < _SIDE.size - 1 and 0 < down < _SIDE.size - 1:
            step = step / 2
        if not tried and step.max() < _ENOUGH[0]:
            tried = True
            sharp = _sharpen(problem, x)
            if sharp is not None and problem.highest(sharp)[0] <= lowest:
                return problem.absorber(sharp)
        if step.max() < _ENOUGH[1] or lowest <= 1:  # at rest the ratio is 1, whatever the absorber
            break
    return problem.absorber(x)


def _coarse(problem: _Problem) -> tuple[Floats, Floats]:
    """Find the valley; give its least point on the grid, and the steps of the grid."""
    grid = np.stack(np.meshgrid(_TUNINGS, _DAMPINGS), axis=-1).reshape(-1, 2)
    step = np.array([_TUNINGS[1] - _TUNINGS[0], _DAMPINGS[1] - _DAMPINGS[0]])
    return grid[int(problem.highest(grid).argmin())], step


def _sharpen(problem: _Problem, start: Floats) -> Floats | None:
    """Newton's method for two level peaks whose gradients are parallel; None where there are not two."""

    def residual(x: Floats) -> Floats | None:
        heights = problem.heights(x[None])
        places, values = all_stationary(heights)
        if places.size != 3:  # maximum, minimum, maximum
            return None
        a, b = _slopes(problem, heights, float(places[0]))
        c, d = _slopes(problem, heights, float(places[2]))
        # over the height, and angle instead of area: both of order one however light the absorber
        return np.array(
            [math.log(values[0] / values[2]), (a * d - b * c) / (math.hypot(a, b) * math.hypot(c, d))]
        )

    x = start
    for _ in range(20):
        here = residual(x)
        if here is None:
            return None
        jacobian = np.empty((2, 2))
        for k in range(2):
            step = np.zeros(2)
            step[k] = 1e-5
            up, down = residual(x + step), residual(x - step)
            if up is None or down is None:
                return None
            jacobian[:, k] = (up - down) / 2e-5
        try:
            move = np.linalg.solve(jacobian, here)
        except np.linalg.LinAlgError:
            return None
        if not np.all(np.abs(move) < 0.1):
            return None
        x = x - move
        if np.all(np.abs(move) < 1e-12):
            break
    return x


def _slopes(problem: _Problem, heights: Heights, from_one: float) -> tuple[float, float]:
    """Derivatives of log |H| by p and by q at a peak, λ² − 1; the peak's place is stationary, so it may stay.

    The dynamic stiffness is K = 1 + 2iζ_sλ − λ² − μλ² L/(L − λ²), L = γ² + 2iζγλ, and |H| = |a/K|, so
    d log|H| = −Re(dK/K) with dK/dL = μλ⁴/(L − λ²)².
    """
    mu, offset, zeta = problem.mass_ratio, float(heights.offset[0]), float(heights.damping_ratio[0])
    gamma, square = math.sqrt(float(heights.square[0])), 1 + from_one
    lam = math.sqrt(square)
    dash = 2j * zeta * gamma * lam
    link, apart = gamma**2 + dash, offset - from_one + dash
    stiffness = 2j * problem.structural_damping * lam - from_one - mu * square * link / apart
    factor = -mu * (square / apart) ** 2 / stiffness
    return (factor * problem.width * (gamma**2 + dash / 2)).real, (factor * dash).real
