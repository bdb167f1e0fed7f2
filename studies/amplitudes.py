"""Studies over base amplitudes: friction force and clearance are constant while the amplitude of the base varies."""

from collections.abc import Mapping
from typing import Any

from damperlab.studies.variables import DIMENSION_LONG_NAMES

AMPLITUDE = "base_amplitude_m"
"""Dimension of the base amplitude, which only studies over base amplitudes have."""

RATIOS_OF: dict[str, str] = {"clearance_m": "clearance_ratio", "friction_force_n": "friction_ratio"}
"""For each quantity that stays constant, the ratio that falls as the base amplitude grows."""

CONSTANT: dict[str, int] = {"velocity": 1, "acceleration": 2}
"""Derivatives of the base displacement whose amplitude can be constant over frequency, and their orders."""

AT_NATURAL = "base amplitude Z at the natural frequency"
STATIC = "static displacement Z of the force"
"""Long names of the dimension `AMPLITUDE` for a constant velocity or acceleration of the base, and for a force."""

DIMENSIONS: dict[str, tuple[str, str]] = {
    "damping_ratio": ("1", DIMENSION_LONG_NAMES["damping_ratio"]),
    "restitution": ("1", DIMENSION_LONG_NAMES["restitution"]),
    "mass_ratio": ("1", DIMENSION_LONG_NAMES["mass_ratio"]),
    "clearance_m": ("m", "clearance d"),
    "friction_force_n": ("N", "friction force F_f"),
    AMPLITUDE: ("m", "base amplitude Z"),
    "frequency_ratio": ("1", DIMENSION_LONG_NAMES["frequency_ratio"]),
}
"""Unit and meaning of every dimension, in the order of the cube."""

DAMPER = ("restitution", "mass_ratio", "clearance_m", "friction_force_n")
"""Dimensions that a designer chooses. The other dimensions are conditions that the damper must withstand."""


def is_axis(raw: object) -> bool:
    """Return whether an entry of a physical block is a list or a range instead of a single number."""
    return raw is not None and not isinstance(raw, int | float | str)


def over_amplitudes(physical: object, particle: bool) -> bool:
    """Return whether a physical block describes a study over base amplitudes.

    The base amplitude must be an axis. In addition, the block must contain the friction force and the clearance. One of
    these two suffices if it is an axis. Otherwise the base amplitude affects only one ratio, and its values are
    converted to values of this ratio.

    Parameters
    ----------
    physical : mapping or None
        The block as written in a document, or as stored with a study.
    particle : bool
        Whether the scene has a particle. Without a particle there is no clearance.
    """
    if not isinstance(physical, Mapping) or not is_axis(physical.get(AMPLITUDE)):
        return False
    kept = kept_by_damper(physical, particle)
    return len(kept) == len(RATIOS_OF) or any(is_axis(value) for value in kept.values())


def base_amplitudes(amplitude_m: Any, frequency_ratio: Any, constant: str | None) -> Any:
    """Return the base amplitudes Z [m] at frequency ratios.

    Parameters
    ----------
    amplitude_m, frequency_ratio : float or array
        Amplitude at the natural frequency [m], and excitation frequency over the natural frequency. Arrays must
        broadcast together.
    constant : str or None
        A key of `CONSTANT`, or None for a constant displacement. A constant velocity V gives Z = V/ω. A constant
        acceleration A gives Z = A/ω².
    """
    return amplitude_m if constant is None else amplitude_m / frequency_ratio ** CONSTANT[constant]


def kept_by_damper(physical: Mapping[str, Any], particle: bool) -> dict[str, Any]:
    """Return the entries of a physical block that stay constant while the base amplitude changes."""
    names = [name for name in RATIOS_OF if particle or name != "clearance_m"]
    return {name: physical[name] for name in names if physical.get(name) is not None}
