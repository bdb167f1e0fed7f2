"""The meter of an integration: the sums of its observables, and the index of each sum."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
RELATIVE_SQUARE = 11  # ∫ v² dτ, only under a record.
ACCELERATION_SQUARE = 12  # ∫ u''² dτ.
ACCELERATION_PEAK = 13  # Largest |u''| since the last reset or, under a record, of the complete motion.
METERS = 14


class Meter(NamedTuple):
    """Observables of an integration: peaks, times and speeds, and on request the integrals of energies and squares.

    Attributes
    ----------
    sums : array, shape (METERS,)
        The sums, which an integration increases. If an integration ends early, the sums cover the time until then.
    energies : True or None
        If None, energies and squares are not integrated, and their entries in `sums` are meaningless.
    acceleration : True or None
        True if u'' is measured, as always under a record; else None.
    """

    sums: NDArray[np.float64]
    energies: bool | None = True
    acceleration: bool | None = None
