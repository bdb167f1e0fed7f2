"""The verdict of a design: what to build, the expected response, a comparison with other dampers, and one next step."""

from collections.abc import Iterator, Mapping
from functools import partial
from math import isinf, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.answers.comparing import clearly_less
from damperlab.studies.answers.largest_acceleration import LARGEST, Acting, acceleration_row, accelerations
from damperlab.studies.answers.verdict import CLAMPED, HELD
from damperlab.studies.brief import Brief, Damper, Note, damper_of, listed
from damperlab.studies.design.absorber import DETUNED, Beside
from damperlab.studies.design.absorber_structure import hardest, judged_of
from damperlab.studies.design.alternatives import Alternative
from damperlab.studies.design.build import Build
from damperlab.studies.design.curve import Curve
from damperlab.studies.design.found import Found, at_ends, locked
from damperlab.studies.design.margins import MOVED
from damperlab.studies.design.score import Score
from damperlab.studies.design.spelling import (
    CALLED as NAMES_IN_FULL,
)
from damperlab.studies.design.spelling import (
    OVER,
    damper_words,
    frequency,
    level,
    limited,
    quantity,
    response,
    rounded_up,
)
from damperlab.studies.ground.generated import same_process
from damperlab.studies.physical import STANDARD_GRAVITY
from damperlab.studies.quantity import PARTICLE_FRICTION
from damperlab.studies.specification.excitation import Amplitude, Case
from damperlab.studies.specification.specification import Specification
from damperlab.studies.spelling import spelled, unit_of
from damperlab.studies.tmd.absorber import NO_DAMPER
from damperlab.studies.understood import unusual_specification
from damperlab.studies.variables import MADE_BY, ResponseClass
from damperlab.studies.variables import PARTICLE_FRICTION as PARTICLE_FRICTION_RATIO

GROWS = 1.5
"""The verdict warns if the response grows by more than this factor times the growth of the excitation."""
CALLED: dict[Damper, str] = {
    "hybrid": "particle with friction",
    "particle_alone": "particle alone",
    "friction_alone": "friction alone",
    "tuned_mass_damper": "tuned mass damper",
    "no_damper": "without damper",
}
CAVITY = {*MADE_BY.values()}
"""Optional keys of a specification that describe the cavity; by default the cavity is horizontal and frictionless."""
NAMES = NAMES_IN_FULL | {
    "friction_force_n": "friction",
    "restitution": "restitution",
    "particle_friction_coefficient": "μ_i",
    "tilt_deg": "tilt",
}


def verdict_of(found: Found) -> tuple[Brief, list[Note]]:
    """Return the short answer, and all notes as data in the units of the specification."""
    asked = found.asked
    bare = _without_damper(asked)
    damper, judged = _best(found, bare)
    notes = list(_notes(found, damper))
    decision = _decision(found, damper, judged)
    dangers = [said for note in notes if (said := _said(found, note))]
    sentences = [*unusual_specification(asked), decision, *dangers, *_holds(found, damper)]
    rows = (*_assumed(found, damper), *_rows(found, damper, bare), *_accelerates(found, damper))
    return Brief(damper, tuple(sentences), rows, _next(found, notes, _exceeded(found, judged))), notes


def kind_of(build: Build) -> Damper:
    """Return the kind of a damper, from the parts that it has."""
    return damper_of(build.particle_mass_kg > 0.0, build.friction_force_n > 0.0)


def called_of(found: Found, damper: Damper) -> str:
    """Return a name for the damper found.

    The name is "as given" if nothing was chosen, and "recommended" if the verdict is to build this damper. Otherwise
    the name is "best" with the kind of the damper.
    """
    if not found.asked.free:
        return "as given"
    own = kind_of(found.build)
    return "recommended" if damper == own else f"best {CALLED[own]}"


def is_as_good(theirs: Score, ours: Score) -> bool:
    """Whether a damper with fewer parts is as good as the recommended damper."""
    keeps = theirs.violation <= ours.violation and not clearly_less(ours.most, theirs.most)
    return keeps and not clearly_less(ours.value, theirs.value)


