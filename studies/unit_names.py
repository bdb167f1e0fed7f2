"""Names of the quantities in SI units that correspond to ratios, in a module that does not import numpy."""

from damperlab.studies.quantity import CAVITY_NAMES
from damperlab.studies.variables import MADE_BY, VARIABLES


def _length(long_name: str) -> str:
    """Return the long name of a length in SI units, from the long name of the corresponding ratio."""
    named = long_name.replace("amplitude ratio X/Z", "amplitude of the structure X")
    return named.replace("amplitude ratio", "amplitude").replace("|x−z|/Z", "|x−z|")


AMPLITUDES: dict[str, str] = {
    name: f"{name.replace('amplitude_ratio', 'amplitude')}_m"
    for name in VARIABLES
    if "amplitude_ratio" in name or name == "amplitude_error"
}
"""Name in SI units of each result that is a length over the base amplitude."""

ACCELERATIONS: dict[str, str] = {
    name: f"{name.replace('acceleration_ratio', 'acceleration')}_m_per_s2"
    for name in VARIABLES
    if name.startswith("acceleration_ratio")
}
"""Name in SI units of each result that is an acceleration over Z·ω_n²."""

SPEED = "impact_speed_max_m_per_s"
ENERGY = "dissipation_per_cycle_j"

OVER: dict[str, str] = {
    **dict.fromkeys(AMPLITUDES, "Z"),
    **dict.fromkeys(ACCELERATIONS, "Z·ω_n²"),
    "impact_speed_max": "Z·ω_n",
    "dissipation_per_cycle": "k·Z²",
}
"""Reference quantity of each result that is a ratio."""

COORDINATE_NAMES = {
    "clearance_m": "clearance d on either side",
    "friction_force_n": "friction force",
    "particle_mass_kg": "mass of the particle m",
    "frequency_hz": "excitation frequency",
    **{name: f"{words} {symbol}" for name, (words, symbol, _) in CAVITY_NAMES.items()},
}
COORDINATE_SOURCES = {
    "clearance_m": "clearance_ratio",
    "friction_force_n": "friction_ratio",
    "particle_mass_kg": "mass_ratio",
    "frequency_hz": "frequency_ratio",
    **{name: ratio for ratio, name in MADE_BY.items()},
}
"""The ratio that corresponds to each coordinate in SI units."""
ALIASES = {"excitation_frequency_hz": "frequency_hz"}
"""Name in SI units of each coordinate that has a different name in the physical block of a study."""
RESULT_NAMES = {name: _length(VARIABLES[source].long_name) for source, name in AMPLITUDES.items()}
RESULT_NAMES |= {
    name: "acceleration of the structure" if source == "acceleration_ratio" else "rms acceleration, times √2"
    for source, name in ACCELERATIONS.items()
}
RESULT_NAMES[SPEED] = "largest approach speed at an impact"
RESULT_NAMES[ENERGY] = VARIABLES["dissipation_per_cycle"].long_name
LONG_NAMES = COORDINATE_NAMES | RESULT_NAMES
"""Long name of every coordinate and every result in SI units, by name."""


def with_what_it_is_over(name: str, long_name: str) -> str:
    """Return the long name of a result.

    If the result is a ratio and its long name has no slash, the reference is added, as in ``… over Z·ω_n``.
    """
    return long_name if name not in OVER or "/" in long_name else f"{long_name} over {OVER[name]}"


COORDINATES, RESULTS = tuple(COORDINATE_NAMES), tuple(RESULT_NAMES)
