"""Names of the quantities in SI units that accompany ratios; loads no arrays, so that interfaces may use them early."""

from damperlab.studies.quantity import CAVITY_NAMES
from damperlab.studies.variables import MADE_BY, VARIABLES


def _length(long_name: str) -> str:
    """Give the name in units of a length that corresponds to a ratio."""
    named = long_name.replace("amplitude ratio X/Z", "amplitude of the structure X")
    return named.replace("amplitude ratio", "amplitude").replace("|x−z|/Z", "|x−z|")


AMPLITUDES: dict[str, str] = {
    name: f"{name.replace('amplitude_ratio', 'amplitude')}_m"
    for name in VARIABLES
    if "amplitude_ratio" in name or name == "amplitude_error"
}
"""Results that are lengths over the base amplitude, and their names in units."""

ACCELERATIONS: dict[str, str] = {
    name: f"{name.replace('acceleration_ratio', 'acceleration')}_m_per_s2"
    for name in VARIABLES
    if name.startswith("acceleration_ratio")
}
"""Results that are accelerations over Z·ω_n², and their names in units."""

SPEED = "impact_speed_max_m_per_s"
ENERGY = "dissipation_per_cycle_j"

OVER: dict[str, str] = {
    **dict.fromkeys(AMPLITUDES, "Z"),
    **dict.fromkeys(ACCELERATIONS, "Z·ω_n²"),
    "impact_speed_max": "Z·ω_n",
    "dissipation_per_cycle": "k·Z²",
}
"""The reference of each result that is a ratio; all others are counts, shares, codes and the like."""

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
"""The ratio that corresponds to each coordinate in units."""
ALIASES = {"excitation_frequency_hz": "frequency_hz"}
"""The coordinate in units for a name in the physical block of a study, if the two differ."""
RESULT_NAMES = {name: _length(VARIABLES[source].long_name) for source, name in AMPLITUDES.items()}
RESULT_NAMES |= {
    name: "acceleration of the structure" if source == "acceleration_ratio" else "rms acceleration, times √2"
    for source, name in ACCELERATIONS.items()
}
RESULT_NAMES[SPEED] = "largest approach speed at an impact"
RESULT_NAMES[ENERGY] = VARIABLES["dissipation_per_cycle"].long_name
LONG_NAMES = COORDINATE_NAMES | RESULT_NAMES
"""Long name of every coordinate and every result in units, by name."""


def with_what_it_is_over(name: str, long_name: str) -> str:
    """Append the reference quantity to a result's name if the name states neither it nor a unit: ``… over Z·ω_n``."""
    return long_name if name not in OVER or "/" in long_name else f"{long_name} over {OVER[name]}"


COORDINATES, RESULTS = tuple(COORDINATE_NAMES), tuple(RESULT_NAMES)