def _best(found: Found, bare: float | None) -> tuple[Damper, Alternative | Beside | float | None]:
    """Return the kind of damper to build, and its results.

    The results are None if the verdict is to build the damper found.

    `bare` is the result of `_without_damper`.
    """
    ours = found.compared
    if not found.asked.free:
        return kind_of(found.build), None
    alone = {name: each for name, each in found.others.items() if is_as_good(each.score, ours)}
    if found.build.particle_mass_kg == 0.0:
        alone = {}
    damper: Damper = kind_of(found.build)
    best: Alternative | Beside | float | None = None
    if "friction_alone" in alone:
        damper, best = "friction_alone", alone["friction_alone"]
    elif "particle_alone" in alone:
        damper, best = "particle_alone", alone["particle_alone"]
    tuned = found.heaviest
    if tuned is not None and _tuned_wins(tuned, ours):
        damper, best = "tuned_mass_damper", tuned
    least = tuned.value if isinstance(best, Beside) and tuned else ours.value
    if bare is not None and not clearly_less(least, bare):
        damper, best = "no_damper", bare
    return damper, best


def _tuned_wins(tuned: Beside, ours: Score) -> bool:
    """Whether a tuned mass damper is better than `ours` if tuned exactly, and no worse if detuned by `DETUNED`.

    A tuned mass damper is also better if it keeps all limits and the damper found does not.
    """
    if ours.violation > 0.0 and not tuned.exceeded:
        return True
    better = clearly_less(tuned.value, ours.value) and not clearly_less(ours.value, tuned.detuned)
    return better and (ours.violation > 0.0 or not tuned.exceeded)


def _without_damper(asked: Specification) -> float | None:
    """Return the worst case of the structure without a damper, within its tolerances.

    The function returns None under records, and if a result other than the measure has a limit.
    """
    if asked.cases or asked.limits.keys() - {asked.measure.limit}:
        return None
    return hardest(asked, NO_DAMPER, judged_of(asked))[0]


def _decision(found: Found, damper: Damper, best: Alternative | Beside | float | None) -> str:
    asked = found.asked
    judged = asked.measure.judged
    stays = f"keeps the {judged} within"
    if isinstance(best, float):
        bare = response(asked, rounded_up(best, 3), 3)
        return f"Build no damper: without one the {judged} stays within {bare}, and none that was examined does better."
    if isinstance(best, Beside):
        reach = response(asked, rounded_up(best.value, 3), 3)
        if best.exceeded:
            nearest = f"Best is a tuned mass damper: {_tuned(asked, best)}; it {stays} {reach}."
            return f"No damper that was examined keeps every limit. {nearest}"
        detuned = _detuned(asked, best)
        return f"Use a tuned mass damper: {_tuned(asked, best)}; it {stays} {reach} ({detuned})."
    score = found.stated if best is None else best.score
    build = found.build if best is None else best.build
    if isinf(score.value):
        return f"Nothing bounds the {judged}: it grows without bound with every damper that was examined."
    reach = _reach(asked, score.value, score.most)
    if build.friction_force_n and locked(found, build):
        return _locked(found, build, reach)
    if not asked.free:
        word = "The given damper" if score.violation == 0.0 else "The given damper exceeds a limit: it"
        return f"{word} ({damper_words(asked, build)}) {stays} {reach}."
    if score.violation > 0.0:
        so_far = " before the budget was spent" if found.stopped == "budget" else ""
        best_of = f"Best: {damper_words(asked, build)}; it {stays} {reach}."
        return f"No damper that was examined{so_far} keeps every limit. {best_of}"
    if damper == "friction_alone":
        force = quantity(asked, "friction_force_n", build.friction_force_n, 3)
        return f"No particle needed: a friction force of {force} alone {stays} {reach}."
    what = "a particle without friction" if damper == "particle_alone" else "a particle and friction"
    return f"Build {what}: {damper_words(asked, build)}. That {stays} {reach}."


