"""A design as plain data: what `damperlab design --json` prints."""

from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.brief import notes_document
from damperlab.studies.design.absorber import DETUNED, curve
from damperlab.studies.design.alternatives import LACKS
from damperlab.studies.design.backbone import backbone_document
from damperlab.studies.design.build import Build, design_document
from damperlab.studies.design.found import Found, at_ends
from damperlab.studies.design.front import OfMass, undominated
from damperlab.studies.design.score import Score, binding
from damperlab.studies.design.spelling import material_of
from damperlab.studies.design.verdict import acceleration_g, verdict_of
from damperlab.studies.design.words import details_of
from damperlab.studies.specification.measure import DAMPER_LIMITS
from damperlab.studies.specification.records import Case, Under
from damperlab.studies.specification.specification import Specification
from damperlab.studies.tmd.absorber import NO_DAMPER, Absorber

BINDS = 0.97
"""Share of a limit from which it is said to bind."""
SAMPLES = 301
"""Frequencies of a response in closed form."""


def answer_document(found: Found) -> dict[str, Any]:
    """Give all that was found as mappings, lists, texts and numbers; one that is not finite stands for a failed response."""
    asked, build, stated = found.asked, found.build, found.stated
    builds = found.builds
    brief, notes = verdict_of(found)
    probability = None if builds is None else builds.passed / builds.drawn
    if builds is None and not asked.tolerances:
        probability = 1.0 if stated.violation == 0.0 else 0.0
    return {
        "name": asked.name,
        "digest": asked.digest,
        "verdict": brief.document(),
        "notes": notes_document(notes),
        "design": design_document(build, asked) | {"material": material_of(asked, build) or None},
        "worst": worst_document(asked, stated),
        "nominal": worst_document(asked, found.nominal),
        "excitations": [worst_document(asked, each) for each in _under_each(found)],
        "feasible": stated.violation == 0.0,
        "limits": limits_of(found),
        "acceleration_g": acceleration_g(found),
        "probability": probability,
        "probability_interval": None if builds is None else [builds.low, builds.high],
        "builds": 0 if builds is None else builds.drawn,
        "builds_within": None if builds is None else builds.bound,
        "starts": _starts(found),
        "at_range_end": at_ends(found),
        "margins": {name: asdict(margin) for name, margin in found.margins.items()},
        **{name: _alternative(found, name) for name in LACKS},
        "tuned_mass_damper": _absorber(found),
        "compared": worst_document(asked, found.compared),
        "pareto": [
            {_mass_name(asked): each.mass_kg, "worst": each.score.value, "error": each.score.error}
            for each in undominated(found.front)
        ],
        "masses": [_of_mass(found, each) for each in found.front],
        "stopped": found.stopped,
        "ended": {"criterion": found.ended, "looked_at": found.looked_at},
        "left_out": list(found.left_out),
        "confidence": asked.confidence,
        "points": found.book.spent,
        "budget_points": found.book.budget,
        "words": details_of(found),
        "response": _response(found, found.build),
        "no_damper": {"response": _closed_form(found, NO_DAMPER)},
        "amplitudes": backbone_document(found),
        "cases": [
            {
                "record": case.source.id,
                "record_name": case.source.called,
                "scale": case.scale,
                "value": value,
            }
            for case, value in cases_of(found)
        ],
        "specification": asked.document,
    }


def known_document(asked: Specification, ahead: tuple[Build, Score]) -> dict[str, Any]:
    """Give the best damper so far, as the answer gives the recommended one."""
    build, score = ahead
    return {
        "design": design_document(build, asked),
        "worst": worst_document(asked, score),
        "feasible": score.violation == 0.0,
    }


def worst_document(asked: Specification, score: Score) -> dict[str, Any]:
    """Give a worst case with its units, and where it is."""
    return {
        "measure": asked.measure.name,
        "value": score.value,
        "error": score.error,
        "units": asked.unit,
        **_where(asked, score),
    }


