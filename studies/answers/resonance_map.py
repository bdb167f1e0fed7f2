"""Map of one metric over two dimensions. Each of the other dimensions is fixed or reduced."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.answers.band import say_frequency, say_worst, worst_by_default
from damperlab.studies.answers.fold import Extremum, Mean
from damperlab.studies.answers.hidden_peak import hidden_on
from damperlab.studies.answers.leading import leading_place
from damperlab.studies.answers.notes import sentences_of
from damperlab.studies.answers.phrases import FREQUENCY, Phrases, said
from damperlab.studies.answers.query_fault import check_question, refused
from damperlab.studies.answers.selection import (
    as_float,
    check_axis,
    check_dimension,
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
from damperlab.studies.brief import Note, notes_document
from damperlab.studies.faults import describe
from damperlab.studies.kinds import HARMONIC, kind_of
from damperlab.studies.questions import Plane, Selection
from damperlab.studies.units import (
    InUnits,
    coordinates_in_units,
    metric_in_units,
    place_in_units,
    results_in_units,
)
from damperlab.studies.variables import Status
from damperlab.studies.vocabulary import Reduction

if TYPE_CHECKING:
    import xarray as xr

PEAKS = ("amplitude_ratio", "amplitude_ratio_max")
"""Results that may have a resonance peak between the computed frequencies."""
BUDGET = 2**20
"""Number of points that are reduced together, each with four variables."""


def resonance_map(
    cube: "xr.Dataset",
    x: str,
    y: str,
    selection: Selection = Selection(),
    over: str | None = None,
    reduce: Reduction | None = None,
) -> "xr.Dataset":
    """Slice the cube along two dimensions.

    If the question names no frequency, the map shows the largest value of a quantity over the frequencies of the study.
    A map at r = 1 alone would recommend designs that are very bad at frequencies a few per cent away. Likewise, a map
    shows the largest value over the records of a suite, or over the base amplitudes of a study. If `over`
    names a further dimension, the largest values are then reduced along this dimension.

    Parameters
    ----------
    cube : Dataset
        A study's cube; only the needed part is read.
    x, y : str
        The dimensions of the map. If the study is given in SI units, names in units such as `clearance_m` are allowed
        too. The dimensions of the answer then have these names.
    selection : Selection
        The metric, and the values of the other dimensions; see `leading_place`.
    over, reduce : str, optional
        A third dimension, and its reduction over the points that have a value: "max" (the default), "min" or "mean".
        The maximum is unknown if a point failed. The cube is read slab by slab along this dimension.

    Returns
    -------
    Dataset
        Dimensions (y, x). The variables are the metric and, if the cube has them, `amplitude_error`, `response_class`
        and `status`. After a reduction to the maximum or minimum, all variables are taken at the point of the
        extremum, and `<over>_at` is the coordinate of this point. If a failed point leaves the maximum
        unknown, the variables are taken at the failed point. Among points with the same value, one at which
        the mass moves is preferred. For a mean, the error is the mean error and the status is the worst
        status; there is no class. After a reduction, `computed_share` is the share of the reduced points that
        were computed. The other dimensions are scalar coordinates. Attributes:
        `complete` (share of the points of the slice that were computed), `points`, `points_failed`, `reduce`, `over`,
        `note` (the choices in words), and `worst_over` (the second dimension over which the largest value was taken, if
        there is one).

    Raises
    ------
    QueryFault
        If a dimension or the metric is not in the cube, or if a dimension is used twice.
    """
    units = {each.name: each for each in (*coordinates_in_units(cube), *results_in_units(cube))}
    if units.keys() & {x, y, over, selection.metric}:
        return _in_units(cube, units, (x, y, over), selection, reduce)
    check_question(Plane(reduce=reduce))
    check_free(cube, selection.at, (x, y), "map")
    at, metric = in_ratios(cube, selection.at), selection.metric or main_metric(cube)
    check_axis(cube, "x", x)
    check_axis(cube, "y", y, (x,))
    check_metric(cube, metric)
    if over is None and reduce is not None:
        raise refused(
            "reduce",
            describe(reduce),
            "nothing without `over`",
            "name the dimension to reduce as `over`, or leave `reduce` out",
            "`reduce` needs `over`, the dimension that is reduced.",
        )
    used = {x, y, over, *at}
    uncontrolled = kind_of(cube.sizes).uncontrolled
    worst = worst_by_default(cube, used) and not coded(cube, metric)
    if over is None and not coded(cube, metric):
        over = next(
            (name for name in kind_of(cube.sizes).also if name not in used and cube.sizes[name] > 1), None
        )
    inner = uncontrolled if worst and over is not None else None
    if worst and over is None:
        over = uncontrolled
    if over is not None:
        check_dimension(cube, "over", over, (x, y))
        reduce = reduce or "max"
        if coded(cube, metric):
            raise refused(
                "metric",
                metric,
                "a quantity where `over` is given",
                "leave `over` out, or choose a metric that is a quantity",
                f"{metric} holds codes, which have no {reduce}, so no dimension can be reduced.",
            )
    free = tuple(name for name in (x, y, over, inner) if name is not None)
    index, lead = leading_place(cube, at, free)
    if over is None or reduce is None:
        answer = _slice(cube, x, y, metric, index)
    else:
        answer = _reduced(cube, (y, x), metric, (over, inner), reduce, index)
    # `hidden_on` expects the dimensions of a harmonic study
    peaks = (over, reduce) == (FREQUENCY, "max") and metric in PEAKS and kind_of(cube.sizes) is HARMONIC
    notes = hidden_on(cube, metric, (y, x), index) if peaks else []
    if over is not None and answer.attrs["complete"] < 1:
        notes.append(Note("incomplete", "caution", {"complete": answer.attrs["complete"], "reduce": reduce}))
    if (reduce == "max" or inner is not None) and answer.attrs["points_failed"]:
        notes.append(Note("failed", "caution", {"points": answer.attrs["points_failed"]}))

    def note(phrases: Phrases) -> dict[str, Any]:
        sentences = [say(cube, index, at, phrases, lead)]
        if over is not None and over in kind_of(cube.sizes).also:
            count_of, ends = cube.sizes[over], cube[over].values[[0, -1]]
            low, high = phrases.number(over, ends[0], "g"), phrases.value(over, ends[-1], "g")
            high += "" if phrases.unit(over) else " m"
            sentences.append(
                f"The {reduce} over the study's {count_of} {phrases.amplitude}s from {low} to {high}."
            )
        if worst:
            sentences.append(say_worst(cube, phrases))
        elif FREQUENCY in index:
            alone = float(cube[FREQUENCY].values[index[FREQUENCY]])
            sentences.append(say_frequency(cube, alone, coded(cube, metric), phrases))
        sentences.append(sentences_of(notes, phrases))
        return {"note": " ".join(filter(None, sentences))}

    answer.attrs |= said(cube, note) | {"notes": notes_document(notes)}
    return answer


def _in_units(
    cube: "xr.Dataset",
    units: Mapping[str, InUnits],
    named: tuple[str, str, str | None],
    selection: Selection,
    reduce: Reduction | None,
) -> "xr.Dataset":
    """Answer a question in SI units.

    The question is converted to ratios, and the axes and the metric of the answer are converted to SI units.
    """
    import xarray as xr

    x, y, over = named
    source = {name: each.source for name, each in units.items()}
    inner = None if over is None else source.get(over, over)
    metric = selection.metric
    asked = selection if metric is None else replace(selection, metric=source.get(metric, metric))
    answer = resonance_map(cube, source.get(x, x), source.get(y, y), asked, inner, reduce)
    answer = metric_in_units(cube, answer, metric)
    for each in (units[name] for name in (x, y) if name in units):
        scaled = xr.Variable((each.source,), each.of(answer[each.source].values), each.attributes)
        answer = answer.assign_coords({each.source: scaled}).rename({each.source: each.name})
    return place_in_units(cube, answer)


def _slice(cube: "xr.Dataset", x: str, y: str, metric: str, index: Mapping[str, int]) -> "xr.Dataset":
    values = {name: read(cube, name, index, (y, x)) for name in (metric, *companions(cube, metric))}
    status = values["status"]
    if not coded(cube, metric):
        values[metric] = as_float(values[metric])
    attributes = completeness(count(status))
    return _answer(cube, x, y, values, index, attributes)


def _reduced(
    cube: "xr.Dataset",
    dims: tuple[str, str],
    metric: str,
    along: tuple[str, str | None],
    reduce: str,
    index: Mapping[str, int],
) -> "xr.Dataset":
    """Take the maximum along the inner dimension, then reduce the result along the outer dimension.

    `along` contains the outer and the inner dimension. If the inner dimension is None, no maximum is taken.
    """
    y, x = dims
    over, inner = along
    extent, each = cube.sizes[over], 1 if inner is None else cube.sizes[inner]
    area = cube.sizes[x] * cube.sizes[y]
    step = max(1, BUDGET // (area * each))
    inner_step = max(1, BUDGET // (area * step))
    dims_read = (over, y, x) if inner is None else (inner, over, y, x)
    names = companions(cube, metric)
    fold: Mean | Extremum = Mean() if reduce == "mean" else Extremum(1.0 if reduce == "max" else -1.0)
    counts = np.zeros(3, np.int64)
    there = np.zeros((cube.sizes[y], cube.sizes[x]), np.int64)
    for start in range(0, extent, step):
        part = {**index, over: slice(start, start + step)}
        worst = Extremum(1.0)
        for first in range(0, each, inner_step):
            one = part if inner is None else {**part, inner: slice(first, first + inner_step)}
            values = as_float(read(cube, metric, one, dims_read))
            beside = {name: read(cube, name, one, dims_read) for name in names}
            if inner is None:
                values, beside = values[None], {name: array[None] for name, array in beside.items()}
            counts += count(beside["status"])
            there += (beside["status"] != Status.NOT_COMPUTED).sum(axis=(0, 1))
            worst.take(first, values, beside)
        found = worst.result()
        found["inner"] = found.pop("at")
        fold.take(start, found.pop("value"), found)
    folded = fold.result()
    places = {over: folded.pop("at", None), inner: folded.pop("inner", None)}
    answers = {metric: folded.pop("value"), **folded}
    attributes = {**completeness(counts), "over": over, "reduce": reduce}
    if inner is not None:
        attributes["worst_over"] = inner
    answer = _answer(cube, x, y, answers, index, attributes)
    along_names = over if inner is None else f"{over} and {inner}"
    answer["computed_share"] = (
        dims,
        there / (extent * each),
        {"units": "1", "long_name": f"share of the points along {along_names} that were computed"},
    )
    for name, place in places.items():
        if name is not None and place is not None:
            answer[f"{name}_at"] = _where(
                cube, dims, name, place, answers[metric], reduce if name == over else "max"
            )
    return answer


def _where(
    cube: "xr.Dataset",
    dims: tuple[str, str],
    name: str,
    place: np.ndarray,
    values: np.ndarray,
    reduce: str,
) -> "xr.Variable":
    """Return the coordinate of the extremum along a dimension.

    Without an extremum, the coordinate is NaN, or an empty text for a dimension of texts.
    """
    import xarray as xr

    found = cube[name].values[place]
    attributes = {
        "units": cube[name].attrs.get("units", "1"),
        "long_name": f"{cube[name].attrs.get('long_name', name)} of the {reduce}",
    }
    missing = "" if found.dtype.kind == "U" else np.nan
    return xr.Variable(dims, np.where(np.isnan(values), missing, found), attributes)


def _answer(
    cube: "xr.Dataset",
    x: str,
    y: str,
    values: Mapping[str, np.ndarray],
    index: Mapping[str, int],
    attributes: Mapping[str, Any],
) -> "xr.Dataset":
    import xarray as xr

    variables = {name: ((y, x), array, dict(cube[name].attrs)) for name, array in values.items()}
    coordinates = {y: cube[y], x: cube[x], **scalars(cube, index)}
    return xr.Dataset(variables, coordinates, dict(attributes))
