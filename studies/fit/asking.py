"""Assemble the definition of a fit from a measurement, known values and parameters, and report every fault."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from damperlab.studies.faults import NOTHING, Fault, StudyFaults, attempt, describe, listing, nearest
from damperlab.studies.fit.measured import Measurement
from damperlab.studies.fit.question import BESIDE_AXES, FREE, NAMED, RATIO_OF, FitQuestion, Free, drop
from damperlab.studies.quantity import RATIOS, Quantity
from damperlab.studies.variables import BEFORE
from damperlab.studies.vocabulary import OF_PARTICLE

MOST_FREE = 5
DEVIATION = Quantity(
    "deviation",
    "standard deviation as a share of each amplitude",
    1e-12,
    1.0,
    "write 0.05 for a standard deviation of 5 %",
)
CONFIDENCE = Quantity(
    "confidence", "confidence of the intervals", 0.5, 0.9999, "write 0.95 for intervals of 95 %"
)
FRICTIONLESS = " (0 for a structure without friction)"
DEFAULT_RANGES: dict[str, tuple[float, float]] = {
    "damping_ratio": (0.0, 0.1),
    "restitution": (0.0, 1.0),
    "mass_ratio": (0.0, 0.5),
    "friction_ratio": (0.0, 1.2),
    "particle_friction_coefficient": (0.0, 0.5),
}
"""Default ranges of parameters. A friction ratio above its range would lock the structure at resonance."""


def make_question(
    measured: Measurement,
    structure: Mapping[str, Any],
    fit: Mapping[str, tuple[float, float] | None],
    *,
    known: Mapping[str, float] | None = None,
    share: float | None = None,
    confidence: float = 0.95,
    seed: int = 0,
) -> FitQuestion:
    """Assemble the definition of a fit and check it.

    Parameters
    ----------
    measured : Measurement
        The measured frequency response.
    structure : mapping
        The known values in the form of a study: `damping_ratio`, `axes`, `physical`, `particle`, `contact`, `start`,
        `steady`. A quantity with an axis is a parameter to estimate within the range of the axis. Frequencies are
        ignored.
    fit : mapping
        The parameters to estimate and their ranges: (lowest, highest), or None for the default range.
    known : mapping, optional
        Numbers that override numbers in `structure`. The keys are names of `NAMED`.
    share : float, optional
        Standard deviation of each amplitude as a share of the amplitude, if the measurement states none.
    confidence : float
        Confidence of the intervals.
    seed : int
        Seed of all random draws.

    Raises
    ------
    StudyFaults
        If, for example, a quantity is neither known, estimated nor measured, a range has impossible values, no
        parameter is estimated, or there are at least as many parameters as rows. The exception contains all
        faults.
    """
    faults: list[Fault] = []
    numbers, ranges, settings, usual = gathered(structure, known or {}, fit, faults)
    faults += [not_free(name, FREE) for name in ranges if name not in FREE]
    ranges = {name: span or _usual(name, usual, measured) for name, span in ranges.items() if name in FREE}
    free = read_ranges(ranges, faults)
    faults += faults_between(tuple(ranges), FREE, "friction_ratio: [0, 1]")
    if measured.rows <= len(ranges):
        told = f"{measured.rows} measured amplitudes cannot determine {len(ranges)} parameters."
        allowed = f"more than {len(ranges)} rows"
        faults.append(Fault("measured", f"{measured.rows} rows", allowed, "measure more", told))
    faults += faults_of_confidence(confidence, share)
    if faults:
        raise StudyFaults(faults)
    question = FitQuestion(measured, numbers, tuple(free), settings, share, confidence, seed)
    _check(question)
    return question


def gathered(
    structure: Mapping[str, Any],
    known: Mapping[str, float],
    fit: Mapping[str, tuple[float, float] | None],
    faults: list[Fault],
) -> tuple[dict[str, float], dict[str, tuple[float, float] | None], dict[str, Any], dict[str, float]]:
    """Combine the known values and the parameters of a fit; see `make_question`.

    Returns
    -------
    numbers : dict of float
        Known values, without those of estimated parameters.
    ranges : dict
        Range of each parameter to estimate; None for the default range.
    settings : dict
        Other entries of `structure`.
    usual : dict of float
        Typical values, from which default ranges follow: all given numbers, and the middle of each axis.
    """
    numbers, ranges, settings = taken_apart(structure, faults)
    faults += _twice([*known, *(name for name in fit if name in known)])
    for name, value in known.items():
        for of in (numbers, ranges):
            drop(of, name)
        numbers |= read_number(name, value, faults)
    usual = numbers | {name: 0.5 * (span[0] + span[1]) for name, span in ranges.items() if span is not None}
    for name in fit:
        drop(numbers, name)
        ranges.pop(name, None)
    return numbers, {**ranges, **fit}, settings, usual


def faults_of_confidence(confidence: float, share: float | None) -> list[Fault]:
    """Check the confidence of the intervals and the relative standard deviation. Return the faults."""
    faults: list[Fault] = []
    for quantity, value in ((CONFIDENCE, confidence), (DEVIATION, share)):
        if value is not None:
            attempt(partial(quantity.read, value, quantity.name), None, faults)
    return faults


def taken_apart(
    structure: Mapping[str, Any], faults: list[Fault]
) -> tuple[dict[str, float], dict[str, tuple[float, float] | None], dict[str, Any]]:
    """Sort a study's entries into numbers, ranges of axes, and other settings."""
    settings = {
        name: value
        for name, value in structure.items()
        if name not in (*BESIDE_AXES, "axes", "physical", "metrics")
    }
    solver = settings.get("solver")
    if isinstance(solver, Mapping) and solver.get("method") == "rk4":
        told = "A fit needs the event solver: fixed steps are not exact enough to tell parameters apart."
        faults.append(Fault("solver", "rk4", "event", "leave `solver` out", told))
    entries: list[tuple[str, object]] = [(name, structure[name]) for name in BESIDE_AXES if name in structure]
    for part in ("axes", "physical"):
        inside = structure.get(part, {})
        if isinstance(inside, Mapping):
            entries += inside.items()
        else:
            faults.append(Fault(part, describe(inside), "a mapping", "write names and numbers"))
    known: dict[str, float] = {}
    ranges: dict[str, tuple[float, float] | None] = {}
    for name, raw in entries:
        if name in ("frequency_ratio", "excitation_frequency_hz"):
            continue  # the measurement gives the frequencies
        ends = _ends(raw)
        if ends is None:
            known |= read_number(name, raw, faults)
        else:
            low, high = (read_number(name, end, faults) for end in ends)
            if low and high:
                ranges[name] = (low[name], high[name])
    return known, ranges, settings


