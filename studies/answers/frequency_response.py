"""A curve: one metric over the frequency ratio at one design."""

import xarray as xr

from damperlab.studies.answers.between import INTERPOLATED, Between
from damperlab.studies.answers.faults import QueryFault
from damperlab.studies.answers.selection import (
    COMPANIONS,
    as_float,
    check_metric,
    choose,
    coded,
    completeness,
    count,
    main_metric,
    read,
    say,
    scalars,
)
from damperlab.studies.faults import Fault, describe
from damperlab.studies.questions import Selection

FREQUENCY = "frequency_ratio"


def frequency_response(
    cube: xr.Dataset,
    selection: Selection = Selection(),
) -> xr.Dataset:
    """Follow one design along the frequency ratio.

    Parameters
    ----------
    cube : Dataset
        A study's cube; only the curve is read.
    selection : Selection
        What is shown, and the values of the other five dimensions, see `selection.choose`. Values are interpolated linearly,
        frequency by frequency, where the class of response does not change; the answer then has `interpolated`, which says
        where that was done.

    Returns
    -------
    Dataset
        Dimension frequency_ratio. The metric, with `amplitude_error`, `response_class` and `status` where
        the cube has them. Coordinates without a dimension and attributes as in `resonance_map`.

    Raises
    ------
    QueryFault
        If a dimension or the metric is not in the cube, or `at` names the frequency ratio.
    """
    at, metric = selection.at, selection.metric or main_metric(cube)
    check_metric(cube, metric)
    if FREQUENCY in at:
        raise QueryFault(
            Fault(
                FREQUENCY,
                describe(at[FREQUENCY]),
                "nothing: the curve runs along frequency_ratio",
                "leave it out: every frequency of the study is in the answer",
            )
        )
    index = choose(cube, at, (FREQUENCY,))
    names = [name for name in COMPANIONS if name in cube.data_vars and name != metric]
    chosen = scalars(cube, index)
    if selection.interpolate:
        between = Between(cube, metric, at, (FREQUENCY,))
        values = between.read(names)
        chosen = between.scalars(at)
        note = between.say(at)
    else:
        values = {name: read(cube, name, index, (FREQUENCY,)) for name in (metric, *names)}
        if not coded(cube, metric):
            values[metric] = as_float(values[metric])
        note = say(cube, index, at)
    status = values["status"]
    if status.size == 1:
        note += " Only one frequency was computed, so the curve is one point."
    described = {name: INTERPOLATED if name == "interpolated" else dict(cube[name].attrs) for name in values}
    return xr.Dataset(
        {name: ((FREQUENCY,), array, described[name]) for name, array in values.items()},
        {FREQUENCY: cube[FREQUENCY], **chosen},
        {**completeness(*count(status), status.size), "note": note},
    )
