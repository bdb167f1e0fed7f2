"""Response of a structure with a tuned mass damper to a ground motion, exact for a linear acceleration between samples.

Between samples, structure and absorber are a linear system x' = Mx, if x also contains displacement, velocity,
acceleration and jerk of the base. The matrix exponential of M is exact over panels of any length, so no step size is
needed. Peaks are extrema of the power series of each panel. Integrals of quadratic forms are exact up to rounding.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.tmd.absorber import Absorber

Floats = NDArray[np.float64]

STROKE = "peak_stroke_m"
"""Name of the result for the largest displacement of the absorber relative to the structure.

Ground-motion suites do not have a variable of this name.
"""
MEASURES = tuple(
    f"{kind}_{of}"
    for of in ("relative_displacement_m", "absolute_displacement_m", "absolute_acceleration_m_s2")
    for kind in ("peak", "rms")
)
"""Names of the results that ground-motion suites also have."""
V, W, Q, Q_RATE, S, S_RATE, A, J = range(8)
"""Indices of the unknowns: displacement and velocity of the structure relative to the base (v, v'), of the
absorber relative to the structure (q, q'), and displacement, velocity, acceleration and jerk of the base.
"""
LONGEST = 0.4
"""Longest panel, in units of 1/ω of the fastest motion.

In a panel of this length, the omitted terms of the power series are smaller than rounding errors.
"""
TERMS = 16
"""Number of terms of the power series."""


@dataclass(frozen=True)
class LinearResponse:
    """The motion of a structure with an absorber under a record. Lengths are in m, and times in units of 1/ω_n.

    Parameters
    ----------
    matrix : ndarray, (8, 8)
        M, the matrix of the equations of motion.
    acceleration : ndarray, (8,)
        The row that gives the absolute acceleration of the structure from the unknowns.
    window, omega : float
        Length of a panel [1/ω_n], and ω_n of the structure [rad/s].
    states : ndarray, (panels + 1, 8)
        The unknowns at the start of each panel, and at the end of the last.
    """

    matrix: Floats
    acceleration: Floats
    window: float
    omega: float
    states: Floats

    @property
    def duration(self) -> float:
        """Duration of the record and of the free vibration after it [1/ω_n]."""
        return self.window * (len(self.states) - 1)

    def measure(self, name: str) -> float:
        """Return the result with the given name, in SI units. The name is `STROKE` or one of `MEASURES`."""
        kind, _, of = name.partition("_")
        row = self._rows[of]
        if kind == "peak":
            return self._peak(row)
        return math.sqrt(self.integral(np.outer(row, row)) / self.duration)

    @property
    def _rows(self) -> dict[str, Floats]:
        unit = np.eye(8)
        return {
            "relative_displacement_m": unit[V],
            "absolute_displacement_m": unit[V] + unit[S],
            "absolute_acceleration_m_s2": self.omega**2 * self.acceleration,
            "stroke_m": unit[Q],
        }

    def integral(self, form: Floats) -> float:
        """Return the time integral of x·Fx for a given matrix F, (8, 8).

        The integral over a panel is a quadratic form of the state at its start. C. F. Van Loan, Computing integrals
        involving the matrix exponential, IEEE Trans. Autom. Control 23 (1978) 395.
        """
        from scipy.linalg import expm  # the light client imports this module, and has no scipy

        blocks = np.block([[-self.matrix.T, form], [np.zeros((8, 8)), self.matrix]])
        found = expm(blocks * self.window)
        of_panel = found[8:, 8:].T @ found[:8, 8:]
        starts = self.states[:-1]
        return float(np.sum((starts @ of_panel) * starts))

    def _peak(self, output: Floats) -> float:
        """Return the largest |output · x| at the ends and at the extrema of the panels."""
        rows = [output]
        for n in range(1, TERMS):
            rows.append(rows[-1] @ self.matrix * (self.window / n))
        series = self.states[:-1] @ np.array(rows).T  # in t/window
        first, last = series[:, 0], series.sum(axis=1)
        ends = np.maximum(np.abs(first), np.abs(last))
        order = np.arange(TERMS)
        bulge = np.abs(series) @ (order * (order - 1)) / 8.0
        best = float(ends.max())
        for k in np.flatnonzero(ends + bulge > best):
            rate = np.polynomial.Polynomial(series[k]).deriv()
            rate = rate.trim(1e-17 * float(np.abs(rate.coef).max()))
            if rate.degree() < 1:
                continue
            roots = rate.roots()
            inside = roots.real[(np.abs(roots.imag) < 1e-7) & (roots.real > 0) & (roots.real < 1)]
            if inside.size:
                best = max(best, float(np.abs(np.polynomial.Polynomial(series[k])(inside)).max()))
        return best


def response_under(
    absorber: Absorber,
    damping_ratio: float,
    omega: float,
    motion: GroundMotion,
    scale: float,
    tail_s: float,
) -> LinearResponse:
    """Compute the response to a record.

    Parameters
    ----------
    absorber : Absorber
        The tuned mass damper. An absorber without mass has no effect.
    damping_ratio, omega : float
        ζ and ω_n [rad/s] of the structure.
    motion : GroundMotion
        Motion of the base, whose acceleration is linear between samples.
    scale, tail_s : float
        Factor by which the record is multiplied, and duration of the free vibration after the record [s], in which the
        base keeps its final velocity.
    """
    from scipy.linalg import expm  # the light client imports this module, and has no scipy

    fastest = 1.0 + damping_ratio
    if absorber.mass_ratio:
        fastest *= max(1.0, absorber.tuning * (1.0 + absorber.damping_ratio)) * (1.0 + absorber.mass_ratio)
    step = omega * motion.step_s
    parts = math.ceil(step * fastest / LONGEST)
    window = step / parts
    ground = scale / omega**2 * motion.acceleration_m_s2
    change = np.diff(ground)
    starts = (ground[:-1, None] + change[:, None] * (np.arange(parts) / parts)).ravel()
    still = np.zeros(math.ceil(omega * tail_s / window * (1.0 - 1e-12)))
    matrix, acceleration = _linear_system(absorber, damping_ratio)
    advance = expm(matrix * window)[:A]
    states = np.zeros((starts.size + still.size + 1, 8))
    states[:-1, A] = np.concatenate((starts, still))
    states[: starts.size, J] = np.repeat(change / step, parts)
    states[-1, A] = states[-2, A] + states[-2, J] * window
    free, pushes = advance[:, :A], states[:-1, A:] @ advance[:, A:].T
    states[1:, :A] = _followed(free, pushes)
    return LinearResponse(matrix, acceleration, window, omega, states)


def _followed(free: Floats, pushes: Floats) -> Floats:
    """Return x₁ … xₙ of the recurrence xₖ₊₁ = F xₖ + pₖ from x₀ = 0, shape (n, 6).

    The recurrence is first computed in about √n blocks simultaneously, as if each block started from zero.
    Then the powers F, F², … add the effect of the state at the start of each block.
    """
    count, size = pushes.shape
    length = math.isqrt(count) + 1
    blocks = np.zeros((-(-count // length), length, size))
    blocks.reshape(-1, size)[:count] = pushes
    powers = [free]
    for k in range(1, length):
        blocks[:, k] += blocks[:, k - 1] @ free.T
        powers.append(powers[-1] @ free)
    carried = np.array(powers)
    for before, block in pairwise(blocks):
        block += carried @ before[-1]
    return blocks.reshape(-1, size)[:count]


def _linear_system(absorber: Absorber, damping_ratio: float) -> tuple[Floats, Floats]:
    """Return the matrix of the equations of motion, (8, 8), and the row that gives x'' from the unknowns, (8,).

    x'' is the absolute acceleration of the structure, and a the acceleration of the base. With time in units of 1/ω_n,
    the equations are v'' = x'' − a, x'' = −2ζv' − v + μ(2ζ_aγq' + γ²q), and q'' = −(2ζ_aγq' + γ²q) − x''.
    """
    link = np.zeros(8)
    link[[Q, Q_RATE]] = absorber.tuning**2, 2.0 * absorber.damping_ratio * absorber.tuning
    row = absorber.mass_ratio * link
    row[[V, W]] = -1.0, -2.0 * damping_ratio
    matrix = np.zeros((8, 8))
    matrix[[V, Q, S, S_RATE, A], [W, Q_RATE, S_RATE, A, J]] = 1.0
    matrix[W], matrix[Q_RATE] = row, -link - row
    matrix[W, A] = -1.0
    return matrix, row
