"""Frequency response: one metric of one design over the frequency ratio."""

from dataclasses import replace
from math import isfinite, nan
from typing import TYPE_CHECKING, Any

from damperlab.studies.answers.largest_acceleration import acceleration_g
from damperlab.studies.answers.leading import leading_place
from damperlab.studies.answers.phrases import FREQUENCY, Phrases, said
from damperlab.studies.answers.selection import (
    as_float,
    check_free,
    check_metric,
    coded,
    companions,
    completeness,
    count,
    in_ratios,
    main_metric,
    read,
    say,
    scalars,
)
from damperlab.studies.questions import Selection
from damperlab.studies.units import metric_in_units, place_in_units, results_in_units

if TYPE_CHECKING:
    import xarray as xr


def frequency_response(
    cube: "xr.Dataset",
    selection: Selection = Selection(),
) -> "xr.Dataset":
    """Return one metric of one design over the frequency ratio.

    Parameters
    ----------
    cube : Dataset
        A study's cube, of which only the curve is read.
    selection : Selection
        The metric, and the values of the other dimensions; see `leading_place`. If the study is given in SI units,
        names in units such as `amplitude_m` and `clearance_m` are allowed too.

    Returns
    -------
    Dataset
        Dimension frequency_ratio. The variables are the metric and, if stored, `amplitude_error`, `response_class` and
        `status`. Scalar coordinates and attributes are as in `resonance_map`. For the main metric, the attribute
        `acceleration_g` is the largest acceleration of the structure over the frequencies [g], if known.

    Raises
    ------
    QueryFault
        If a dimension or the metric is not in the cube, or `at` names the frequency ratio.
    """
    import xarray as xr

    source = {each.name: each.source for each in results_in_units(cube)}
    if selection.metric in source:
        asked = replace(selection, metric=source[selection.metric])
        found = metric_in_units(cube, frequency_response(cube, asked), selection.metric)
        return place_in_units(cube, found)
    check_free(cube, selection.at, (FREQUENCY,), "curve")
    at, metric = in_ratios(cube, selection.at), selection.metric or main_metric(cube)
    check_metric(cube, metric)
    index, lead = leading_place(cube, at, (FREQUENCY,))
    names = (metric, *companions(cube, metric))
    values = {name: read(cube, name, index, (FREQUENCY,)) for name in names}
    if not coded(cube, metric):
        values[metric] = as_float(values[metric])
    status = values["status"]

    def note(phrases: Phrases) -> dict[str, Any]:
        words = say(cube, index, at, phrases, lead)
        if status.size == 1:
            words += " Only one frequency was computed, so the curve is one point."
        return {"note": words}

    felt = acceleration_g(cube, index) if metric == main_metric(cube) else nan
    return xr.Dataset(
        {name: ((FREQUENCY,), array, dict(cube[name].attrs)) for name, array in values.items()},
        {FREQUENCY: cube[FREQUENCY], **scalars(cube, index)},
        {
            **completeness(count(status)),
            **({"acceleration_g": felt} if isfinite(felt) else {}),
            **said(cube, note),
        },
    )
