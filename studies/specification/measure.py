"""Measures to minimise and results to limit, over a band of frequencies or under ground-motion records."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Measure:
    """The measure to minimise.

    Parameters
    ----------
    name : str
        Name in the specification.
    variable : str
        The result variable on which the measure is based: a ratio over a band, a quantity in SI units under a record.
    factor : float
        Over a band, the measure is the variable times `factor`, times Z, and times ω_n to the power of `order`.
    words : str
        Name in sentences.
    limit : str
        Name of the limit on the same result; empty if this result cannot be limited.
    unit : str
        Unit of the measure in a specification in units.
    order : int
        Order of the time derivative in a measure over a band: 0 for a displacement, 2 for an acceleration.
    mean : bool
        Whether the measure is the rms over the band instead of the largest value. The mean is taken over the
        frequency, not over the logarithm of the frequency.
    """

    name: str
    variable: str
    factor: float
    words: str
    limit: str = ""
    unit: str = "m"
    order: int = 0
    mean: bool = False

    @property
    def of_displacement(self) -> bool:
        """Whether the measure is the displacement amplitude of the structure. Every response has this result."""
        return self.variable == "amplitude_ratio"

    @property
    def judged(self) -> str:
        """Name of the minimised value in sentences. If `mean` is true, the name mentions the band."""
        return f"{self.words} over the whole band" if self.mean else self.words


RMS = math.sqrt(0.5)
"""Ratio of the rms value of a sine to its amplitude."""
_MOVED, _STROKE = "displacement of the structure", "displacement of the structure against its base"
_SHAKEN = "acceleration of the structure"

MEASURES = {
    each.name: each
    for each in (
        Measure("worst_displacement", "amplitude_ratio", 1.0, _MOVED, "displacement_m"),
        Measure("worst_relative_displacement", "relative_amplitude_ratio", 1.0, _STROKE, "relative_displacement_m"),
        Measure("worst_rms_displacement", "amplitude_ratio_rms", RMS, f"rms {_MOVED}"),
        Measure("worst_acceleration", "acceleration_ratio", 1.0, _SHAKEN, "acceleration_m_per_s2", "m/s²", 2),
        Measure(
            "worst_rms_acceleration", "acceleration_ratio_rms", RMS, f"rms {_SHAKEN}", "rms_acceleration_m_per_s2", "m/s²", 2
        ),
        Measure("rms_displacement", "amplitude_ratio_rms", RMS, f"rms {_MOVED}", mean=True),
        Measure("rms_acceleration", "acceleration_ratio_rms", RMS, f"rms {_SHAKEN}", "", "m/s²", 2, mean=True),
    )
}  # fmt: skip
"""Measures over bands: the largest value or the rms over the band, for the worst of all base amplitudes."""
RECORD_MEASURES = {
    each.name: each
    for each in (
        Measure("worst_relative_displacement", "peak_relative_displacement_m", 1.0, _STROKE, "relative_displacement_m"),
        Measure("worst_displacement", "peak_absolute_displacement_m", 1.0, _MOVED, "displacement_m"),
        Measure("worst_acceleration", "peak_absolute_acceleration_m_s2", 1.0, _SHAKEN, "acceleration_m_per_s2", "m/s²"),
        Measure("worst_rms_relative_displacement", "rms_relative_displacement_m", 1.0, f"rms {_STROKE}"),
        Measure("worst_rms_displacement", "rms_absolute_displacement_m", 1.0, f"rms {_MOVED}"),
        Measure(
            "worst_rms_acceleration", "rms_absolute_acceleration_m_s2", 1.0, f"rms {_SHAKEN}",
            "rms_acceleration_m_per_s2", "m/s²",
        ),
    )
}  # fmt: skip
"""Measures under records: the largest value over records and scales. The first measure is the default."""
MIXED_MEASURES = {name: each for name, each in MEASURES.items() if name in RECORD_MEASURES}
"""Measures for a specification with both bands and records: those that exist for both kinds of excitation."""


ACCELERATIONS = frozenset(("acceleration_ratio", "acceleration_ratio_rms"))
"""Results over a band that are divided by Z·ω_n²."""


@dataclass(frozen=True)
class Limit:
    """A result of a response on which a specification may set a limit.

    Parameters
    ----------
    name : str
        Name in the specification.
    words : str
        Name in sentences.
    unit : str
        Unit of the limit; 1 for a plain number.
    over_band : tuple of str
        The result variables over a band, whose product is limited.
    under_record : str
        The result variable under a record; empty if records have no such result.
    ratio : str
        Name of the limit as a ratio. A length is divided by the largest base amplitude Z, a speed by ω_n Z, and an
        acceleration or noise by ω_n² Z.
    factor : float
        Over a band, the limited quantity is the product of the variables in `over_band`, of `factor`, and of
        powers of Z and ω_n.
    per_second : bool
        Whether one variable in `over_band` is a count per cycle, which the excitation frequency converts to a count
        per second.
    """

    name: str
    words: str
    unit: str
    over_band: tuple[str, ...]
    under_record: str
    ratio: str = ""
    factor: float = 1.0
    per_second: bool = False

    def has_error(self, by_records: bool) -> bool:
        """Return whether results have an error estimate.

        A length always has an error estimate; an acceleration has an error estimate only over a band.
        """
        return self.unit == "m" or (not by_records and self.over_band[0] in ACCELERATIONS)


LIMITS = {
    each.name: each
    for each in (
        Limit("displacement_m", _MOVED, "m", ("amplitude_ratio",), "peak_absolute_displacement_m", "displacement_ratio"),
        Limit(
            "relative_displacement_m", "stroke of the structure against its base", "m",
            ("relative_amplitude_ratio",), "peak_relative_displacement_m", "relative_displacement_ratio",
        ),
        Limit(
            "impact_speed_m_per_s", "impact speed", "m/s",
            ("impact_speed_max",), "impact_speed_max_m_s", "impact_speed_ratio",
        ),
        Limit(
            "impact_noise_m_per_s2", "impact noise (impacts per second times impact speed)", "m/s²",
            ("impacts_per_cycle", "impact_speed_max"), "", "impact_noise_ratio", per_second=True,
        ),
        Limit(
            "stick_fraction", "share of the time that friction holds the structure", "1",
            ("stick_fraction",), "stick_fraction", "stick_fraction",
        ),
        Limit(
            "acceleration_m_per_s2", _SHAKEN, "m/s²",
            ("acceleration_ratio",), "peak_absolute_acceleration_m_s2", "acceleration_ratio",
        ),
        Limit(
            "rms_acceleration_m_per_s2", f"rms {_SHAKEN}", "m/s²",
            ("acceleration_ratio_rms",), "rms_absolute_acceleration_m_s2", "rms_acceleration_ratio", RMS,
        ),
    )
}  # fmt: skip
"""Limits on results. Each limit applies to the largest value over all excitations."""


ROUNDING = 1e-9
"""Relative tolerance of limits on the damper itself. Without a tolerance, 1.1 × 30 N would exceed 33 N by rounding."""


@dataclass(frozen=True)
class DamperLimit:
    """A property of the damper on which a specification may set a limit.

    The limit applies to the damper as built, including tolerances.

    Parameters
    ----------
    name : str
        Name in the specification.
    words : str
        Name in sentences.
    unit : str
        Unit of the limit.
    ratio : str
        Name of the limit as a ratio.
    quantity : str
        The quantity of the damper that determines the property, one of `CHOSEN`.
    factor : float
        Factor from the quantity to the property.
    """

    name: str
    words: str
    unit: str
    ratio: str
    quantity: str
    factor: float = 1.0

    def excess(self, reached: float, limit: float) -> float:
        """Return the share by which a value exceeds a limit; 0 if the value is within the limit."""
        share = reached / limit - 1.0 if limit else float("inf" if reached else 0.0)
        return share if share > ROUNDING else 0.0


DAMPER_LIMITS = {
    each.name: each
    for each in (
        DamperLimit("cavity_length_m", "free cavity length", "m", "cavity_length_ratio", "clearance_m", 2.0),
        DamperLimit("friction_force_n", "friction force", "N", "friction_ratio", "friction_force_n"),
        DamperLimit("particle_mass_kg", "particle mass", "kg", "mass_ratio", "particle_mass_kg"),
    )
}
"""Limits on the damper itself."""
EVERY_LIMIT: dict[str, Limit | DamperLimit] = {**LIMITS, **DAMPER_LIMITS}
"""All limits, on results and on the damper itself."""
