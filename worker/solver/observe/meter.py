"""The meter of an integration: the sums of its observables, and the index of each sum."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined
from damperlab.worker.solver.array_loops import filled

# Indices of the sums of a meter. Energies are over k Z², and times over 1/ω_n.
# The first five sums and PARTICLE_LOSS are integrals.
WORK_IN = 0
VISCOUS_LOSS = 1
FRICTION_LOSS = 2
IMPACT_LOSS = 3
SQUARE = 4  # ∫ u² dτ.
STUCK = 5  # Time in which friction holds the mass.
SPEED = 6  # Largest approach speed of an impact.
PEAK = 7  # Largest |u| since the last reset.
RELATIVE_PEAK = 8  # Largest |v| since the last reset.
PARTICLE_LOSS = 9  # Energy lost by the friction of the particle.
SLIDING = 10  # Time in which the particle slides.
METERS = 11

# Additional sums of a meter under a record. Under a harmonic excitation, a meter with `acceleration` uses the last two.
RELATIVE_SQUARE = METERS  # ∫ v² dτ.
ACCELERATION_SQUARE = METERS + 1  # ∫ u''² dτ.
ACCELERATION_PEAK = METERS + 2  # Largest |u''|; under a harmonic excitation since the last reset.
RECORD_METERS = METERS + 3


class Meter(NamedTuple):
    """Observables of an integration: peaks, times and speeds, and on request the integrals of energies and squares.

    Attributes
    ----------
    sums : array, shape (METERS,) or (RECORD_METERS,)
        The sums, which an integration increases. The array is longer under a record and with `acceleration`. If an
        integration ends early, the sums cover the time until then.
    energies : True or None
        If None, energies and squares are not integrated, and their entries in `sums` are meaningless.
    acceleration : True or None
        True if u'' is measured, as always under a record; else None.
    """

    sums: NDArray[np.float64]
    energies: bool | None = True
    acceleration: bool | None = None


@inlined
def make_meter(energies: bool | None, acceleration: bool | None) -> Meter:
    """Make a meter of zeros for a harmonic excitation."""
    if acceleration is not None:
        return Meter(filled(RECORD_METERS, 0.0), energies, acceleration)
    return Meter(filled(METERS, 0.0), energies, None)


@inlined
def clear_meter(meter: Meter) -> None:
    """Reset all sums to zero."""
    for i in range(METERS):
        meter.sums[i] = 0.0
    if meter.acceleration is not None:
        for i in range(METERS, RECORD_METERS):
            meter.sums[i] = 0.0
