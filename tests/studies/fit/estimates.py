"""Outcomes of fits, written down for tests of what is made of them."""

from typing import Any

from damperlab.studies.fit.fitted import Estimate

BENCH: dict[str, Any] = {
    "damping_ratio": 0.0038,
    "axes": {"restitution": 0.47},
    "physical": {
        "mass_kg": 1.605,
        "natural_frequency_hz": 2.5,
        "base_amplitude_m": 0.0015,
        "particle_mass_kg": 0.1605,
        "clearance_m": 0.015,
        "friction_force_n": 0.2,
    },
}
"""A prototype of which everything is known."""


def estimate(name: str, value: float, low: float, high: float, *, determined: bool = True) -> Estimate:
    """Give a parameter with its interval."""
    share = (0.4, 0.6) if determined else (0.0, 1.0)
    return Estimate(name, value, low, high, 0.25 * (high - low), low / 2, 2 * high, *share)
