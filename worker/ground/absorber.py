"""Computes the response of a linear structure to a record, without damper or with a tuned mass damper.

Between samples, structure and damper are a linear system x' = Mx, if x also contains displacement, velocity,
acceleration and jerk of the base. The matrix exponential of M is exact over panels of any length, so no step size is
needed. Peaks are extrema of the power series of each panel. Mean squares are exact up to rounding.
"""

from math import factorial, nan, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.tmd.absorber import NO_DAMPER, Absorber
from damperlab.studies.tmd.under_record import linear_system
from damperlab.studies.variables import Status
from damperlab.worker.ground.design import Structure, scale_of
from damperlab.worker.ground.measures import GroundResponse
from damperlab.worker.ground.response import record_base
from damperlab.worker.solver.excitation.record_base import RecordBase
from damperlab.worker.solver.motion.taylor import TERMS
from damperlab.worker.solver.observe.quadrature import GAUSS_NODES, GAUSS_WEIGHTS

# Unknowns: v, v' of the structure relative to the base; q, q' of the absorber relative to the structure; base motion.
_V, _W, _Q, _Q_RATE, _S, _S_RATE, _A, _J = range(8)


def absorber_response(
    structure: Structure,
    absorber: Absorber | None,
    motion: GroundMotion,
    factor: float = 1.0,
    tail_s: float = 0.0,
) -> GroundResponse:
    """Compute the response of a structure with a tuned mass damper to a record.

    Parameters
    ----------
    structure : Structure
        The structure.
    absorber : Absorber or None
        Tuned mass damper; None for the structure alone.
    motion, factor, tail_s
        Arguments as in `response.ground_response`.

    Returns
    -------
    GroundResponse
        Response without impacts and sticking. `loss_viscous_j` is the loss in both dashpots.
    """
    scale = scale_of(structure, motion, factor)
    absorber = absorber or NO_DAMPER
    stretch = max(1.0, absorber.tuning * (1.0 + absorber.damping_ratio)) * (1.0 + absorber.mass_ratio)
    base = record_base(structure, motion, factor, tail_s, stretch if absorber.mass_ratio else 1.0)
    matrix, acceleration = linear_system(absorber, structure.damping_ratio, 1.0)
    states = _states(matrix, base)
    relative, absolute = np.eye(8)[_V], np.eye(8)[_V] + np.eye(8)[_S]
    peaks = [_peak(matrix, states, c, base.window) for c in (relative, absolute, acceleration)]
    at = np.stack([states[:-1] @ expm(matrix * (node * base.window)).T for node in GAUSS_NODES])
    weights = GAUSS_WEIGHTS[:, None] * base.window

    def mean_square(c: NDArray[np.float64]) -> float:
        return float(np.sum(weights * (at @ c) ** 2))

    time = base.windows * base.window
    mu, zeta_a, gamma = absorber.mass_ratio, absorber.damping_ratio, absorber.tuning
    two_zeta = 2.0 * structure.damping_ratio
    transmitted = -(two_zeta * at[..., _W] + at[..., _V])
    work = float(np.sum(weights * transmitted * at[..., _S_RATE]))
    loss = float(
        np.sum(weights * (two_zeta * at[..., _W] ** 2 + 2.0 * mu * zeta_a * gamma * at[..., _Q_RATE] ** 2))
    )
    end = states[-1]
    u_rate = end[_W] + end[_S_RATE]
    stored = 0.5 * (u_rate**2 + end[_V] ** 2 + mu * ((u_rate + end[_Q_RATE]) ** 2 + gamma**2 * end[_Q] ** 2))
    largest = max(abs(work), loss, stored)
    length, energy = scale.length_m, scale.energy_j
    good = bool(np.isfinite(states).all())
    return GroundResponse(
        peak_relative_displacement_m=peaks[0] * length,
        rms_relative_displacement_m=sqrt(mean_square(relative) / time) * length,
        peak_absolute_displacement_m=peaks[1] * length,
        rms_absolute_displacement_m=sqrt(mean_square(absolute) / time) * length,
        peak_absolute_acceleration_m_s2=peaks[2] * scale.acceleration_m_s2,
        rms_absolute_acceleration_m_s2=sqrt(mean_square(acceleration) / time) * scale.acceleration_m_s2,
        impacts=0,
        impact_speed_max_m_s=0.0,
        stick_fraction=0.0,
        work_in_j=work * energy,
        loss_viscous_j=loss * energy,
        loss_friction_j=0.0,
        loss_impact_j=0.0,
        energy_residual=abs(work - loss - stored) / largest if largest > 0.0 else nan,
        duration_s=time / scale.omega,
        end_relative_displacement_m=end[_V] * length,
        end_relative_velocity_m_s=end[_W] * scale.speed_m_s,
        status=int(Status.CONVERGED if good else Status.UNBOUNDED),
    )


def absorber_history(
    structure: Structure,
    absorber: Absorber | None,
    motion: GroundMotion,
    factor: float = 1.0,
    tail_s: float = 0.0,
) -> dict[str, NDArray[np.float64]]:
    """Return time [s], relative displacement [m] and absolute acceleration [m/s²] at the ends of the panels."""
    scale = scale_of(structure, motion, factor)
    base = record_base(structure, motion, factor, tail_s)
    matrix, acceleration = linear_system(absorber or NO_DAMPER, structure.damping_ratio, 1.0)
    states = _states(matrix, base)
    return {
        "time_s": np.arange(base.windows + 1.0) * (base.window / scale.omega),
        "relative_displacement_m": states[:, _V] * scale.length_m,
        "absolute_acceleration_m_s2": (states @ acceleration) * scale.acceleration_m_s2,
    }


def _states(matrix: NDArray[np.float64], base: RecordBase) -> NDArray[np.float64]:
    """Return the unknowns at the start of each panel and at the end of the last, shape (panels + 1, 8)."""
    step = expm(matrix * base.window)[:_A]
    states = np.zeros((base.windows + 1, 8))
    states[:-1, _A], states[:-1, _J] = base.acceleration, base.jerk
    for k in range(base.windows):
        states[k + 1, :_A] = step @ states[k]
    if base.windows:
        states[-1, _A] = states[-2, _A] + states[-2, _J] * base.window
    return states


def _peak(
    matrix: NDArray[np.float64], states: NDArray[np.float64], output: NDArray[np.float64], window: float
) -> float:
    """Return the largest |output · x| at the ends and at the extrema of the panels."""
    rows = [output]
    for _ in range(TERMS - 1):
        rows.append(rows[-1] @ matrix * window)
    series = states[:-1] @ np.array([row / factorial(n) for n, row in enumerate(rows)]).T  # in t/window
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
