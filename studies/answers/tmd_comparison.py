"""Compare a hybrid damper with a tuned mass damper: responses, peaks, and where the hybrid is better."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.answers.band import WHY, runs
from damperlab.studies.answers.design_question import trapezoid
from damperlab.studies.answers.excited import excitation_of
from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.answers.leading import best_at
from damperlab.studies.answers.nearness import within_reach
from damperlab.studies.answers.notes import sentence_of
from damperlab.studies.answers.phrases import AMPLITUDE, FREQUENCY, Phrases, noted, said
from damperlab.studies.answers.query_fault import check_question, refused
from damperlab.studies.answers.selection import check_free, choose, in_ratios, require_stored
from damperlab.studies.answers.tmd_verdict import brief_of, is_judged, notes_of
from damperlab.studies.answers.verdict import BUILT, NEXT_BAND
from damperlab.studies.brief import Note, notes_document
from damperlab.studies.faults import describe
from damperlab.studies.field import At
from damperlab.studies.kinds import kind_of
from damperlab.studies.questions import MOST_ABSORBER_MASS, Selection, Tuning
from damperlab.studies.tmd.transfer import amplitude_ratio, exact_curves, highest, without_absorber
from damperlab.studies.tmd.tunings import MOST_UNDER_BASE, tuned
from damperlab.studies.variables import BEFORE, Status
from damperlab.studies.vocabulary import CRITERIA, Excitation

if TYPE_CHECKING:
    import xarray as xr

LEAST_MASS = 1e-12
"""Smallest mass ratio of an absorber. A smaller mass ratio gives a tuning of 1 within rounding."""


def tmd_comparison(
    cube: "xr.Dataset",
    tuning: Tuning = Tuning(),
    at: At | None = None,
) -> "xr.Dataset":
    """Compare one design of a study with a tuned mass damper on the same structure and excitation.

    Parameters
    ----------
    cube : Dataset
        A study's cube. If the design is named, only the curve of this design is read.
    tuning : Tuning
        The tuned mass damper. `mass_ratio` is the mass ratio of both dampers; the design has the nearest grid value,
        unless `at` names a mass ratio. `tmd_mass_ratio` is the mass ratio of the tuned mass damper alone. By default,
        the structure with a tuned mass damper and the structure without a damper have the excitation of the study.
        Under a force, amplitudes are relative to the static displacement F₀/k.
    at : mapping of float, optional
        The design, as in `frequency_response`. Parameters that are not named are those of the recommended design (see
        `leading.best_at`).

    Returns
    -------
    Dataset
        Dimension frequency_ratio. `hybrid` is the amplitude ratio with the study's damper, with `amplitude_error`,
        `response_class` and `status`. `tmd` and `no_damper` are exact amplitude ratios at the same frequencies.

        Attributes of the absorber: `tmd_mass_ratio`, `tmd_tuning`, `tmd_damping_ratio` (over the natural frequency of
        the absorber) and `tmd_damping_over_structure` (over the natural frequency of the structure).

        Peaks: `hybrid_peak` is the largest value of `hybrid`, or infinite if a response is unbounded. `hybrid_peak_at`
        is the frequency ratio of this peak, and `hybrid_peak_error` is the error, or NaN if the study stores none.
        `tmd_peak` and `tmd_peak_at` are exact over the same band, and `tmd_peak_everywhere` is exact over all
        frequencies. `ratio` is `hybrid_peak` divided by `tmd_peak`. `judged` says whether it is known which peak is
        lower.

        Bands: `hybrid_bandwidth` and `tmd_bandwidth` are the shares of the band in which X/Z exceeds the peak divided
        by √2. `hybrid_better` has the lowest and the highest frequency of each group of neighbouring grid
        frequencies at which the hybrid is better by more than its error. `hybrid_better_share` is the number
        of these frequencies divided by the number of frequencies with a known or unbounded response.

        Others: `exact` holds both exact curves for drawing, at frequencies close enough to miss no peak
        (`exact_curves`). `complete`, `points`, `points_failed` and `note` are those of `frequency_response`,
        with sentences about the comparison added to `note`. `verdict` says in sentences which damper is better or, at
        one frequency, what to compute next.

    Raises
    ------
    QueryFault
        If an argument is not allowed, or a mass is needed and the study has none.
    """
    at = dict(in_ratios(cube, at or {}))
    require_stored(cube, "study", AMPLITUDE, otherwise="")
    check_question(tuning)
    criterion, mass_ratio = tuning.criterion, tuning.mass_ratio
    excitation = _excitation(cube, tuning.excitation)
    if mass_ratio is not None:
        # if the mass of the absorber is given, the particle may have no mass
        least = LEAST_MASS if tuning.tmd_mass_ratio is None else 0.0
        _check_mass("mass_ratio", mass_ratio, "correct it, or leave it out to use that of the design", least)
        # the absorber may have any mass; it is compared with the particle of the nearest mass in the study
        masses = cube["mass_ratio"].values
        near = (
            mass_ratio
            if within_reach(masses, mass_ratio)
            else float(np.clip(mass_ratio, masses.min(), masses.max()))
        )
        at.setdefault("mass_ratio", near)
    check_free(cube, at, (FREQUENCY,), "curve")
    choose(cube, at, (FREQUENCY,))
    lead = best_at(cube, at)
    best = lead.at
    curve = frequency_response(cube, Selection(AMPLITUDE, {**at, **best}))
    own = float(curve["mass_ratio"]) if mass_ratio is None else mass_ratio
    if tuning.tmd_mass_ratio is None:
        field, mass = "mass_ratio", own
        _check_mass(
            field, mass, "the particle of this design has no mass: name the mass of the tuned mass damper"
        )
    else:
        field, mass = "tmd_mass_ratio", tuning.tmd_mass_ratio
        _check_mass(field, mass, "correct it, or leave it out to use that of the design")
    if criterion == "h2" and excitation == "base" and mass >= MOST_UNDER_BASE:
        allowed = f"below {MOST_UNDER_BASE:g} for h2 with a shaken base"
        raise refused(field, describe(mass), allowed, "choose another criterion")
    structural = float(curve["damping_ratio"])
    absorber = tuned(criterion, mass, structural, excitation)
    absorber = absorber.detuned(tuning.detuning, tuning.damping_detuning)
    order = np.argsort(curve[FREQUENCY].values)
    curve = curve.isel({FREQUENCY: order})
    r = curve[FREQUENCY].values
    hybrid = curve[AMPLITUDE].values
    beside = amplitude_ratio(r, absorber, structural, excitation)
    answer = curve.rename({AMPLITUDE: "hybrid"})
    answer["hybrid"].attrs["long_name"] = "amplitude ratio X/Z, the study's damper"
    for name, values, long_name in (
        ("tmd", beside, "amplitude ratio X/Z, tuned mass damper"),
        ("no_damper", without_absorber(r, structural, excitation), "amplitude ratio X/Z, no damper"),
    ):
        answer[name] = (FREQUENCY, values, {"units": "1", "long_name": long_name})
    error = curve["amplitude_error"].values if "amplitude_error" in curve else np.full(r.size, np.nan)
    top = highest(absorber, structural, excitation, (float(r[0]), float(r[-1])))
    known = np.isfinite(hybrid)
    unbounded = curve["status"].values == Status.UNBOUNDED
    reached = np.where(unbounded, math.inf, hybrid)
    place = -1 if np.isnan(reached).all() else int(np.nanargmax(reached))
    peak = float(reached[place])
    better = known & (hybrid + np.nan_to_num(error) < beside)
    answer.attrs |= {
        "criterion": criterion,
        "criterion_means": CRITERIA[criterion],
        "detuning": tuning.detuning,
        "damping_detuning": tuning.damping_detuning,
        "excitation": excitation,
        "tmd_mass_ratio": mass,
        "tmd_tuning": absorber.tuning,
        "tmd_damping_ratio": absorber.damping_ratio,
        "tmd_damping_over_structure": absorber.damping_over_structure,
        "band": [float(r[0]), float(r[-1])],
        "hybrid_peak": peak,
        "hybrid_peak_error": float(error[place]),
        "hybrid_peak_at": math.nan if np.isnan(peak) else float(r[place]),
        "tmd_peak": top.value,
        "tmd_peak_at": top.frequency_ratio,
        "tmd_peak_everywhere": highest(absorber, structural, excitation).value,
        "ratio": peak / top.value,
        "hybrid_bandwidth": _above(r, hybrid, peak / math.sqrt(2)),
        "tmd_bandwidth": _above(r, beside, top.value / math.sqrt(2)),
        "exact": exact_curves(r, absorber, structural, excitation),
        "hybrid_better": runs(r, better),
        "hybrid_better_share": float(better.sum() / (known | unbounded).sum()) if known.any() else math.nan,
    }
    answer.attrs["judged"] = is_judged(answer)
    notes = notes_of(cube, answer)
    if lead.complete < 1.0:
        notes.append(Note("incomplete", "danger", {"complete": lead.complete}))
    of_design = [name for name in (*BEFORE, *kind_of(cube.sizes).designs) if name in answer.coords]
    varied = [name for name in of_design if cube.sizes.get(name, 1) > 1]
    design = {name: float(answer[name]) for name in of_design if name in (varied or BUILT)}

    def words(phrases: Phrases) -> dict[str, Any]:
        # the units of a study with a shaken base do not apply to amplitudes under a force
        spelled = phrases
        if excitation != excitation_of(cube):
            spelled = Phrases({name: each for name, each in phrases.quantities.items() if name in cube.sizes})
        brief = brief_of(cube, answer, design, notes, spelled)
        chosen = _say_best(best, lead.called, bool(at), spelled)
        note = " ".join([*chosen, _words(answer, spelled, notes)])
        return {"verdict": list(brief.sentences), "brief": brief.document(), "note": note}

    if r.size == 1:
        answer.attrs["next_frequencies"] = dict(NEXT_BAND)
    answer.attrs |= noted(curve.attrs, said(cube, words)) | {"notes": notes_document(notes)}
    return answer


def _say_best(best: Mapping[str, float], called: str, named: bool, phrases: Phrases) -> list[str]:
    """Name the compared design if the question did not specify all parameters."""
    if not best:
        return []
    at = ", ".join(phrases.equal(name, value) for name, value in best.items())
    among = "among those with the named values" if named else "of the study, as no design was named"
    return [f"The compared design is the {called} {among}: {at}."]


def _excitation(cube: "xr.Dataset", asked: Excitation | None) -> Excitation:
    """Return the excitation of the comparison.

    A question about a study with base excitation may name a force instead.
    """
    own = excitation_of(cube)
    if asked is None:
        return own
    if own == "force" and asked != own:
        raise refused("excitation", describe(asked), "force, the excitation of the study", "leave it out")
    return asked


def _check_mass(field: str, mass_ratio: float, advice: str, least: float = LEAST_MASS) -> None:
    if not least <= mass_ratio <= MOST_ABSORBER_MASS:
        allowed = f"a number from {least:g} to {MOST_ABSORBER_MASS:g}"
        raise refused(field, describe(mass_ratio), allowed, advice)


def _above(r: np.ndarray, values: np.ndarray, level: float) -> float:
    """Return the share of the band in which values exceed a level, with the weights of the trapezoidal rule."""
    if r.size == 1:
        return math.nan
    weights = trapezoid(r)
    known = np.isfinite(values)
    total = weights[known].sum()
    if total == 0.0 or not math.isfinite(level):
        return math.nan
    return float(weights[known & (values > level)].sum() / total)


def _words(answer: "xr.Dataset", phrases: Phrases, notes: list[Note]) -> str:
    found: dict[str, Any] = answer.attrs
    r = answer[FREQUENCY].values
    in_units = bool(phrases.unit("mass_ratio") and phrases.unit(FREQUENCY))
    mass, own = found["tmd_mass_ratio"], found["tmd_tuning"]
    tuned_to = (
        f"mass {phrases.value('mass_ratio', mass)}, frequency {phrases.value(FREQUENCY, own)}"
        if in_units
        else f"μ = {mass:.6g}, γ = {own:.6g}"
    )
    sentences = [
        f"Tuned mass damper: {found['criterion_means']}; {tuned_to}, "
        f"ζ = {found['tmd_damping_ratio']:.6g} relative to its own frequency "
        f"({found['tmd_damping_over_structure']:.6g} relative to the structure's)."
    ]
    other = [sentence_of(each, phrases) for each in notes if each.kind == "other_excitation"]
    sentences += other
    if not other and found["excitation"] == "force":
        sentences.append("A force excites both structures; ratios are relative to the static displacement.")
    if r.size == 1:
        at = phrases.equal(FREQUENCY, r[0], ".10g")
        sentences.append(f"Compared at {at} only, where both may look better than they are. {WHY}")
    else:
        span = phrases.span(FREQUENCY, r[0], r[-1], ".10g")
        sentences.append(f"Compared by the largest value over {span}.")
    return " ".join(sentences)
