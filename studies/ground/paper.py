"""The paper's results for an earthquake (Table A1), and the quantities needed to reproduce them."""

import math

from damperlab.studies.paper import paper_numbers
from damperlab.studies.vocabulary import CASES

TABLE_A1: dict[str, tuple[float, float]] = {
    case: (
        paper_numbers()[f"earthquake_peak_{case}_m"].value,
        paper_numbers()[f"earthquake_rms_{case}_m"].value,
    )
    for case in CASES
}
"""Maximum and rms amplitude of the primary structure [m] with each damper."""

CLEARANCES_M: tuple[float, ...] = tuple(paper_numbers()[f"clearance_{k}_mm"].value / 1e3 for k in (1, 2, 3))
"""Clearances of the three cavities of the prototype, half the free length [m]. Table A1 does not name the cavity."""

BASE_AMPLITUDES_M: tuple[float, ...] = tuple(
    clearance / paper_numbers()[f"clearance_ratio_{k}"].value for k, clearance in enumerate(CLEARANCES_M, 1)
)
"""Base amplitudes Z [m], computed from each of the paper's three pairs of d and d/Z. The three values differ."""


def friction_force_n(base_amplitude_m: float, stiffness_n_per_m: float, damping_ratio: float) -> float:
    """Return the friction force of the prototype at 4 mm of spring compression [N].

    The paper states X/Z = 16.22 in Table 3, from which the force follows. At resonance with the friction damper alone,
    A/Z = (1 − 4γ_F/π)/(2ζ) to first order, where A is the amplitude relative to the base. The relative motion lags the
    motion of the base by a quarter of a period, so X/Z = √(1 + (A/Z)²).
    """
    relative = math.sqrt(paper_numbers()["friction_alone"].value ** 2 - 1.0)
    return math.pi / 4.0 * (1.0 - 2.0 * damping_ratio * relative) * stiffness_n_per_m * base_amplitude_m


SOURCE_NOTE = (
    "The paper shook the structure with MATLAB's `quake`, the Loma Prieta earthquake recorded at Santa Cruz. That "
    "record may not be redistributed; the built-in record of the same earthquake is from Corralitos. The paper gives "
    "neither clearance, friction force nor scale of that run. It does not say whether its amplitude is against the "
    "base or absolute."
)
"""Reasons why Table A1 cannot be reproduced digit by digit."""
