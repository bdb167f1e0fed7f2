"""Texts for the quantities of a design, as in a drawing and a report."""

from collections import Counter
from collections.abc import Iterator, Mapping
from math import ceil, floor, isfinite, log10
from typing import Any

from damperlab.studies import spelling
from damperlab.studies.design.build import Build
from damperlab.studies.faults import counted
from damperlab.studies.quantity import CAVITY_NAMES
from damperlab.studies.specification.excitation import Amplitude, Excitation, Motion, RecordCases
from damperlab.studies.specification.measure import DAMPER_LIMITS, LIMITS
from damperlab.studies.specification.specification import OF_DAMPER, RATIO_OF, Specification
from damperlab.studies.spelling import spelled
from damperlab.studies.variables import MADE_BY

CALLED = {
    "clearance_m": "clearance",
    "friction_force_n": "friction force",
    "particle_mass_kg": "particle mass",
    "restitution": "coefficient of restitution",
    **{name: words for name, (words, _, _) in CAVITY_NAMES.items()},
}
"""Names of the quantities of a damper."""
NOUNS = {
    "ground-motion record": "records",
    "sweep": "sweeps",
    "random vibration record": "random vibration records",
    "shock": "shocks",
}
"""Singular and plural of each kind of record."""
OVER = {"1": "", "m": " Z", "m/s": " ω_n·Z", "m/s²": " ω_n²·Z", "N": " k·Z", "kg": " M"}
"""Reference quantity of a limit that is given as a ratio, by the SI unit of the limit."""
SYMBOLS = {"clearance_m": "d/Z", "friction_force_n": "γ_F", "particle_mass_kg": "β", "restitution": "e"}


def quantity(asked: Specification, name: str, value: float, digits: int = 4) -> str:
    """Write a quantity of the damper in its unit, or as a ratio if the specification has no units."""
    if asked.in_units or name == "restitution":
        return spelling.quantity(name, value, digits)
    return f"{SYMBOLS[name]} = {value:.{digits}g}"


def material_of(asked: Specification, build: Build) -> str:
    """Name the material of a design, if the specification names materials."""
    return asked.choices["restitution"].called(build.restitution, build.contact_time_s)


def damper_words(asked: Specification, build: Build, digits: int = 3) -> str:
    """Write the quantities of a damper in one line: mass, clearance, friction, restitution.

    The line is empty if the damper has neither particle nor friction.
    """
    parts = []
    if build.particle_mass_kg:
        parts = [quantity(asked, "particle_mass_kg", build.particle_mass_kg, digits)]
        clearance = quantity(asked, "clearance_m", build.clearance_m, digits)
        parts.append(f"±{clearance} clearance" if asked.in_units else clearance)
    if build.friction_force_n:
        friction = quantity(asked, "friction_force_n", build.friction_force_n, digits)
        parts.append(f"{friction} friction" if asked.in_units else friction)
    if build.particle_mass_kg:
        called = material_of(asked, build)
        parts.append(f"e = {build.restitution:.{digits}g}{f' ({called})' if called else ''}")
        parts += [build.cavity.words] if {*asked.free}.intersection(MADE_BY.values()) else []
    return ", ".join(parts)


def allowing(asked: Specification, noise: float) -> str:
    """Describe the margin added to computed values.

    The confidence refers only to the error of the computed values, and not to the part of the margin for
    frequencies that were not computed.
    """
    error = f"for its error (confidence {asked.confidence:.3g}) and " if noise else ""
    return f"with a margin {error}for frequencies that were not computed,"


def response(asked: Specification, value: float, digits: int = 4) -> str:
    """Write a value of the measure; as a ratio to the base amplitude if there are no units."""
    if not isfinite(value):
        return "without bound"
    if asked.in_units:
        return spelled(value, asked.unit, digits)
    return f"{value:.{digits}g} times {_reference(asked)}{' times ω_n²' if asked.measure.order else ''}"


def limited(asked: Specification, limit: str, value: float) -> str:
    """Write a value that a limit restricts, in the unit of the document or as a ratio."""
    unit = (LIMITS[limit] if limit in LIMITS else DAMPER_LIMITS[limit]).unit
    if asked.in_units:
        return spelled(value, unit)
    return f"{value:.4g}{OVER[unit]}"


def rounded_up(value: float, digits: int = 4) -> float:
    """Round up to `digits` significant digits, because an advised limit must be sufficient."""
    if not isfinite(value) or value <= 0.0:
        return value
    scale = 10.0 ** (digits - 1 - floor(log10(value)))
    return float(f"{ceil(value * scale * (1.0 - 1e-12)) / scale:.{digits}g}")


