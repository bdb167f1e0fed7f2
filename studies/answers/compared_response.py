"""Compare the frequency responses of one design in two studies with the same frequencies."""

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from damperlab.studies.answers.alike import alike, beside, require_equal
from damperlab.studies.answers.band import runs
from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.answers.leading import at_its_place
from damperlab.studies.answers.phrases import FREQUENCY, Phrases, noted, said
from damperlab.studies.answers.query_fault import refused
from damperlab.studies.answers.selection import check_metric, coded, main_metric
from damperlab.studies.faults import counted
from damperlab.studies.questions import Selection
from damperlab.studies.variables import BEFORE

ERRORS = 3.0
"""Two values count as different if the difference exceeds this multiple of the sum of the two errors."""
OWN_ERRORS = {
    "amplitude_ratio": "amplitude_error",
    "impacts_per_cycle": "impacts_error",
    "dissipation_viscous": "dissipation_error",
    "dissipation_friction": "dissipation_error",
    "dissipation_impact": "dissipation_error",
    "dissipation_particle": "dissipation_error",
}
"""For each quantity, the name of the variable with its error."""
ROUNDING = 1e-6
"""Relative difference below which two values count as equal, even if both errors are zero."""


def compared_response(
    cube: xr.Dataset,
    other: xr.Dataset,
    selection: Selection = Selection(),
) -> xr.Dataset:
    """Compare the response of one design over frequency in two studies, and report where the values differ.

    To find hysteresis, compare a study with ascending frequencies and a study with descending frequencies.

    Parameters
    ----------
    cube, other : Dataset
        The cubes of two studies with the same frequencies.
    selection : Selection
        The quantity to compare and the design, as in `frequency_response`. The quantity must not be a code, and both
        studies must contain the design.

    Returns
    -------
    Dataset
        The answer of `frequency_response` for `cube`, with `other`, `other_amplitude_error`, `other_response_class`
        and `other_status` of the second study. `differs` is 1 where the two values differ by more than `ERRORS` times
        the sum of their errors, plus the relative difference `ROUNDING`. `differs` is 0 elsewhere, also where an error
        is unknown. Attributes: `errors_unknown` (number of frequencies with an unknown error), `apart` (lowest and highest
        frequency of each run of differing values), `largest_difference` and `largest_difference_at`. `complete`,
        `points` and `points_failed` cover both studies together.

    Raises
    ------
    QueryFault
        If `frequency_response` refuses a study, if the studies differ in their frequencies or in the design, or if the
        metric has codes.
    """
    cube, other = alike((cube, other))
    metric = selection.metric or main_metric(cube)
    check_metric(cube, metric)
    first = frequency_response(cube, selection)
    selection = at_its_place(cube, first, selection)
    second = frequency_response(other, selection)
    if coded(cube, metric):
        advice = "choose a quantity, or ask for each study alone"
        raise refused("metric", metric, "a quantity where two studies are compared", advice)
    both = Phrases.of(cube), Phrases.of(other)
    for name in first.coords:
        # a study with particle friction or gravity may be compared with a study that has neither
        if name not in BEFORE:
            require_equal("with", both, first[name], second[name], "subtract their maps with `minus`")
    errors = _errors(cube, metric, selection) + _errors(other, metric, selection)
    a, b = first[metric].values, second[metric].values
    distance = np.abs(a - b)
    limit = ERRORS * errors + ROUNDING * np.maximum(np.abs(a), np.abs(b))
    known = np.isfinite(distance)
    unknown = known & ~np.isfinite(limit)
    differs = distance > limit  # False if a value or an error is unknown
    answer = beside(first, second, metric, "amplitude_error", "response_class", "status")
    answer["differs"] = (
        FREQUENCY,
        differs.astype(np.int8),
        {
            "units": "1",
            "long_name": f"whether the two studies differ by more than {ERRORS:g} times their errors",
        },
    )
    r = first[FREQUENCY].values
    order = np.argsort(r)
    spans = runs(r[order], differs[order])
    answer.attrs |= {"apart": spans, "errors_unknown": int(unknown.sum())}
    place = int(np.argmax(np.where(differs, distance, -1.0)))
    if differs.any():
        answer.attrs |= {
            "largest_difference": float(distance[place]),
            "largest_difference_at": float(r[place]),
        }

    def sentences(phrases: Phrases) -> str:
        words = say_difference(answer, metric, phrases)
        if spans:
            where = ", ".join(
                phrases.number(FREQUENCY, low)
                + (f" to {phrases.number(FREQUENCY, high)}" if low < high else "")
                for low, high in spans
            )
            words += f" They differ at {phrases.symbol(FREQUENCY)} = {where}{phrases.unit(FREQUENCY)}."
        if unknown.any():
            words += f" At {counted(int(unknown.sum()), 'frequency ratio')} an error is unknown, so nothing is compared there."
        if known.any() and not known.all():
            lacking = counted(int((~known).sum()), "frequency ratio")
            words += f" At {lacking} one of the two has no value, so nothing is compared there."
        return words

    def words(phrases: Phrases) -> dict[str, Any]:
        return {"note": sentences(phrases.as_named(selection.metric))}

    answer.attrs |= noted(first.attrs, said(cube, words))
    return answer


def say_difference(answer: xr.Dataset, metric: str, phrases: Phrases, form: str = ".6g") -> str:
    """Say at how many frequencies two responses differ, and where most, from the answer of `compared_response`."""
    differs = answer["differs"].values
    if not np.isfinite(answer[metric].values - answer["other"].values).any():
        return "No frequency has a value in both studies."
    if not differs.any():
        return f"The two responses differ nowhere by more than {ERRORS:g} times their errors."
    most = answer.attrs["largest_difference_at"]
    place = answer[FREQUENCY].values.tolist().index(most)
    ours, theirs = (float(answer[name].values[place]) for name in (metric, "other"))
    return (
        f"The two responses differ by more than {ERRORS:g} times their errors at {int(differs.sum())} of "
        f"{differs.size} frequencies, most at {phrases.equal(FREQUENCY, most, form)}: "
        f"{phrases.pair(metric, ours, 'against', theirs, form)}."
    )


def _errors(cube: xr.Dataset, metric: str, selection: Selection) -> NDArray[np.float64]:
    """Return the errors of a quantity along a curve.

    A quantity without an error variable is assumed to have the relative error of the amplitude.
    """
    own = OWN_ERRORS.get(metric)
    needed = (own,) if own else (metric, "amplitude_error", "amplitude_ratio")
    if any(name not in cube for name in needed):
        return np.full(cube.sizes[FREQUENCY], np.nan)
    values = [frequency_response(cube, replace(selection, metric=name))[name].values for name in needed]
    if own:
        return values[0]
    of_metric, error, amplitude = values
    errors: NDArray[np.float64] = np.abs(of_metric) * error / amplitude
    return errors