def _locked(found: Found, build: Build, reach: str) -> str:
    force = quantity(found.asked, "friction_force_n", build.friction_force_n, 3)
    judged = found.asked.measure.judged
    if all(each.motion.force for each in found.asked.excitations) and not found.asked.cases:
        return f"A friction force of {force} withstands the force at every frequency: the structure does not move."
    clamps = f"A friction force of {force} clamps the structure to its base: nothing is damped."
    return f"{clamps} The {judged} stays within {reach}, with the offset at which it sticks."


def _notes(found: Found, damper: Damper) -> Iterator[Note]:
    """Yield, as data, the facts that limit or change the decision."""
    asked, build, stated = found.asked, found.build, found.stated
    judged = build if damper != "friction_alone" else found.alternatives.get("friction_alone", found).build
    rubs = damper in ("hybrid", "friction_alone")
    if isinf(stated.value):
        yield Note("unbounded", "danger")
    for name, limit in asked.limits.items():
        if stated.reached[name] > limit:
            values = {
                "limit": name,
                "allowed": limit,
                "reached": stated.reached[name],
                "at_most": stated.at_most[name],
            }
            yield Note("limit_exceeded", "danger", values)
    if rubs and judged.friction_force_n and locked(found, judged):
        yield Note("locked", "danger", {"friction_force_n": judged.friction_force_n})
    elif rubs and _nearly_clamped(found, judged):
        yield Note("nearly_clamped", "danger", {"friction_force_n": judged.friction_force_n})
    grown = _grown(found, judged) if rubs or damper == "particle_alone" else None
    if grown is not None:
        amplitude, value, exact = grown
        values = {
            "amplitude": asked.level(amplitude) if asked.in_units else amplitude.reference_m,
            "value": value,
        }
        yield Note("amplitude", "danger", values | {"exact": exact})
    if damper == kind_of(build) and (draws := _draws(found)):
        yield Note("draws", "caution", {"draws": draws})
    starts = found.starts
    if damper == kind_of(build) and starts is not None and starts.beyond:
        values = {"value": starts.worst, "frequencies": starts.beyond, "of": starts.frequencies}
        yield Note("other_starts", "danger", values)
    builds = found.builds
    if builds is not None and builds.passed < builds.drawn and damper == kind_of(build):
        yield Note("builds", "caution", {"passed": builds.passed, "drawn": builds.drawn})
    ends = at_ends(found)
    if locked(found):
        # more friction changes nothing
        ends.pop("friction_force_n", None)
    if ends:
        yield Note("end_of_range", "hint", {name: [end, build.value(name)] for name, end in ends.items()})
    if found.stopped == "budget":
        yield Note("budget", "hint", {"points": found.book.spent})


def _said(found: Found, note: Note) -> str:
    """Write a note as a sentence of the verdict; empty if the verdict has no sentence for the note."""
    asked, known = found.asked, note.values
    if note.kind == "nearly_clamped":
        return "Its friction nearly clamps the structure to its base."
    if note.kind == "amplitude":
        amplitude = Amplitude(found.binding, 2.0 * found.binding.highest_m)
        at = (
            f"a {found.binding.motion.words} of {level(asked, amplitude)}"
            if asked.in_units
            else "twice the amplitude"
        )
        return f"Beware: at {at} it reaches {'' if known['exact'] else 'about '}{response(asked, known['value'], 3)}."
    if note.kind == "other_starts":
        where = f"at {known['frequencies']} of {known['of']} frequencies"
        return f"Beware: a disturbance can take it to {response(asked, known['value'], 3)} {where}."
    if note.kind == "draws":
        draws = known["draws"]
        worst = f"the worst of {draws} random records" if draws > 1 else "the response to one random record"
        return (
            f"Beware: this is {worst}. A further one exceeds it with a probability of at least 1/{draws + 1}."
        )
    if note.kind == "builds":
        kept = "keep the limits" if asked.limited_at_all else "stay within that"
        return f"Of {known['drawn']} builds drawn within the tolerances, {known['passed']} {kept}."
    return ""