def read_number(name: str, raw: object, faults: list[Fault]) -> dict[str, float]:
    """Read one number of a prototype by name. If the number is wrong, record a fault and return an empty mapping."""
    if name in NAMED:
        return attempt(lambda: {name: NAMED[name].read(raw, name)}, {}, faults)
    near = nearest(str(name), NAMED)
    advice = f"did you mean `{near}`? Otherwise remove it" if near else "remove it"
    allowed = f"one of {listing(NAMED)}"
    told = f"{{field}} is not a known value of a prototype; allowed are {listing(NAMED)}."
    faults.append(Fault(str(name), "an unknown name", allowed, advice, told))
    return {}


def _ends(raw: object) -> tuple[Any, Any] | None:
    """Return the ends of an axis, or None if the entry is not an axis."""
    if isinstance(raw, Mapping) and {"start", "stop"} <= set(raw):
        return raw["start"], raw["stop"]
    if isinstance(raw, list | tuple) and len(raw) > 1 and all(isinstance(one, int | float) for one in raw):
        return min(raw), max(raw)
    return None


def _twice(names: Iterable[str]) -> Iterator[Fault]:
    """Yield a fault if a quantity is given twice: as a ratio and in SI units, or as known and to be estimated."""
    seen: dict[str, str] = {}
    for name in names:
        ratio = RATIO_OF.get(name, name)
        if ratio in seen:
            first = seen[ratio]
            other = "`fit`" if first == name else first
            told = f"{name} is given twice: also by {other}."
            yield Fault(name, f"also {other}", "one of the two", "leave one of them out", told)
            return
        seen[ratio] = name


def not_free(name: str, free: Sequence[str], of: str = "") -> Fault:
    """Return the fault of a parameter that cannot be estimated, with a list of possible parameters."""
    near = nearest(name, free)
    advice = f"did you mean `{near}`?" if near else "name one of these"
    told = f"{name} cannot be estimated{of}; possible are {listing(free)}."
    return Fault(f"fit.{name}", name, f"one of {listing(free)}", advice, told)


def of_particle(names: Iterable[str]) -> Iterator[Fault]:
    """For a definition without a particle, yield a fault for each parameter in `names` that needs a particle."""
    for name in names:
        if RATIO_OF.get(name, name) in (*OF_PARTICLE, *BEFORE):
            told = f"{name} cannot be estimated in a scene without a particle."
            advice = "leave it out, or give the scene its particle"
            yield Fault(f"fit.{name}", name, "no parameter of a particle", advice, told)


def read_ranges(ranges: Mapping[str, tuple[float, float] | None], faults: list[Fault]) -> list[Free]:
    """Check the ranges of parameters; None stands for a parameter with neither a given nor a default range."""
    read = [_range(name, span) for name, span in ranges.items()]
    faults += [each for each in read if isinstance(each, Fault)]
    return [each for each in read if not isinstance(each, Fault)]