def _where(asked: Specification, score: Score) -> dict[str, Any]:
    """Give what a worst case is under: a frequency and an amplitude, or a record and its scale; None for what it has not."""
    under = score.under
    nowhere = ("ratio", "frequency_ratio", "frequency_hz", "base_amplitude_m")
    if isinstance(under, Case):
        name = asked.records_of(under).name
        return dict.fromkeys(nowhere) | {
            "excitation": name or None,
            "record": under.source.id,
            "record_name": under.source.called,
            "scale": under.scale,
        }
    no_record = dict.fromkeys(("record", "record_name", "scale")) if asked.cases else {}
    if not asked.excitations:
        return dict.fromkeys((*nowhere, "excitation")) | no_record
    bound = binding(asked, score)
    at = score.frequency_ratio
    known = no_record | {
        "ratio": score.value / (score.amplitude_m * _rate(asked) ** asked.measure.order),
        "frequency_ratio": at,
        "frequency_hz": at * asked.structure.natural_frequency_hz if asked.in_units else None,
        "base_amplitude_m": score.amplitude_m if asked.in_units else None,
        "excitation": bound.name or None,
    }
    # a mean is at no frequency, and under a constant velocity at no amplitude of the displacement
    if asked.measure.mean:
        known |= dict.fromkeys(nowhere if bound.motion.order else ("frequency_ratio", "frequency_hz"))
    return known


def _rate(asked: Specification) -> float:
    """Give ω_n [rad/s], which ratios of accelerations are over; 1 where only ratios mean anything."""
    return asked.structure.angular_frequency if asked.in_units else 1.0


def _starts(found: Found) -> dict[str, Any] | None:
    """Give what several starts lead to; lengths in metres, or over the base amplitude where there are no units."""
    if found.starts is None:
        return None
    known = asdict(found.starts)
    for each in (known, *known["where"]):
        each["frequency_hz"] = _hertz(found.asked, each["frequency_ratio"])
    return known


def _hertz(asked: Specification, ratio: float) -> float | None:
    return ratio * asked.structure.natural_frequency_hz if asked.in_units else None


def limits_of(found: Found) -> list[dict[str, Any]]:
    """Give what of each limit is reached, and whether it is kept and binds."""
    rows: list[dict[str, Any]] = []
    asked = found.asked
    for name, limit in asked.limits.items():
        reached, at_most = found.stated.reached[name], found.stated.at_most[name]
        rows.append(
            {
                "limit": asked.limit_key(name),
                "allowed": asked.as_limited(name, limit),
                "reached": asked.as_limited(name, reached),
                "at_most": asked.as_limited(name, at_most),
                "kept": reached <= limit,
                "binds": reached >= BINDS * limit,
                "relax_to": asked.as_limited(name, at_most) if reached > limit else None,
                **_reached_at(asked, found.stated.reached_at.get(name)),
            }
        )
    ends = at_ends(found)
    for name, limit in asked.damper_limits.items():
        about = DAMPER_LIMITS[name]
        reached = found.build.as_built(asked, about)
        at_end = about.quantity in asked.bounds and ends.get(about.quantity) == "upper"
        rows.append(
            {
                "limit": asked.limit_key(name),
                "allowed": asked.as_limited(name, limit),
                "reached": asked.as_limited(name, reached),
                "at_most": asked.as_limited(name, reached),
                "kept": about.excess(reached, limit) == 0.0,
                "binds": at_end or reached >= BINDS * limit,
                "relax_to": None,
                **_reached_at(asked, None),
            }
        )
    return rows


def _reached_at(asked: Specification, at: tuple[Under, float] | None) -> dict[str, Any]:
    """Give under what a limited result is what it is; None where nothing has it."""
    known = dict.fromkeys(("frequency_ratio", "frequency_hz", "excitation", "record", "scale"))
    if at is None:
        return known
    under, ratio = at
    if isinstance(under, Case):
        name = asked.records_of(under).name
        return known | {"excitation": name or None, "record": under.source.id, "scale": under.scale}
    hertz = ratio * asked.structure.natural_frequency_hz if asked.in_units else None
    return known | {
        "frequency_ratio": ratio,
        "frequency_hz": hertz,
        "excitation": under.excitation.name or None,
    }


