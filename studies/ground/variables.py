"""Dimensions and result variables of a ground-motion suite, in addition to those in `damperlab.studies.variables`."""

from damperlab.studies.spelling import unit_of, without_unit
from damperlab.studies.variables import DIMENSION_LONG_NAMES, Status, Variable

DIMENSIONS: dict[str, tuple[str, str]] = {
    "record": ("1", "ground-motion record"),
    "natural_frequency_hz": ("Hz", "natural frequency of the structure"),
    "damping_ratio": ("1", DIMENSION_LONG_NAMES["damping_ratio"]),
    "scale": ("1", "factor on the record"),
    "restitution": ("1", DIMENSION_LONG_NAMES["restitution"]),
    "particle_mass_kg": ("kg", "mass of the particle m"),
    "clearance_m": ("m", "clearance d"),
    "friction_force_n": ("N", "friction force F_f"),
}
"""Unit and meaning of each dimension of the cube, in order. Dimensions along which a block has few values
come first.
"""

SYMBOLS: dict[str, str] = {
    "natural_frequency_hz": "f_n",
    "particle_mass_kg": "m",
    "clearance_m": "d",
    "friction_force_n": "F_f",
}
"""The paper's symbols of quantities with a unit."""

RECORD = "record"
DAMPER = ("restitution", "particle_mass_kg", "clearance_m", "friction_force_n")
"""Dimensions that a designer chooses; all other dimensions are operating conditions."""

SPREAD: tuple[str, ...] = ("peak_relative_displacement", "peak_absolute_acceleration")
"""Measures for which statistics over the perturbed starts are stored."""

STATISTICS: dict[str, str] = {
    "lowest": "Smallest",
    "highest": "Largest",
    "mean": "Mean",
    "std": "Standard deviation",
}

_CF = {"": "1", "m/s": "m s-1", "m/s²": "m s-2"}
"""Spelling of units by the CF conventions, where it differs from the spelling in sentences."""
_SUFFIX = {"peak_relative_displacement": "_m", "peak_absolute_acceleration": "_m_s2"}


def spread_name(measure: str, statistic: str) -> str:
    """Return the name of a statistic over the perturbed starts, such as `peak_relative_displacement_lowest_m`."""
    return f"{measure}_{statistic}{_SUFFIX[measure]}"


def measure_name(measure: str) -> str:
    """Return the name of the variable of a measure in `SPREAD`."""
    return f"{measure}{_SUFFIX[measure]}"


def _variable(name: str, doc: str, start: str = "", rubbing: bool = False) -> Variable:
    units = _CF.get(unit_of(name), unit_of(name))
    dtype = {"impacts": "i4", "status": "i1"}.get(name, "f8")
    flags = Status if name == "status" else None
    return Variable(name, dtype, units, without_unit(name), doc, flags, start, rubbing=rubbing)


VARIABLES: dict[str, Variable] = {
    variable.name: variable
    for variable in (
        _variable("peak_relative_displacement_m", "Largest |x − z| of the primary mass against the base."),
        _variable("rms_relative_displacement_m", "Rms of x − z over record and tail."),
        _variable("peak_absolute_displacement_m", "Largest |x|, measured from the start."),
        _variable("rms_absolute_displacement_m", "Rms of x over record and tail."),
        _variable("peak_absolute_acceleration_m_s2", "Largest |x''|, without instantaneous impacts."),
        _variable("rms_absolute_acceleration_m_s2", "Rms of x'', without instantaneous impacts."),
        _variable("impacts", "Number of impacts."),
        _variable("impact_speed_max_m_s", "Largest approach speed of an impact."),
        _variable("stick_fraction", "Share of the time that friction held the mass."),
        _variable("work_in_j", "Work done by the base."),
        _variable("loss_viscous_j", "Energy lost to viscous damping."),
        _variable("loss_friction_j", "Energy lost to friction."),
        _variable("loss_impact_j", "Energy lost in impacts."),
        _variable("loss_particle_j", "Energy lost to the friction of the particle in its cavity.", rubbing=True),
        _variable(
            "energy_residual", "Residual of the energy balance, over the largest of work, losses, stored and peak energy."
        ),
        _variable("duration_s", "Duration of record and tail."),
        _variable("end_relative_displacement_m", "x − z at the end."),
        _variable("end_relative_velocity_m_s", "x' − z' at the end."),
        _variable("status", "How the computation ended."),
        *(
            _variable(
                spread_name(measure, statistic),
                f"{words} of {measure_name(measure)} over the perturbed starts.",
                "perturbed",
            )
            for measure in SPREAD
            for statistic, words in STATISTICS.items()
        ),
        _variable(
            "growth",
            "Largest change of a displacement, divided by the size of the perturbation. Above 100 the "
            "response is called sensitive.",
            "perturbed",
        ),
    )
}  # fmt: skip
"""Variables of a suite, in the order of the cube."""


def available_variables(starts: int, rubs: bool = False) -> tuple[str, ...]:
    """Return the names of the variables that a suite can compute. `rubs` states whether the particle has friction."""
    return tuple(v.name for v in VARIABLES.values() if (starts or not v.start) and (rubs or not v.rubbing))
