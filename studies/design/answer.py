"""The answer of a design as a document, which `damperlab design --json` prints."""

from dataclasses import asdict
from typing import Annotated, Any, Literal, NotRequired

import numpy as np
from numpy.typing import NDArray
from typing_extensions import TypedDict

from damperlab.studies.brief import InShort, Notes, notes_document
from damperlab.studies.design.absorber import DETUNED, curve
from damperlab.studies.design.backbone import OverBand, backbone_document
from damperlab.studies.design.build import Build, Built, design_document
from damperlab.studies.design.drawing import drawing_of
from damperlab.studies.design.found import Found, at_ends
from damperlab.studies.design.front import OfMass, undominated
from damperlab.studies.design.kept import KnownDesign, Where, Worst
from damperlab.studies.design.margins import Margin
from damperlab.studies.design.score import Score, binding
from damperlab.studies.design.spelling import material_of
from damperlab.studies.design.starts import Starts, hertz
from damperlab.studies.design.verdict import acceleration_g, called_of, verdict_of
from damperlab.studies.design.words import details_of
from damperlab.studies.shapes import Count, Like, Measured, Number, Numbers, Range, Says
from damperlab.studies.specification.excitation import Case, Under
from damperlab.studies.specification.measure import DAMPER_LIMITS
from damperlab.studies.specification.specification import Specification
from damperlab.studies.tmd.absorber import NO_DAMPER, Absorber

BINDS = 0.97
"""A limit binds if the result is at least this fraction of the limit."""
SAMPLES = 301
"""Number of frequencies at which a response with a closed form is computed."""


class Amount(TypedDict):
    """A value and its units."""

    value: Measured
    units: str


class ReachedUnder(TypedDict):
    """The condition under which a limited result is largest."""

    frequency_ratio: Number
    frequency_hz: Number
    excitation: str | None
    record: str | None
    scale: Number


class Limit(ReachedUnder):
    """A limit, the result that the limit restricts, and whether the limit is kept and binds."""

    limit: str
    allowed: Measured
    reached: Measured
    at_most: Measured
    kept: bool
    binds: bool
    relax_to: Number


class Response(TypedDict, total=False):
    """The response of a damper over the band; empty if there is no band."""

    frequency_ratio: Numbers
    frequency_hz: Numbers
    value: Numbers
    error: Numbers


class Alternative(KnownDesign):
    """A damper with friction alone or with a particle alone, as an alternative to the recommended damper.

    `ratio` is the worst case of the alternative divided by the worst case of the recommended damper.
    """

    ratio: Number
    response: Response


class BesideAbsorber(TypedDict):
    """A tuned mass damper of the same mass, as an alternative to the recommended damper."""

    mass_ratio: Number
    tuning: Number
    damping_ratio: Number
    worst: Amount
    nominal: Amount
    detuned: Amount
    detuned_by: Number
    stroke: Amount
    detuned_stroke: Amount
    feasible: bool
    exceeded: list[str]
    ratio: Number
    response: Response


class NoDamper(TypedDict):
    """The response of the structure without a damper."""

    response: Response


class BestOfMass(KnownDesign):
    """The best damper found with a particle of one mass, and the worst cases of other dampers with this mass."""

    particle_mass_kg: NotRequired[Number]
    mass_ratio: NotRequired[Number]
    looked_at: Count
    recommended: bool
    lighter_as_good: bool
    tuned_mass_damper: Number
    particle_alone: Number


class Ended(TypedDict):
    """The reason why the search ended, and the number of examined dampers."""

    criterion: str
    looked_at: Count


class UnderRecord(TypedDict):
    """The measure of the nominal damper under a record at a scale."""

    record: str
    record_name: str
    scale: Number
    value: Number


