"""Numerical search for the absorber with the smallest peak on a damped structure. No closed form exists.

The search has two stages. A simplex method starts from the best point of a grid. Powell's hybrid method then refines
the result if the absorber has two peaks of equal height. Both methods scale the tuning by the width of the resonance,
√μ + ζ_s, so that a light absorber is tuned as accurately as a heavy one.
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
"""Values of p on the grid (see `_Problem`). A heavily damped structure needs p far below 0."""
_DAMPINGS = np.linspace(math.log(0.05), math.log(30.0), 25)
_PLACE = 1e-8
"""Size of the simplex at convergence."""


class _Problem(NamedTuple):
    """The problem in the unknowns x = (p, q), with γ² = γ_D²·exp(w·p) and ζ = ζ_D·exp(q).

    γ_D = 1/(1 + μ) is Den Hartog's tuning, ζ_D is Den Hartog's damping ratio plus ζ_s, and w is the width of the
    resonance.
    """

    mass_ratio: float
    structural_damping: float
    base: bool

    @property
    def width(self) -> float:
        return min(1.0, math.sqrt(self.mass_ratio) + self.structural_damping)

    def heights(self, x: Floats) -> Heights:
        """Return the amplitude ratios of n absorbers, from x of shape (n, 2)."""
        mu = self.mass_ratio
        # logarithms keep γ² − 1 accurate for a light absorber
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
    """Return the absorber that minimises the largest amplitude ratio over all frequencies.

    Parameters
    ----------
    mass_ratio : float
        μ > 0.
    structural_damping : float
        ζ_s of the structure, 0 or more.
    excitation : {"base", "force"}
        The excitation under which the peak is minimised.

    Returns
    -------
    Absorber
        The absorber. On a lightly damped structure, the response has two peaks of equal height. Tuning and damping are
        then accurate to about 1e-10 of the width of the resonance, √μ + ζ_s. If a single maximum remains, tuning and
        damping are accurate to about 1e-7, but the height of the maximum is exact except for rounding errors.
    """
    from scipy.optimize import minimize, root  # the light client imports this module, and has no scipy

    problem = _Problem(mass_ratio, structural_damping, excitation == "base")
    grid = np.stack(np.meshgrid(_TUNINGS, _DAMPINGS), axis=-1).reshape(-1, 2)
    start = grid[int(problem.highest(grid).argmin())]
    step = np.array([_TUNINGS[1] - _TUNINGS[0], _DAMPINGS[1] - _DAMPINGS[0]])
    simplex = start + step * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    options = {"xatol": _PLACE, "fatol": 0.0, "initial_simplex": simplex}
    least = minimize(lambda x: problem.highest(x)[0], start, method="Nelder-Mead", options=options)
    try:
        level = root(_unlevel, least.x, args=(problem,), tol=1e-13).x
    except ArithmeticError:
        return problem.absorber(least.x)
    return problem.absorber(level if problem.highest(level)[0] <= least.fun else least.x)


def _unlevel(x: Floats, problem: _Problem) -> Floats:
    """Return the logarithm of the ratio of the two peak heights, and the sine of the angle between the two gradients.

    Raises
    ------
    ArithmeticError
        If there are not two peaks.
    """
    heights = problem.heights(x[None])
    places, values = all_stationary(heights)
    if places.size != 3:  # maximum, minimum, maximum
        raise ArithmeticError
    a, b = _slopes(problem, heights, float(places[0]))
    c, d = _slopes(problem, heights, float(places[2]))
    # the logarithm and the sine are of order one for any absorber
    angle = (a * d - b * c) / (math.hypot(a, b) * math.hypot(c, d))
    return np.array([math.log(values[0] / values[2]), angle])


def _slopes(problem: _Problem, heights: Heights, from_one: float) -> tuple[float, float]:
    """Return the derivatives of log |H| with respect to p and q, at the peak with λ² − 1 = `from_one`.

    The peak is stationary, so the derivatives are taken at a fixed position.
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
