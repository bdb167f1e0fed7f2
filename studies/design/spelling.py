"""Quantities of a design as a drawing and a report write them."""

from math import ceil, floor, isfinite, log10

from damperlab.studies import spelling
from damperlab.studies.faults import counted
from damperlab.studies.specification.excitation import Amplitude, Excitation, Motion
from damperlab.studies.specification.measure import DAMPER_LIMITS, LIMITS
from damperlab.studies.specification.records import RecordCases
from damperlab.studies.specification.specification import Specification
from damperlab.studies.spelling import spelled

CALLED = {
    "clearance_m": "clearance",
    "friction_force_n": "friction force",
    "particle_mass_kg": "particle mass",
    "restitution": "coefficient of restitution",
}
"""What the quantities of a damper are called."""
OVER = {"1": "", "m": " Z", "m/s": " ω_n·Z", "m/s²": " ω_n²·Z", "N": " k·Z", "kg": " M"}
"""What a limit is over where there are no units, by the unit that it has else."""
SYMBOLS = {"clearance_m": "d/Z", "friction_force_n": "γ_F", "particle_mass_kg": "β", "restitution": "e"}


def quantity(asked: Specification, name: str, value: float, digits: int = 4) -> str:
    """Write a quantity of the damper in its unit, or as the ratio that it makes where there are no units."""
    if asked.in_units or name == "restitution":
        return spelling.quantity(name, value, digits)
    return f"{SYMBOLS[name]} = {value:.{digits}g}"


def allowing(asked: Specification, noise: float) -> str:
    """Say what is added to what was computed: an error has a confidence, the allowance for other frequencies has none."""
    error = f"for its error (confidence {asked.confidence:.3g}) and " if noise else ""
    return f"allowing {error}for frequencies between those computed"


def response(asked: Specification, value: float, digits: int = 4) -> str:
    """Write a value of the measure; over the base amplitude where there are no units."""
    if not isfinite(value):
        return "without bound"
    if asked.in_units:
        return spelled(value, asked.unit, digits)
    return f"{value:.{digits}g} times {_reference(asked)}{' times ω_n²' if asked.measure.order else ''}"


def limited(asked: Specification, limit: str, value: float) -> str:
    """Write a value of what a limit is about, given as the document has it: in its unit, or as a ratio."""
    unit = (LIMITS[limit] if limit in LIMITS else DAMPER_LIMITS[limit]).unit
    if asked.in_units:
        return spelled(value, unit)
    return f"{value:.4g}{OVER[unit]}"


def rounded_up(value: float, digits: int = 4) -> float:
    """Give the least number of so many digits that is not less: what one is told to allow must be enough."""
    if not isfinite(value) or value <= 0.0:
        return value
    scale = 10.0 ** (digits - 1 - floor(log10(value)))
    return float(f"{ceil(value * scale * (1.0 - 1e-12)) / scale:.{digits}g}")


def length(asked: Specification, value: float) -> str:
    """Write a displacement, whatever is measured; over the base amplitude where there are no units."""
    return spelled(value, "m") if asked.in_units else f"{value:.4g} times {_reference(asked)}"


def _reference(asked: Specification) -> str:
    """Name what ratios are over."""
    several = (
        len({amplitude for each in asked.excitations for amplitude in (each.lowest_m, each.highest_m)}) > 1
    )
    varies = any(each.motion.order for each in asked.excitations)
    return f"the {'largest ' if several else ''}base amplitude{' at the natural frequency' if varies else ''}"


def level(asked: Specification, amplitude: Amplitude) -> str:
    """Write the amplitude of what is constant over the band: a displacement, a velocity or an acceleration."""
    value, unit = asked.level(amplitude), amplitude.excitation.motion.unit
    # vibration velocities are read in millimetres per second
    return f"{1e3 * value:.4g} mm/s" if unit == "m/s" and value < 1.0 else spelled(value, unit)


def plural(motion: Motion) -> str:
    """Name several amplitudes of what is constant over the band."""
    return f"{motion.words.removesuffix('y')}ies" if motion.words.endswith("y") else f"{motion.words}s"


def comes_to(asked: Specification) -> str:
    """Give the verb of the measure: a response reaches its largest value, and an rms over a band is nowhere."""
    return "comes to" if asked.measure.mean else "reaches"


def frequency(asked: Specification, ratio: float) -> str:
    """Write a frequency."""
    if asked.in_units:
        return f"{ratio * asked.structure.natural_frequency_hz:.4g} Hz"
    return f"r = {ratio:.4g}"


def under_records(records: RecordCases) -> str:
    """Write what of the ground-motion records and sweeps shakes a structure; a sweep by itself with all that it is."""
    scales, sweeps = records.scales, records.sweeps
    each = "each " if len(records.sources) > 1 else ""
    several = f", {each}at {counted(len(scales), 'scale')}" if len(scales) > 1 else ""
    if len(sweeps) == len(records.sources) == 1:
        return sweeps[0].words_at(scales[0]) if len(scales) == 1 else f"{sweeps[0].words}{several}"
    recorded = len(records.sources) - len(sweeps)
    what = " and ".join(
        counted(count, noun)
        for count, noun in ((recorded, "ground-motion record"), (len(sweeps), "sweep"))
        if count
    )
    single = "" if scales == (1.0,) else f", at a scale of {scales[0]:g}"
    return f"under {what}{several or single}"


def transients(asked: Specification) -> str:
    """Write what the records of a specification are, all together: records, sweeps, or both."""
    every = [source.sweep is not None for records in asked.records for source in records.sources]
    if all(every):
        return "sweeps" if len(every) > 1 else "sweep"
    return "records and sweeps" if any(every) else "records"


def spelled_out(asked: Specification, excitation: Excitation) -> str:
    """Write an excitation: its band, and its amplitudes where there are units."""
    low, high = frequency(asked, excitation.low), frequency(asked, excitation.high)
    over = f"from {low} to {high}" if excitation.high > excitation.low else f"at {low}"
    if not asked.in_units:
        return over
    least, most = (
        level(asked, Amplitude(excitation, each)) for each in (excitation.lowest_m, excitation.highest_m)
    )
    if excitation.highest_m > excitation.lowest_m:
        return f"{over} with {plural(excitation.motion)} from {least} to {most}"
    return f"{over} with a {excitation.motion.words} of {least}"