def length(asked: Specification, value: float) -> str:
    """Write a displacement in the unit of lengths, or as a ratio to the base amplitude if there are no units."""
    return spelled(value, "m") if asked.in_units else f"{value:.4g} times {_reference(asked)}"


def _reference(asked: Specification) -> str:
    """Name the amplitude to which ratios refer."""
    several = (
        len({amplitude for each in asked.excitations for amplitude in (each.lowest_m, each.highest_m)}) > 1
    )
    varies = any(each.motion.order for each in asked.excitations)
    return f"the {'largest ' if several else ''}base amplitude{' at the natural frequency' if varies else ''}"


def level(asked: Specification, amplitude: Amplitude) -> str:
    """Write the amplitude of the constant quantity: a displacement, a velocity or an acceleration."""
    value, unit = asked.level(amplitude), amplitude.excitation.motion.unit
    # vibration velocities are usually given in millimetres per second
    return f"{1e3 * value:.4g} mm/s" if unit == "m/s" and value < 1.0 else spelled(value, unit)


def plural(motion: Motion) -> str:
    """Return the plural of the name of an excitation in sentences, for example "base velocities"."""
    return f"{motion.words.removesuffix('y')}ies" if motion.words.endswith("y") else f"{motion.words}s"


def comes_to(asked: Specification) -> str:
    """Return the verb for the measure: a response "reaches" a largest value, an rms over a band "comes to" a value."""
    return "comes to" if asked.measure.mean else "reaches"


def frequency(asked: Specification, ratio: float) -> str:
    """Write a frequency in hertz, or as a ratio if there are no units."""
    if asked.in_units:
        return f"{ratio * asked.structure.natural_frequency_hz:.4g} Hz"
    return f"r = {ratio:.4g}"


def under_records(records: RecordCases) -> str:
    """Name the records of an excitation. A single generated record is described by its definition."""
    scales, alone = records.scales, records.alone
    each = "each " if len(records.sources) > 1 else ""
    several = f", {each}at {counted(len(scales), 'scale')}" if len(scales) > 1 else ""
    if alone is not None:
        return f"{alone.words_at(scales[0] if len(scales) == 1 else 1.0)}{several}"
    counts = Counter(sorted(records.nouns, key=list(NOUNS).index))
    what = " and ".join(counted(count, noun) for noun, count in counts.items())
    single = "" if scales == (1.0,) else f", at a scale of {scales[0]:g}"
    return f"under {what}{several or single}"


def transients(asked: Specification) -> str:
    """Name the kind of a specification's records: records, sweeps, shocks, or several of these."""
    nouns = [noun for records in asked.records for noun in records.nouns]
    if len(nouns) == 1 and nouns[0] != "ground-motion record":
        return nouns[0]
    return " and ".join(words for noun, words in NOUNS.items() if noun in nouns)


def spelled_out(asked: Specification, excitation: Excitation) -> str:
    """Write an excitation: its band and, if there are units, its amplitudes."""
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


def best_so_far(known: Mapping[str, Any]) -> str:
    """Write the worst case and the values of the best damper so far.

    Parameters
    ----------
    known : mapping
        Result of `damperlab.studies.design.answer.known_document`; a service returns it for a running design.
    """
    keeps = "" if known["feasible"] else ", exceeds a limit"
    return f"{_worst(known['worst'])}{keeps}: {', '.join(_quantities(known['design']))}"


def _worst(worst: Mapping[str, Any]) -> str:
    if worst["value"] is None:
        return "no bounded response"
    value = spelled(worst["value"], worst["units"])
    if worst["units"] == "1":
        value += " times the base amplitude"
    if worst.get("record"):
        return f"{value} under {worst.get('record_name') or worst['record']} × {worst['scale']:g}"
    if worst.get("frequency_hz"):
        return f"{value} near {worst['frequency_hz']:.4g} Hz"
    return f"{value} near r = {worst['frequency_ratio']:.4g}" if worst.get("frequency_ratio") else value


def _quantities(design: Mapping[str, Any]) -> Iterator[str]:
    for name in OF_DAMPER:
        value, ratio = design.get(name), design.get(RATIO_OF.get(name, name))
        if value is not None:
            yield f"{CALLED[name]} {spelling.quantity(name, value)}"
        elif ratio is not None:
            yield f"{SYMBOLS[name]} = {ratio:.4g}"
