"""Assemble the definition of a fit from a time history, known values and parameters, and report every fault."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import pi
from typing import Any

import numpy as np

from damperlab.studies.choices import Contact
from damperlab.studies.consistency import rubbing_faults
from damperlab.studies.definition import parse_harmonic
from damperlab.studies.faults import NOTHING, Fault, StudyFaults, attempt, describe, listing
from damperlab.studies.fit.asking import (
    DEFAULT_RANGES,
    FRICTIONLESS,
    faults_between,
    faults_of_confidence,
    gathered,
    not_free,
    of_particle,
    read_ranges,
)
from damperlab.studies.fit.history.question import (
    FREE,
    INSTANT,
    KNOWN,
    OVER_BASE,
    RELEASE,
    History,
    HistoryQuestion,
)
from damperlab.studies.fit.question import NAMED, RATIO_OF, Free
from damperlab.studies.variables import MADE_BY

SWING, LEAST_SWINGS = 0.2, 4
"""A free decay gives default ranges if at least `LEAST_SWINGS` half cycles exceed `SWING` of the largest amplitude."""
SLOWER, FASTER = 0.9, 1.25
"""Bounds of the natural frequency, as multiples of the frequency of a decay. A particle lowers this frequency."""
MOST_FRICTION = 1.5
"""Largest friction in the search, as a multiple of the friction that alone would explain the median decay."""
IN_UNITS = ("friction_force_n", "damping_n_s_per_m", "particle_mass_kg")
"""Quantities that affect the response only through their ratio to the mass of the structure."""
OF_SETTINGS = ("name", "particle", "contact")
SAMPLED = 8.0
"""Fewest samples per period of the structure."""
NEAR_START, NOISY = 0.1, 6.0
"""The search range of the release position extends from the first sample by `NEAR_START` times the value of
the sample, or by `NOISY` standard deviations if that is more.
"""


def make_history_question(
    measured: History,
    structure: Mapping[str, Any],
    fit: Mapping[str, tuple[float, float] | None],
    *,
    known: Mapping[str, float] | None = None,
    share: float | None = None,
    confidence: float = 0.95,
    seed: int = 0,
) -> HistoryQuestion:
    """Assemble the definition of a fit and check it.

    Parameters
    ----------
    measured : History
        The measured time history.
    structure : mapping
        The known values in the form of a study: `damping_ratio`, `axes`, `physical`, `particle`, `contact`. A
        quantity with an axis is a parameter to estimate within the range of the axis.
    fit : mapping
        The parameters to estimate and their ranges: (lowest, highest), or None for the default range.
    known : mapping, optional
        Numbers that override numbers in `structure`. The keys are names of `KNOWN`.
    share : float, optional
        Standard deviation relative to the largest displacement, if the measurement states none.
    confidence : float
        Confidence of the intervals.
    seed : int
        Seed of all random draws.

    Raises
    ------
    StudyFaults
        If the definition is invalid. The exception contains all faults.
    """
    faults: list[Fault] = []
    numbers, ranges, settings, _ = gathered(structure, known or {}, fit, faults)
    faults += [_without_base(name) for name in (*numbers, *ranges) if name in OVER_BASE]
    faults += [
        not_free(name, FREE, " from a time history") for name in ranges if name not in (*FREE, *OVER_BASE)
    ]
    settings = {name: value for name, value in settings.items() if value not in (None, "rest")}
    for name in sorted(set(settings) - set(OF_SETTINGS)):
        told = f"{name} does not apply to a time history."
        faults.append(Fault(name, describe(settings[name]), listing(OF_SETTINGS), "leave it out", told))
    particle = settings.get("particle", True) is not False
    wanted = {name: span for name, span in ranges.items() if name in FREE}
    free = read_ranges(
        {name: span or _usual(name, numbers, measured) for name, span in wanted.items()}, faults
    )
    faults += faults_between(tuple(wanted), FREE, "friction_force_n: [0, 0.2]")
    faults += [] if particle else of_particle(wanted)
    if not faults:
        faults += _missing(numbers, wanted, particle)
    faults += faults_of_confidence(confidence, share)
    contact = INSTANT if faults else _contact(settings, numbers, free, faults)
    if not faults:
        beside = {"no_particle": not particle, "contact": contact.model != "instant"}
        for name in (name for name in MADE_BY.values() if numbers.get(name) or name in wanted):
            faults += rubbing_faults(name, describe(numbers.get(name, wanted.get(name))), beside)
    if faults:
        raise StudyFaults(faults)
    if share is not None and measured.deviation_m is None:
        deviation = np.full(measured.rows, share * measured.largest_m)
        measured = replace(measured, deviation_m=deviation)
    if measured.released:
        free.append(_release(measured))
    question = HistoryQuestion(measured, numbers, tuple(free), particle, contact, confidence, seed)
    _check_sampling(question)
    return question


def _without_base(name: str) -> Fault:
    instead = {"clearance_ratio": "clearance_m", "friction_ratio": "friction_force_n", **MADE_BY}.get(name)
    told = f"{name} applies to a base that moves as a sine; a time history has no base amplitude."
    advice = f"give {instead}" if instead else "leave it out: the table states the motion of the base"
    return Fault(name, name, f"one of {listing(KNOWN)}", advice, told)


def _usual(name: str, known: Mapping[str, float], measured: History) -> tuple[float, float] | None:
    """Return the default range of a parameter, or None if there is no default."""
    if name == "clearance_m":
        return 0.02 * measured.largest_m, 1.5 * measured.largest_m
    if name == "natural_frequency_hz" and name in known:
        return 0.9 * known[name], 1.1 * known[name]
    return DEFAULT_RANGES.get(name) or _shown(name, known, measured)


def _shown(name: str, known: Mapping[str, float], measured: History) -> tuple[float, float] | None:
    """Return the range of natural frequency or friction that a free decay implies; None without a clear decay."""
    moved = measured.displacement_m
    swings = np.flatnonzero(np.abs(moved) > SWING * measured.largest_m)
    parts = np.split(swings, np.flatnonzero(np.diff(np.sign(moved[swings]))) + 1)
    if not measured.released or len(parts) < LEAST_SWINGS:
        return None
    crossings = [(one[-1] + other[0]) / 2.0 for one, other in pairwise(parts)]
    shown = 0.5 / (measured.step_s * float(np.median(np.diff(crossings))))
    if name == "natural_frequency_hz":
        return SLOWER * shown, FASTER * shown
    lost = -float(np.median(np.diff([np.abs(moved[part]).max() for part in parts])))
    stiffness = known.get("mass_kg", 1.0) * (2.0 * pi * known.get("natural_frequency_hz", shown)) ** 2
    # friction alone reduces the amplitude by 2F/k in each half cycle
    return (
        (0.0, MOST_FRICTION * stiffness * lost / 2.0) if name == "friction_force_n" and lost > 0.0 else None
    )


def _missing(numbers: Mapping[str, float], ranges: Mapping[str, Any], particle: bool) -> Iterator[Fault]:
    there = {*numbers, *ranges}
    ratios = {RATIO_OF.get(name, name) for name in there}
    needed = {"natural_frequency_hz": "natural_frequency_hz", "damping_ratio": "damping_ratio"}
    needed |= {"friction_ratio": "friction_force_n"}
    if particle:
        needed |= {"mass_ratio": "mass_ratio", "clearance_ratio": "clearance_m", "restitution": "restitution"}
    if there & set(IN_UNITS) - {name for name in there if numbers.get(name) == 0.0}:
        needed["mass_kg"] = "mass_kg"
    for ratio, name in needed.items():
        if ratio not in ratios:
            quantity = NAMED[name]
            estimate = f", or estimate it with `fit: {{{name}: null}}`" if name in FREE else ""
            told = f"{{field}} is neither given nor estimated: {quantity.meaning}."
            zero = FRICTIONLESS if ratio == "friction_ratio" else ""
            yield Fault(name, NOTHING, quantity.allowed, f"give it{zero}{estimate}", told)


def _contact(
    settings: Mapping[str, Any], numbers: Mapping[str, float], free: list[Free], faults: list[Fault]
) -> Contact:
    """Read the contact model as a study does, and check its limits on mass ratio and restitution."""
    contact: Contact = INSTANT
    for end in ("low", "high"):
        values = dict(numbers) | {each.name: getattr(each, end) for each in free}
        mass = values.get("mass_ratio", values.get("particle_mass_kg", 0.0) / values.get("mass_kg", 1.0))
        axes = {"friction_ratio": 0.0, "frequency_ratio": 1.0}
        if settings.get("particle", True) is not False:
            axes |= {"mass_ratio": mass, "restitution": values["restitution"], "clearance_ratio": 1.0}
        document = {**settings, "damping_ratio": 0.0, "axes": axes}
        study = attempt(partial(parse_harmonic, document), None, faults)
        if study is None:
            break
        contact = study.contact
    return contact


def _release(measured: History) -> Free:
    first = float(measured.displacement_m[0])
    noise = 0.0 if measured.deviation_m is None else NOISY * float(measured.deviation_m[0])
    reach = max(NEAR_START * abs(first), noise)
    return Free(RELEASE, first - reach, first + reach)


def _check_sampling(question: HistoryQuestion) -> None:
    samples = 1.0 / (question.frequency_hz * question.measured.step_s)
    periods = question.measured.duration_s * question.frequency_hz
    for number, what, least, advice in (
        (samples, "samples in a period of the structure", SAMPLED, "sample faster"),
        (periods, "periods of the structure", 2.0, "measure longer"),
    ):
        if number < least:
            found, allowed = f"{number:.3g} {what}", f"at least {least:g}"
            told = f"The history has {found}; it must have {allowed}."
            raise StudyFaults(
                [Fault("measured", found, allowed, f"{advice}, or check the unit of time", told)]
            )