def _draws(found: Found) -> int:
    """Count the records drawn from the random process of the worst case; 0 if the worst case is not under a random
    record.

    A further value of a continuous distribution exceeds the largest of n values with probability 1/(n + 1). The
    probability is larger if the damper was chosen for the n records that gave the n values.
    """
    under = found.stated.under
    if not isinstance(under, Case):
        return 0
    recipes = {case.source.recipe for case in found.asked.cases}
    return sum(same_process(each, under.source.recipe) for each in recipes)


def _nearly_clamped(found: Found, build: Build) -> bool:
    asked = found.asked
    if not asked.excitations or found.binding.motion.force:
        return False
    curve = found.book.curve(build, found.binding.largest)
    if not curve.r.size or not np.isfinite(curve.measured).all():
        return False
    held = float((curve["response_class"] == ResponseClass.LOCKED).mean())
    return held >= HELD and float(curve["amplitude_ratio"].max()) <= CLAMPED


def _grown(found: Found, build: Build) -> tuple[Amplitude, float, bool] | None:
    """Return twice the largest amplitude, the result under this amplitude, and whether the result is exact.

    The function returns None if the result divided by the amplitude grows by at most the factor `GROWS`.
    """
    asked = found.asked
    if not asked.excitations or asked.cases or asked.measure.mean:
        return None
    excitation = found.binding
    twice = Amplitude(excitation, 2.0 * excitation.highest_m)
    here = float(found.book.curve(build, excitation.largest).measured.max(initial=0.0))
    if build == found.build:
        shown = [
            found.book.curve(build, each).judged
            for each in found.shown
            if each.reference_m > 1.9 * excitation.highest_m
        ]
        if not shown:
            return None
        value, exact = shown[-1], True
    else:
        # friction alone at resonance, Den Hartog: (1 − 4γ_F/π) Z/2ζ
        structure, exact = asked.structure, False
        if (
            excitation.motion.order
            or not excitation.low <= 1.0 <= excitation.high
            or not structure.damping_ratio
        ):
            return None
        stiffness = structure.stiffness_n_per_m if asked.in_units else 1.0
        gamma = build.friction_force_n / (stiffness * twice.reference_m)
        ratio = max(1.0 - 4.0 * gamma / pi, 0.0) / (2.0 * structure.damping_ratio)
        value = asked.measure.factor * ratio * twice.reference_m if not asked.measure.order else 0.0
    return (twice, value, exact) if value > 2.0 * GROWS * here > 0.0 else None


def _holds(found: Found, damper: Damper) -> Iterator[str]:
    """Yield a sentence on the allowed range of each quantity, if the ranges were computed."""
    asked = found.asked
    if damper != kind_of(found.build) or found.stated.violation > 0.0 or isinf(found.stated.most):
        return
    parts = [
        f"{NAMES[name]} {each.span(partial(_span_end, asked, name))}"
        for name, each in found.margins.items()
        if (each.fails_below, each.fails_above) != (None, None)
        and (asked.rubs or name != PARTICLE_FRICTION.name)
    ]
    if parts:
        holds = "Limits hold" if asked.limits_measure else "The response rises by at most a tenth"
        yield f"{holds} for {', '.join(parts)}{', each alone' if len(parts) > 1 else ''}."


def _assumed(found: Found, damper: Damper) -> Iterator[tuple[str, str, str]]:
    """Describe the cavity of the particle, and the largest friction at which the damper works."""
    asked = found.asked
    told = {*asked.document, *asked.document.get("choose", {})}
    if CAVITY.intersection(told):
        cavity = found.build.cavity
        stands = cavity.tilt_deg == 90.0 and cavity.particle_friction_coefficient > 0.0
        assumed = "" if PARTICLE_FRICTION.name in told else "its friction is not given, and assumed to be 0"
        yield (
            "chosen" if CAVITY.intersection(asked.free) else "given",
            cavity.words,
            "friction has no effect in an upright cavity" if stands else assumed,
        )
    elif asked.choices["particle_mass_kg"].stop:
        yield (
            "assumed",
            "lying, frictionless",
            _with_friction(found) if damper == kind_of(found.build) else "",
        )