class DesignAnswer(TypedDict):
    """The document that `damperlab design --json` prints."""

    name: str
    digest: str
    verdict: InShort
    notes: Notes
    called: Annotated[
        str,
        Says(description="Name of `design`: it is recommended only if no other kind of damper does better."),
    ]
    drawing: Annotated[
        list[list[str]],
        Says(
            description="Drawing of the verdict's damper: quantity, value, tolerance, range in which it alone may change."
        ),
    ]
    design: Built
    worst: Worst
    nominal: Worst
    excitations: list[Worst]
    feasible: bool
    limits: list[Limit]
    acceleration_g: Number
    probability: Number
    probability_interval: Range | None
    builds: Count
    builds_within: Number
    starts: Annotated[dict[str, Any], Like(Starts)] | None
    at_range_end: dict[str, str]
    margins: dict[str, Annotated[dict[str, Any], Like(Margin)]]
    friction_alone: Alternative | None
    particle_alone: Alternative | None
    tuned_mass_damper: BesideAbsorber | None
    compared: Worst
    pareto: list[dict[str, Number]]
    masses: list[BestOfMass]
    stopped: str
    ended: Ended
    left_out: list[str]
    confidence: Number
    points: Count
    budget_points: Count
    words: list[str]
    response: Response
    no_damper: NoDamper
    amplitudes: list[OverBand]
    cases: list[UnderRecord]
    specification: dict[str, Any]