def _alternative(found: Found, name: str) -> dict[str, Any] | None:
    other = found.alternatives.get(name)
    if other is None:
        return None
    return {
        "design": design_document(other.build, found.asked),
        "worst": worst_document(found.asked, other.score),
        "feasible": other.score.violation == 0.0,
        "ratio": _times(other.score.value, found),
        "response": _response(found, other.build),
    }


def _absorber(found: Found) -> dict[str, Any] | None:
    beside = found.absorber
    if beside is None:
        return None
    length = "m" if found.asked.in_units else "1"
    return {
        "mass_ratio": beside.absorber.mass_ratio,
        "tuning": beside.absorber.tuning,
        "damping_ratio": beside.absorber.damping_ratio,
        "worst": {"value": beside.value, "units": found.asked.unit},
        "nominal": {"value": beside.nominal, "units": found.asked.unit},
        "detuned": {"value": beside.detuned, "units": found.asked.unit},
        "detuned_by": DETUNED,
        "stroke": {"value": beside.stroke, "units": length},
        "detuned_stroke": {"value": beside.detuned_stroke, "units": length},
        "feasible": not beside.exceeded,
        "exceeded": [found.asked.limit_key(name) for name in beside.exceeded],
        "ratio": _times(beside.value, found),
        "response": _closed_form(found, beside.absorber),
    }


def _of_mass(found: Found, one: OfMass) -> dict[str, Any]:
    """Give the best damper found of a mass, as drawn, with other dampers of that mass."""
    return {
        _mass_name(found.asked): one.mass_kg,
        "design": design_document(one.build, found.asked),
        "worst": worst_document(found.asked, one.score),
        "feasible": one.score.violation == 0.0,
        "looked_at": one.looked_at,
        "recommended": one.mass_kg == found.build.particle_mass_kg,
        "lighter_as_good": one not in undominated(found.front),
        "tuned_mass_damper": one.absorber,
        "particle_alone": one.particle_alone,
    }


def _mass_name(asked: Specification) -> str:
    """Name the mass of a particle: in a specification in ratios the structure's is 1."""
    return "particle_mass_kg" if asked.in_units else "mass_ratio"


def _times(value: float, found: Found) -> float | None:
    """Give a value over that of the recommended damper; None over one that lets nothing move."""
    return value / found.compared.value if found.compared.value > 0.0 else None


def _under_each(found: Found) -> list[Score]:
    """Give the worst case as drawn under each excitation, last those of records; of one of records `cases` say more."""
    alone = not found.asked.excitations and len(found.asked.records) == 1
    return [*found.under, *(() if alone else found.under_records)]


def cases_of(found: Found) -> list[tuple[Case, float]]:
    """Give the measure of the drawn damper under every record at every scale; none of a specification over bands."""
    cases = found.asked.cases
    return [(each, float(found.book.curve(found.build, each).measured[0])) for each in cases]


def _response(found: Found, build: Build) -> dict[str, Any]:
    """Give the response of a damper as drawn at every frequency computed, with its error; empty without a band."""
    asked = found.asked
    if not asked.excitations:
        return {}
    known = found.book.curve(build, found.binding.largest)
    return _over(found, known.r, known.measured) | {"error": known.errors.tolist()}


def _closed_form(found: Found, absorber: Absorber) -> dict[str, Any]:
    """Give the response with a tuned mass damper, or with none, on the nominal structure; empty without a band."""
    if not found.asked.excitations:
        return {}
    r = np.linspace(
        found.binding.low, found.binding.high, SAMPLES if found.binding.high > found.binding.low else 1
    )
    return _over(found, r, curve(found.asked, found.binding.largest, absorber, r))


def _over(found: Found, r: NDArray[np.float64], values: NDArray[np.float64]) -> dict[str, Any]:
    known: dict[str, Any] = {"frequency_ratio": r.tolist(), "value": values.tolist()}
    if found.asked.in_units:
        known["frequency_hz"] = (r * found.asked.structure.natural_frequency_hz).tolist()
    return known
