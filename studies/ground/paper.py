"""The paper's results for earthquakes: Table A1, and the possible readings of its numbers."""

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
"""Maximum and rms amplitude of the primary structure [m] by damper."""

CLEARANCES_M: tuple[float, ...] = tuple(paper_numbers()[f"clearance_{k}_mm"].value / 1e3 for k in (1, 2, 3))
"""The cavities of the prototype: half of their free length [m]. Table A1 does not say which cavity was used."""

BASE_AMPLITUDES_M: tuple[float, ...] = tuple(
    clearance / paper_numbers()[f"clearance_ratio_{k}"].value for k, clearance in enumerate(CLEARANCES_M, 1)
)
"""Base amplitudes Z [m] that follow from the paper's pairs of d and d/Z: three different values."""


def friction_force_n(base_amplitude_m: float, stiffness_n_per_m: float, damping_ratio: float) -> float:
    """Friction of the prototype at 4 mm of spring compression [N]. The paper does not state it; it follows from X/Z =
    16.22 in Table 3.

    At resonance the friction damper alone has A/Z = (1 − 4γ_F/π)/(2ζ) to first order, with A the amplitude against the
    base. That motion is a quarter of a period behind the base, so X/Z = √(1 + (A/Z)²).
    """
    relative = math.sqrt(paper_numbers()["friction_alone"].value ** 2 - 1.0)
    return math.pi / 4.0 * (1.0 - 2.0 * damping_ratio * relative) * stiffness_n_per_m * base_amplitude_m


SOURCE_NOTE = (
    "The paper shook the structure with MATLAB's `quake`, the Loma Prieta earthquake recorded at Santa "
    "Cruz. That "
    "record may not be redistributed; the built-in record of the same earthquake is from Corralitos. The "
    "paper gives neither "
    "clearance, friction force nor scale of that run. It does not say whether its amplitude is against the "
    "base or absolute."
)
"""Reasons why Table A1 cannot be reproduced digit by digit."""