def answer_document(found: Found) -> DesignAnswer:
    """Return all findings as a document. A number that is not finite stands for a failed response."""
    asked, build, stated = found.asked, found.build, found.stated
    builds = found.builds
    brief, notes = verdict_of(found)
    damper = brief.damper
    assert damper is not None  # the verdict of a design always names a kind, which may be `no_damper`
    probability = None if builds is None else builds.passed / builds.drawn
    if builds is None and not asked.tolerances:
        probability = 1.0 if stated.violation == 0.0 else 0.0
    return {
        "name": asked.name,
        "digest": asked.digest,
        "verdict": brief.document(),
        "notes": notes_document(notes),
        "called": called_of(found, damper),
        "drawing": [list(line) for line in drawing_of(found, damper)],
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
        "starts": None if found.starts is None else asdict(found.starts),
        "at_range_end": at_ends(found),
        "margins": {name: asdict(margin) for name, margin in found.margins.items()},
        "friction_alone": _alternative(found, "friction_alone"),
        "particle_alone": _alternative(found, "particle_alone"),
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
        "words": details_of(found, damper),
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


def known_document(asked: Specification, judged: tuple[Build, Score]) -> KnownDesign:
    """Return a damper and its worst case as a document, for example those of the best damper so far."""
    build, score = judged
    return {
        "design": design_document(build, asked),
        "worst": worst_document(asked, score),
        "feasible": score.violation == 0.0,
    }


def worst_document(asked: Specification, score: Score) -> Worst:
    """Return a worst case with its units, and the conditions under which the worst case occurs."""
    return {
        "measure": asked.measure.name,
        "value": score.value,
        "error": score.error,
        "units": asked.unit,
        **_where(asked, score),
    }


def _where(asked: Specification, score: Score) -> Where:
    """Return the conditions of a worst case: a frequency and an amplitude, or a record and its scale.

    Conditions that do not apply are None.
    """
    under = score.under
    known: Where = {
        "ratio": None,
        "frequency_ratio": None,
        "frequency_hz": None,
        "base_amplitude_m": None,
        "excitation": None,
    }
    if isinstance(under, Case):
        known["excitation"] = asked.records_of(under).name or None
        known["record"], known["record_name"] = under.source.id, under.source.called
        known["scale"] = under.scale
        return known
    if asked.cases:
        known["record"] = known["record_name"] = known["scale"] = None
    if not asked.excitations:
        return known
    bound = binding(asked, score)
    known["excitation"] = bound.name or None
    if not asked.measure.mean:  # an rms over the band has no frequency
        known["frequency_ratio"] = score.frequency_ratio
        known["frequency_hz"] = hertz(asked, score.frequency_ratio)
    # under a constant velocity the displacement has no single amplitude
    if not (asked.measure.mean and bound.motion.order):
        known["ratio"] = score.value / (score.amplitude_m * _rate(asked) ** asked.measure.order)
        known["base_amplitude_m"] = score.amplitude_m if asked.in_units else None
    return known


def _rate(asked: Specification) -> float:
    """Return ω_n [rad/s], the reference of accelerations; 1 for a specification in ratios."""
    return asked.structure.angular_frequency if asked.in_units else 1.0


def limits_of(found: Found) -> list[Limit]:
    """Return each limit with its result, and whether the limit is kept and binds."""
    rows: list[Limit] = []
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


def _reached_at(asked: Specification, at: tuple[Under, float] | None) -> ReachedUnder:
    """Return the condition under which a limited result is largest. All values are None if `at`
    is None.
    """
    known: ReachedUnder = {
        "frequency_ratio": None,
        "frequency_hz": None,
        "excitation": None,
        "record": None,
        "scale": None,
    }
    if at is None:
        return known
    under, ratio = at
    if isinstance(under, Case):
        known["excitation"] = asked.records_of(under).name or None
        known["record"], known["scale"] = under.source.id, under.scale
        return known
    known["frequency_ratio"], known["frequency_hz"] = ratio, hertz(asked, ratio)
    known["excitation"] = under.excitation.name or None
    return known


def _alternative(found: Found, name: str) -> Alternative | None:
    other = found.alternatives.get(name)
    if other is None:
        return None
    return {
        **known_document(found.asked, (other.build, other.score)),
        "ratio": _times(other.score.value, found),
        "response": _response(found, other.build),
    }


def _absorber(found: Found) -> BesideAbsorber | None:
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


def _of_mass(found: Found, one: OfMass) -> BestOfMass:
    """Return, as a document, the best damper found with a particle of one mass."""
    best: BestOfMass = {
        "design": design_document(one.build, found.asked),
        "worst": worst_document(found.asked, one.score),
        "feasible": one.score.violation == 0.0,
        "looked_at": one.looked_at,
        "recommended": one.mass_kg == found.build.particle_mass_kg,
        "lighter_as_good": one not in undominated(found.front),
        "tuned_mass_damper": one.absorber,
        "particle_alone": one.particle_alone,
    }
    best[_mass_name(found.asked)] = one.mass_kg
    return best


def _mass_name(asked: Specification) -> Literal["particle_mass_kg", "mass_ratio"]:
    """Return the key of the particle's mass. In a specification in ratios the structure has mass 1."""
    return "particle_mass_kg" if asked.in_units else "mass_ratio"


def _times(value: float, found: Found) -> float | None:
    """Return a value divided by the worst case of the recommended damper; None if that worst case is 0."""
    return value / found.compared.value if found.compared.value > 0.0 else None


def _under_each(found: Found) -> list[Score]:
    """Return the nominal worst case under each excitation. Excitations by records come last."""
    alone = not found.asked.excitations and len(found.asked.records) == 1
    return [*found.under, *(() if alone else found.under_records)]


def cases_of(found: Found) -> list[tuple[Case, float]]:
    """Return the measure of the nominal damper for every record at every scale; empty if there are no records."""
    cases = found.asked.cases
    return [(each, float(found.book.curve(found.build, each).measured[0])) for each in cases]


def _response(found: Found, build: Build) -> Response:
    """Return the response of a nominal damper, with its error, at every computed frequency; empty without bands."""
    asked = found.asked
    if not asked.excitations:
        return {}
    known = found.book.curve(build, found.binding.largest)
    return {**_over(found, known.r, known.measured), "error": known.errors.tolist()}


def _closed_form(found: Found, absorber: Absorber) -> Response:
    """Return the response of the nominal structure with an absorber, or without a damper; empty if there is no band."""
    if not found.asked.excitations:
        return {}
    r = np.linspace(
        found.binding.low, found.binding.high, SAMPLES if found.binding.high > found.binding.low else 1
    )
    return _over(found, r, curve(found.asked, found.binding.largest, absorber, r))


def _over(found: Found, r: NDArray[np.float64], values: NDArray[np.float64]) -> Response:
    known: Response = {"frequency_ratio": r.tolist(), "value": values.tolist()}
    if found.asked.in_units:
        known["frequency_hz"] = (r * found.asked.structure.natural_frequency_hz).tolist()
    return known
