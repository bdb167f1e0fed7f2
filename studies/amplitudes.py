"""Studies over base amplitudes: the damper keeps its force and clearance while the amplitude of the base varies."""

from collections.abc import Mapping
from typing import Any

from damperlab.studies.variables import DIMENSION_LONG_NAMES

AMPLITUDE = "base_amplitude_m"
"""The additional dimension of such a study: the base amplitude."""

RATIOS_OF: dict[str, str] = {"clearance_m": "clearance_ratio", "friction_force_n": "friction_ratio"}
"""The quantity that a damper keeps, and the ratio that falls as the base amplitude grows."""

CONSTANT: dict[str, int] = {"velocity": 1, "acceleration": 2}
"""Derivatives of the base motion that may be constant over the frequency instead of its displacement, and their
order.
"""

AT_NATURAL = "base amplitude Z at the natural frequency"
STATIC = "static displacement Z of the force"
"""Meaning of the dimension if a velocity or an acceleration is constant, and under a force."""

DIMENSIONS: dict[str, tuple[str, str]] = {
    "damping_ratio": ("1", DIMENSION_LONG_NAMES["damping_ratio"]),
    "restitution": ("1", DIMENSION_LONG_NAMES["restitution"]),
    "mass_ratio": ("1", DIMENSION_LONG_NAMES["mass_ratio"]),
    "clearance_m": ("m", "clearance d"),
    "friction_force_n": ("N", "friction force F_f"),
    AMPLITUDE: ("m", "base amplitude Z"),
    "frequency_ratio": ("1", DIMENSION_LONG_NAMES["frequency_ratio"]),
}
"""Unit and meaning of every dimension, in the cube's order."""

DAMPER = ("restitution", "mass_ratio", "clearance_m", "friction_force_n")
"""The dimensions that a designer chooses; the others are conditions that a damper must withstand."""


def is_axis(raw: object) -> bool:
    """Whether an entry of a physical block is an axis, written as a list or a range, and not one number."""
    return raw is not None and not isinstance(raw, int | float | str)


def over_amplitudes(physical: object, particle: bool) -> bool:
    """Whether a physical block describes dampers over base amplitudes, and not an axis of one ratio.

    This is so if the base amplitude is an axis that changes both ratios of a damper, or crosses an axis of its force
    or clearance. An axis that changes one ratio alone is an axis of that ratio.

    Parameters
    ----------
    physical : mapping or None
        As written in a document, or as stored with a study.
    particle : bool
        Whether the scene has a particle; without one there is no clearance.
    """
    if not isinstance(physical, Mapping) or not is_axis(physical.get(AMPLITUDE)):
        return False
    kept = kept_by_damper(physical, particle)
    return len(kept) == len(RATIOS_OF) or any(is_axis(value) for value in kept.values())


def base_amplitudes(amplitude_m: Any, frequency_ratio: Any, constant: str | None) -> Any:
    """Give the base amplitudes Z [m] at frequency ratios; arrays that broadcast.

    Parameters
    ----------
    amplitude_m, frequency_ratio : float or array
        Amplitude at the natural frequency [m], and excitation frequency over the natural frequency.
    constant : str or None
        A key of `CONSTANT`: a constant velocity V gives Z = V/ω, a constant acceleration A gives Z = A/ω². None for a
        constant displacement.
    """
    return amplitude_m if constant is None else amplitude_m / frequency_ratio ** CONSTANT[constant]


def kept_by_damper(physical: Mapping[str, Any], particle: bool) -> dict[str, Any]:
    """Give the entries of a physical block that stay constant while the base amplitude changes."""
    names = [name for name in RATIOS_OF if particle or name != "clearance_m"]
    return {name: physical[name] for name in names if physical.get(name) is not None}