def _range(name: str, span: tuple[float, float] | None) -> Free | Fault:
    field = f"fit.{name}"
    if span is None:
        told = f"{{field}} needs a range to search, since {name} has no default range."
        advice = f"write the lowest and the highest value, as in `fit: {{{name}: [LOW, HIGH]}}`"
        return Fault(field, NOTHING, "a range", advice, told)
    quantity = NAMED[name]
    for end in span:
        if not quantity.admits(end):
            return Fault(field, describe(end), quantity.allowed, quantity.advice)
    if not span[0] < span[1]:
        found = f"{span[0]:g} to {span[1]:g}"
        return Fault(field, found, "a lowest value below the highest", "swap or widen the ends")
    return Free(name, float(span[0]), float(span[1]))


def _usual(name: str, known: Mapping[str, float], measured: Measurement) -> tuple[float, float] | None:
    """Return the default range of a parameter, or None if there is no default."""
    if name == "natural_frequency_hz":
        return (0.8 * known[name], 1.25 * known[name]) if name in known else None
    if name == "clearance_ratio" and not measured.in_metres:
        return 0.5, max(5.0, 1.5 * float(measured.amplitude.max()))
    if name == "clearance_m" and measured.in_metres:
        largest = float(measured.amplitude.max())
        return 0.02 * largest, 1.5 * largest
    return DEFAULT_RANGES.get(name)


def faults_between(names: Sequence[str], free: Sequence[str], friction: str) -> list[Fault]:
    """Find faults of the set of parameters: no parameter, too many parameters, or a parameter in two forms."""
    faults = []
    if not names:
        told = "There is no parameter to estimate."
        advice = f"name what is unknown, as in `fit: {{restitution: null, {friction}}}`"
        faults.append(Fault("fit", NOTHING, f"one or more of {listing(free)}", advice, told))
    if len(names) > MOST_FREE:
        told = f"{len(names)} parameters are to be estimated; at most {MOST_FREE} are possible."
        advice = "measure some of them on their own: the mass by weighing, the clearance with a calliper"
        faults.append(Fault("fit", f"{len(names)} parameters", f"at most {MOST_FREE}", advice, told))
    twice = [name for name in names if RATIO_OF.get(name, name) in names and RATIO_OF.get(name) is not None]
    for name in twice:
        told = f"{name} and {RATIO_OF[name]} are the same parameter; estimate one of them."
        faults.append(Fault(f"fit.{name}", "both", "one of the two", "leave one out", told))
    return faults


def _check(question: FitQuestion) -> None:
    """Check the definition of every configuration at both ends of all ranges."""
    faults: dict[tuple[str, str], Fault] = {}
    particle = question.settings.get("particle", True) is not False
    for conditions, rows in question.configurations:
        for share in (0.0, 1.0):
            given = question.given(question.values(np.full(len(question.free), share)), conditions)
            missing = list(_missing(question, given, particle))
            if not missing:
                try:
                    question.study(given, np.unique(question.ratios(given, rows)).tolist())
                except StudyFaults as error:
                    missing = list(error.faults)
            for fault in missing:
                faults.setdefault((fault.field, fault.sentence), fault)
    if not particle:
        faults |= {(fault.found, ""): fault for fault in of_particle(each.name for each in question.free)}
    if faults:
        raise StudyFaults(faults.values())


def _missing(question: FitQuestion, given: Mapping[str, float], particle: bool) -> Iterable[Fault]:
    """Yield a fault for each required value that is given nowhere. The defaults of a study are not used."""
    ratios = {RATIO_OF.get(name, name) for name in given}
    for name in RATIOS:
        if name == "frequency_ratio" or name in ratios or (name in OF_PARTICLE and not particle):
            continue
        zero = FRICTIONLESS if name == "friction_ratio" else ""
        advice = f"give it{zero}, estimate it with `fit: {{{name}: null}}`, or add a column"
        if name in OF_PARTICLE:
            advice += "; or leave the particle out"
        told = f"{{field}} is neither given nor estimated nor a column of the table: {RATIOS[name].meaning}."
        yield Fault(name, NOTHING, RATIOS[name].allowed, advice, told)
    for name, needed, why in (
        ("natural_frequency_hz", question.measured.in_hertz, "the frequencies are measured in Hz"),
        ("base_amplitude_m", question.measured.in_metres, "the amplitudes are measured in metres"),
    ):
        if needed and name not in given:
            told = f"{{field}} is missing: {why}."
            yield Fault(name, NOTHING, NAMED[name].allowed, "give it, or measure ratios", told)