def _accelerates(found: Found, damper: Damper) -> Iterator[tuple[str, str, str]]:
    """State the acceleration of the structure, if neither the measure nor a limit is an acceleration."""
    asked, g = found.asked, acceleration_g(found)
    told = any("acceleration" in name for name in (asked.measure.name, *asked.limits))
    if g is not None and not told:
        own = kind_of(found.build)
        yield acceleration_row(g, whose=LARGEST if damper == own else f"with the best {CALLED[own]}")


def acceleration_g(found: Found) -> float | None:
    """Return the largest acceleration of the structure with the damper over the bands, in g.

    The function returns None where no closed form exists: under a force, under records, with a contact that takes time,
    and for a specification in ratios.
    """
    asked, build = found.asked, found.build
    takes_time = bool(asked.choices["restitution"].contact_times_s)
    if (
        takes_time
        or not asked.in_units
        or asked.records
        or any(each.motion.force for each in asked.excitations)
    ):
        return None
    curves = (found.book.curve(build, each.largest) for each in asked.excitations)
    return max(float(_accelerations(asked, build, each).max()) for each in curves if each.r.size)


def _accelerations(asked: Specification, build: Build, curve: Curve) -> NDArray[np.float64]:
    """Return the largest acceleration of the structure at each frequency, (n,) [g]."""
    scale, structure = curve.rate**2 * curve.base_m, asked.structure
    case = {"natural_frequency_hz": structure.natural_frequency_hz, "base_amplitude_m": 1.0}
    acting = Acting(
        structure.damping_ratio,
        build.friction_force_n / structure.mass_kg / scale,
        build.particle_mass_kg / structure.mass_kg,
        build.cavity.ratio(PARTICLE_FRICTION_RATIO, case) / curve.base_m,
    )
    ratios = accelerations(curve["relative_amplitude_ratio"], curve.r, curve["response_class"], acting)
    found: NDArray[np.float64] = scale * ratios / STANDARD_GRAVITY
    return found


def _with_friction(found: Found) -> str:
    """Describe the largest friction of the particle at which the damper keeps its limits.

    The text is empty if the margin of the particle friction is unknown, if a limit is exceeded without friction, or if
    the response is unbounded.
    """
    margin = found.margins.get(PARTICLE_FRICTION.name)
    if MOVED in found.left_out:
        return "the budget was spent before the friction was varied"
    if margin is None or found.stated.violation > 0.0 or isinf(found.stated.most):
        return ""
    kept = "limits hold" if found.asked.limits_measure else "the response rises by at most a tenth"
    if margin.high == 0.0:
        return f"fails at μ_i = {margin.fails_above:.3g}"
    beyond = "the highest examined" if margin.fails_above is None else f"not at {margin.fails_above:.3g}"
    return f"{kept} up to μ_i = {margin.high:.3g}, {beyond}"


def _rows(found: Found, damper: Damper, bare: float | None) -> Iterator[tuple[str, str, str]]:
    """Yield the limits that are exceeded, and the other dampers with their values."""
    asked = found.asked
    for name, limit in asked.limits.items():
        reached = found.stated.reached[name]
        if reached > limit:
            over, allowed = (limited(asked, name, asked.as_limited(name, each)) for each in (reached, limit))
            ours = called_of(found, damper) if asked.free else "given damper"
            whose = "" if damper == kind_of(found.build) else f", with the {ours}"
            yield asked.limit_key(name), over, f"{allowed} allowed{whose}"
    if bare is not None and damper != "no_damper":
        yield CALLED["no_damper"], _value(asked, bare), ""
    tuned = found.heaviest
    if tuned is not None and damper != "tuned_mass_damper":
        exceeds = ", exceeds a limit" if tuned.exceeded else ""
        yield (
            CALLED["tuned_mass_damper"],
            _value(asked, tuned.value),
            f"{_tuned(asked, tuned)}; {_detuned(asked, tuned)}{exceeds}",
        )
    for kind, each in found.others.items():
        if kind != damper:
            yield (
                CALLED[kind],
                _value(asked, each.score.value),
                damper_words(asked, each.build) + _exceeds(each.score),
            )
    if found.not_compared:
        kinds = listed(CALLED[kind] for kind in found.not_compared)
        yield "not compared", "", f"{kinds}: the budget was spent"
    if damper != kind_of(found.build) and asked.free:
        what = damper_words(asked, found.build)
        ends = [NAMES[name] for name in at_ends(found)]
        at_end = (
            f"; {listed(ends)} at the end of {'its range' if len(ends) == 1 else 'their ranges'}"
            if ends
            else ""
        )
        yield (
            called_of(found, damper),
            _value(asked, found.largest),
            what + at_end + _exceeds(found.compared),
        )


