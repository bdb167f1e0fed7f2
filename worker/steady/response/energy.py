"""Energy balance of a measured stretch of the motion, as a check of the solver."""

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.physics.compliant_wall import spring_energy
from damperlab.worker.physics.impact import kept_energy
from damperlab.worker.solver.observe.meter import (
    FRICTION_LOSS,
    IMPACT_LOSS,
    PARTICLE_LOSS,
    PEAK,
    RELATIVE_PEAK,
    VISCOUS_LOSS,
    WORK_IN,
)
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.sliding import fall_of
from damperlab.worker.solver.state import State


@kernel
def stored_energy(state: State, base_rate: float, particle: Particle | None) -> float:
    """Stored energy over k Z²: ½u'² + ½v² + ½βp'², plus the energies of a contact and of the particle's weight."""
    u_rate = state.w + base_rate
    energy = 0.5 * (u_rate * u_rate + state.v * state.v)
    if particle is not None:
        energy += 0.5 * particle.mass_ratio * state.p_rate * state.p_rate
        if particle.wall is not None:
            energy += spring_energy(particle.wall.stiffness, -state.gap)
        elif state.dwell is not None:
            if state.dwell.left > 0.0:  # energy recovered at the end of the dwell
                energy += kept_energy(state.dwell.speed, particle.restitution, particle.mass_ratio)
        if particle.gravity is not None:  # −βG (u − p), because the spring bears the weight at u = 0
            apart = state.wall * (particle.clearance_ratio - state.gap)
            of_height = particle.mass_ratio * fall_of(state.slide, particle) * apart
            energy += of_height
    return energy


@kernel
def energy_residual(sums: NDArray[np.float64], stored_before: float, stored_after: float) -> float:
    """Residual of the energy balance (see `unbalanced`), from the sums of a meter."""
    losses = sums[VISCOUS_LOSS] + sums[FRICTION_LOSS] + sums[IMPACT_LOSS] + sums[PARTICLE_LOSS]
    peak = max(sums[PEAK], sums[RELATIVE_PEAK])
    return unbalanced(sums[WORK_IN], losses, stored_before, stored_after, peak)


@kernel
def unbalanced(work: float, losses: float, stored_before: float, stored_after: float, peak: float) -> float:
    """Return the residual of the energy balance, relative to the largest energy.

    The residual is |input work − losses − change of stored energy|. The largest energy is the maximum of
    input work, losses, both stored energies and ½ peak². The term ½ peak² is the maximum if almost no net
    work is done: without losses, or with a locked mass.
    """
    scale = max(abs(work), losses, stored_before, stored_after, 0.5 * peak**2)
    if scale == 0.0:  # there is no motion, because friction withstands the force
        return 0.0
    return abs(work - losses - (stored_after - stored_before)) / scale
