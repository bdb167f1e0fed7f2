"""Computes the response of a linear structure to a record, without damper or with a tuned mass damper."""

from math import nan

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.tmd.absorber import NO_DAMPER, Absorber
from damperlab.studies.tmd.under_record import MEASURES, Q_RATE, S_RATE, Q, V, W, response_under
from damperlab.studies.variables import Status
from damperlab.worker.ground.design import Structure
from damperlab.worker.ground.measures import GroundResponse


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
    absorber = absorber or NO_DAMPER
    found = response_under(absorber, structure.damping_ratio, structure.omega, motion, factor, tail_s)
    measures = {name: found.measure(name) for name in MEASURES}
    mu, gamma, two_zeta = absorber.mass_ratio, absorber.tuning, 2.0 * structure.damping_ratio
    power, dissipated = np.zeros((8, 8)), np.zeros((8, 8))
    power[[W, V], S_RATE] = -two_zeta, -1.0
    dissipated[W, W] = two_zeta
    dissipated[Q_RATE, Q_RATE] = 2.0 * mu * absorber.damping_ratio * gamma
    work, loss = found.integral(power), found.integral(dissipated)
    end = found.states[-1]
    u_rate = end[W] + end[S_RATE]
    stored = 0.5 * (u_rate**2 + end[V] ** 2 + mu * ((u_rate + end[Q_RATE]) ** 2 + gamma**2 * end[Q] ** 2))
    largest = max(abs(work), loss, stored)
    energy = structure.stiffness_n_per_m  # [J/m²], converts energies with time in units of 1/ω
    good = bool(np.isfinite(found.states).all())
    return GroundResponse(
        **measures,
        impacts=0,
        impact_speed_max_m_s=0.0,
        stick_fraction=0.0,
        work_in_j=work * energy,
        loss_viscous_j=loss * energy,
        loss_friction_j=0.0,
        loss_impact_j=0.0,
        energy_residual=abs(work - loss - stored) / largest if largest > 0.0 else nan,
        duration_s=found.duration / structure.omega,
        end_relative_displacement_m=end[V],
        end_relative_velocity_m_s=end[W] * structure.omega,
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
    absorber = absorber or NO_DAMPER
    found = response_under(absorber, structure.damping_ratio, structure.omega, motion, factor, tail_s)
    return {
        "time_s": np.arange(float(len(found.states))) * (found.window / structure.omega),
        "relative_displacement_m": found.states[:, V],
        "absolute_acceleration_m_s2": found.states @ found.acceleration * structure.omega**2,
    }
