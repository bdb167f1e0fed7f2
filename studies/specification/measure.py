"""What of a response shall be small, and what of it may be limited: over a band, and under ground-motion records."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Measure:
    """What shall be small.

    Parameters
    ----------
    name : str
        As the specification has it.
    variable : str
        The result variable over Z that it is made of.
    factor : float
        What that is multiplied with, beside Z.
    words : str
        For sentences.
    limit : str
        The limit on the same result; empty where there is none.
    unit : str
        Of its values in a specification in units.
    """

    name: str
    variable: str
    factor: float
    words: str
    limit: str = ""
    unit: str = "m"


MEASURES = {
    each.name: each
    for each in (
        Measure(
            "worst_displacement", "amplitude_ratio", 1.0, "displacement of the structure", "displacement_m"
        ),
        Measure(
            "worst_relative_displacement",
            "relative_amplitude_ratio",
            1.0,
            "displacement of the structure against its base",
            "relative_displacement_m",
        ),
        Measure(
            "worst_rms_displacement",
            "amplitude_ratio_rms",
            math.sqrt(0.5),
            "rms displacement of the structure",
        ),
    )
}
"""What can be asked for; each the largest over the band and the amplitudes."""
RECORD_MEASURES = {
    each.name: each
    for each in (
        Measure(
            "worst_relative_displacement",
            "peak_relative_displacement_m",
            1.0,
            "displacement of the structure against its base",
            "relative_displacement_m",
        ),
        Measure(
            "worst_displacement",
            "peak_absolute_displacement_m",
            1.0,
            "displacement of the structure",
            "displacement_m",
        ),
        Measure(
            "worst_acceleration",
            "peak_absolute_acceleration_m_s2",
            1.0,
            "acceleration of the structure",
            "acceleration_m_per_s2",
            "m/s²",
        ),
        Measure(
            "worst_rms_relative_displacement",
            "rms_relative_displacement_m",
            1.0,
            "rms displacement of the structure against its base",
        ),
        Measure(
            "worst_rms_displacement", "rms_absolute_displacement_m", 1.0, "rms displacement of the structure"
        ),
        Measure(
            "worst_rms_acceleration",
            "rms_absolute_acceleration_m_s2",
            1.0,
            "rms acceleration of the structure",
            "rms_acceleration_m_per_s2",
            "m/s²",
        ),
    )
}
"""What can be asked for under records; each the largest over records and scales. The first is the default."""
MIXED_MEASURES = {name: each for name, each in MEASURES.items() if name in RECORD_MEASURES}
"""What can be asked for over bands and under records together: what both have, so that the worse of them can be told."""

LIMITED = {
    "displacement_m": ("amplitude_ratio", "displacement of the structure"),
    "relative_displacement_m": ("relative_amplitude_ratio", "stroke of the structure against its base"),
    "impact_speed_m_per_s": ("impact_speed_max", "impact speed"),
}
"""Limits on results over a band: the variable, and what it is called."""
UNDER_RECORDS_ALONE = {
    "acceleration_m_per_s2": "acceleration of the structure",
    "rms_acceleration_m_per_s2": "rms acceleration of the structure",
}
"""Limits on results that only a response to a record has, and what they are called."""
LIMIT_CALLED = {name: words for name, (_, words) in LIMITED.items()} | UNDER_RECORDS_ALONE
"""What every limit on a result is called."""
RECORD_LIMITED = {
    "displacement_m": "peak_absolute_displacement_m",
    "relative_displacement_m": "peak_relative_displacement_m",
    "impact_speed_m_per_s": "impact_speed_max_m_s",
    "acceleration_m_per_s2": "peak_absolute_acceleration_m_s2",
    "rms_acceleration_m_per_s2": "rms_absolute_acceleration_m_s2",
}
"""The variables of limits under records."""
