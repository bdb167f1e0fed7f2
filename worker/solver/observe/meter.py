"""The meter of an integration: its sums, and their positions in the array."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined
from damperlab.worker.solver.array_loops import filled

# Sums of a meter; energies over k Z², times over 1/ω_n. The first five and PARTICLE_LOSS are integrals.
WORK_IN = 0
VISCOUS_LOSS = 1
FRICTION_LOSS = 2
IMPACT_LOSS = 3
SQUARE = 4  # ∫ u² dτ
STUCK = 5  # time in which friction holds the mass
SPEED = 6  # largest approach speed of an impact
PEAK = 7  # largest |u| since the last reset
RELATIVE_PEAK = 8  # largest |v| since the last reset
PARTICLE_LOSS = 9  # to the friction of the particle
SLIDING = 10  # time in which the particle slides
METERS = 11

# Additional sums of a record's meter; a meter with acceleration has the last two as well.
RELATIVE_SQUARE = METERS  # ∫ v² dτ
ACCELERATION_SQUARE = METERS + 1  # ∫ u''² dτ
ACCELERATION_PEAK = METERS + 2  # largest |u''|; under a harmonic excitation since the last reset
RECORD_METERS = METERS + 3


class Meter(NamedTuple):
    """Observables of an integration: peaks, times and speeds, and on request the integrals of energies and squares.

    Attributes
    ----------
    sums : array, shape (METERS,) or (RECORD_METERS,)
        The sums, which grow; the longer array under a record and with the acceleration. If an integration ends early,
        they are those up to that time.
    energies : True or None
        With None, the kernel integrates no energy and no square, and their entries are meaningless.
    acceleration : True or None
        Whether u'' is measured too, as it always is under a record. With None, the kernel contains no code for it.
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