def _exceeded(found: Found, best: Alternative | Beside | float | None) -> Mapping[str, float]:
    """Return the limits that the damper of the verdict exceeds, each with a value that this damper keeps.

    `best` is the second result of `_best`.
    """
    limits = found.asked.limits
    if isinstance(best, Beside):
        return best.exceeded
    if isinstance(best, float):  # only the measure is limited, if at all
        return {name: best for name, limit in limits.items() if best > limit}
    score = found.stated if best is None else best.score
    return {name: score.at_most[name] for name, limit in limits.items() if score.reached[name] > limit}


def _next(found: Found, notes: list[Note], exceeded: Mapping[str, float]) -> str:
    asked, known = found.asked, {note.kind: note.values for note in notes}
    report = "-o report.html for a drawing with tolerances"
    more = f"more `{asked.budget_key}`, because the search was cut short" if "budget" in known else ""
    if exceeded:
        name, most = next(iter(exceeded.items()))
        key, enough = asked.limit_key(name), rounded_up(asked.as_limited(name, most))
        relax = f"relax the limit to `{key}: {enough:.4g}`" if not isinf(most) else f"drop `{key}`"
        if more:
            return f"{more}, or {relax}."
        return f"{relax}, or {_wider(asked, known) or found.otherwise(name)}."
    if not asked.free:
        return f"{report}."
    if known.keys() & {"locked", "nearly_clamped"} and "stick_fraction" not in asked.limits:
        return "forbid clamping with `limits: {stick_fraction: 0.2}`."
    if "end_of_range" in known:
        return f"{', or '.join(filter(None, (more, _wider(asked, known))))}."
    return f"{more or report}."


def _wider(asked: Specification, known: Mapping[str, Any]) -> str:
    """Advise wider ranges for the quantities at an end of their range; empty if there are none."""
    steps = [
        f"{NAMES[name]} {'above' if end == 'upper' else 'below'} {_span_end(asked, name, value)}"
        for name, (end, value) in known.get("end_of_range", {}).items()
    ]
    return f"allow {', '.join(steps)}" if steps else ""


def _span_end(asked: Specification, name: str, value: float) -> str:
    return spelled(value, unit_of(name) if asked.in_units else "", 3)


def _reach(asked: Specification, value: float, most: float) -> str:
    """Write the upper bound of a worst case, with the computed value if the two clearly differ."""
    if not clearly_less(value, most):
        return response(asked, rounded_up(most, 3), 3)
    return f"{response(asked, rounded_up(most, 3), 3)} ({response(asked, value, 3)} computed)"


def _value(asked: Specification, value: float) -> str:
    if isinf(value):
        return "grows without bound"
    return response(asked, value, 3) if asked.in_units else f"{value:.3g}{OVER[asked.measure.unit]}"


def _tuned(asked: Specification, beside: Beside) -> str:
    absorber = beside.absorber
    mass = f"μ = {absorber.mass_ratio:.3g}"
    if asked.in_units:
        mass = spelled(absorber.mass_ratio * asked.structure.mass_kg, "kg", 3)
    return f"{mass} at {frequency(asked, absorber.tuning)}, ζ = {absorber.damping_ratio:.2g}"


def _detuned(asked: Specification, beside: Beside) -> str:
    return f"{_value(asked, beside.detuned)} if {100 * DETUNED:.0f} % out of tune"


def _exceeds(score: Score) -> str:
    return ", exceeds a limit" if score.violation > 0.0 else ""
