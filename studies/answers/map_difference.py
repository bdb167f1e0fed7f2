"""Maps of one metric in two studies, and the difference between the two maps."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from damperlab.studies.answers.alike import alike, beside, require_equal
from damperlab.studies.answers.compared_response import ERRORS, ROUNDING
from damperlab.studies.answers.excited import definition_of
from damperlab.studies.answers.leading import at_its_place
from damperlab.studies.answers.nearness import same
from damperlab.studies.answers.phrases import RATIOS, Phrases, noted
from damperlab.studies.answers.query_fault import refused
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.answers.selection import check_metric, dimensions_of, main_metric
from damperlab.studies.faults import counted
from damperlab.studies.kinds import kind_of
from damperlab.studies.questions import Selection
from damperlab.studies.unit_names import COORDINATE_SOURCES, COORDINATES, LONG_NAMES
from damperlab.studies.units import coordinates_in_units, results_in_units
from damperlab.studies.vocabulary import Reduction

FIELD = "minus"
DIFFERENCE = "difference"
_BESIDE = ("amplitude_error", "amplitude_error_m", "response_class", "status")
"""Variables that accompany the metric in each study's map."""
_TOLD = frozenset(("name", "axes", "damping_ratio", "metrics", *COORDINATES, "restitution"))
"""Entries of a definition that are not compared, because they repeat the axes or do not change the results."""


def map_difference(
    cube: xr.Dataset,
    other: xr.Dataset,
    x: str,
    y: str,
    selection: Selection = Selection(),
    over: str | None = None,
    reduce: Reduction | None = None,
) -> xr.Dataset:
    """Compute a map for each of two studies, and subtract the second map from the first.

    Parameters
    ----------
    cube, other : Dataset
        The cubes of two studies of the same kind. The two cubes have equal values along the axes of the map
        and along the reduced dimensions. The note names other differences between the studies.
    x, y, selection, over, reduce
        As in `resonance_map`. For names in SI units (`clearance_m`, `amplitude_m`), the values of each study are
        converted with the structure of that study.

    Returns
    -------
    Dataset
        The map of `resonance_map` for `cube`, dimensions (y, x), with `other`, `other_amplitude_error`,
        `other_response_class` and `other_status` of the second study. `difference` is the first value minus the
        second, in the unit of the metric; it is NaN where a value is missing. `complete`, `points` and
        `points_failed` cover both studies together. If the two maps are taken at different values of further
        dimensions, `other_at` has the values of the second study. `note` says where the difference is largest, and
        how else the studies differ. `studies_differ` contains only the sentence on how else the studies differ, if
        they do.

    Raises
    ------
    QueryFault
        If `resonance_map` refuses a study, or if the values of the metric are codes. The field `minus` is
        refused if the second study is of another kind, has other values along an axis, or does not store the
        metric.
    """
    cube, other = alike((cube, other))
    metric = selection.metric or main_metric(cube)
    first = resonance_map(cube, x, y, selection, over, reduce)
    if "flag_values" in first[metric].attrs:
        advice = "choose a quantity, or ask for each study alone"
        raise refused("metric", metric, "a quantity where a study is subtracted", advice)
    _check_kind(cube, other, (x, y), metric)
    second = resonance_map(other, x, y, at_its_place(cube, first, selection), over, reduce)
    both = Phrases.of(cube), Phrases.of(other)
    reduced = dict.fromkeys(
        each.attrs[name] for each in (first, second) for name in ("over", "worst_over") if name in each.attrs
    )
    axes = [(first[name], second[name]) for name in (x, y)]
    axes += [(cube[name], other[name]) for name in reduced]
    for ours, theirs in axes:
        require_equal(FIELD, both, ours, theirs, "a point or a range that both have")

    answer = beside(first, second, metric, *_BESIDE)
    difference = first[metric].values.astype(float) - second[metric].values.astype(float)
    attributes = dict(first[metric].attrs)
    attributes["long_name"] = f"difference in {attributes.get('long_name', metric)}"
    attributes.setdefault("units", "1")
    answer[DIFFERENCE] = (first[metric].dims, difference, attributes)
    answer.attrs["other_at"] = {name: second[name].item() for name in _elsewhere(first, second)}

    def words(phrases: Phrases) -> dict[str, Any]:
        apart = "; ".join(_apart(cube, other, first, second, phrases))
        about = f"The studies differ in {apart}." if apart else "The studies differ in nothing else."
        told = {"studies_differ": about} if apart else {}
        return told | {"note": f"{where_apart(answer, metric, phrases)} {about}"}

    spoken = words(RATIOS)
    if "in_units" in first.attrs:
        spoken["in_units"] = words(_phrases(*both).as_named(selection.metric))
    answer.attrs |= noted(first.attrs, spoken)
    return answer


def _check_kind(cube: xr.Dataset, other: xr.Dataset, axes: tuple[str, str], metric: str) -> None:
    """Refuse a second study that cannot give a map with the same axes."""
    if dimensions_of(cube) != dimensions_of(other):
        kind, others = kind_of(cube.sizes).words, kind_of(other.sizes).words
        told = f"The first study is {kind}, the second {others}, so their maps have no axes in common."
        raise refused(FIELD, others, kind, f"name {kind}", told)
    known = [each.name for each in (*coordinates_in_units(other), *results_in_units(other))]
    for name in (*axes, metric):
        if name not in other.variables and name not in known:
            if name in dimensions_of(cube) or name in cube.data_vars:
                check_metric(other, name, FIELD)
            told = f"The second study is not given in the units that {name} needs."
            advice = "compare the two in ratios, or name a study with a physical block"
            raise refused(FIELD, "a study in ratios", f"a study that has {name}", advice, told)


def where_apart(answer: xr.Dataset, metric: str, phrases: Phrases) -> str:
    """Say where the difference is largest in each direction, and how many differences exceed the errors."""
    array = answer[DIFFERENCE]
    values = array.values
    y, x = map(str, array.dims)
    known = np.isfinite(values)
    if not known.any():
        return "No point has a value in both studies."
    size = np.maximum(np.abs(answer[metric].values), np.abs(answer["other"].values))
    distinct = known & (np.abs(values) > ROUNDING * size)
    if not distinct.any():
        return f"The first minus the second is 0 at every one of {counted(int(known.sum()), 'point')}."
    sentences = []
    for word, sign in (("lower", -1.0), ("higher", 1.0)):
        there = distinct & (sign * values > 0)
        if there.any():
            row, column = np.unravel_index(
                int(np.argmax(np.where(there, sign * values, -np.inf))), values.shape
            )
            at = " and ".join(
                _told(name, answer[name].values[index], phrases) for name, index in ((x, column), (y, row))
            )
            most = phrases.value(metric, abs(float(values[row, column])), ".4g")
            most += "" if phrases.unit(metric) or array.attrs["units"] == "1" else f" {array.attrs['units']}"
            sentences.append(
                f"the first is {word} at {there.sum():,} of {counted(int(known.sum()), 'point')}, by up to {most} ({at})"
            )
    told = "; ".join(sentences)
    error = {"amplitude_ratio": "amplitude_error", "amplitude_m": "amplitude_error_m"}.get(metric)
    if error in answer and f"other_{error}" in answer:
        both = answer[error].values + answer[f"other_{error}"].values
        beyond = int((distinct & (np.abs(values) > ERRORS * both)).sum())
        told += f"; at {beyond:,} the difference is more than {ERRORS:g} times the errors of both"
    return f"{told[0].upper()}{told[1:]}."


def _told(name: str, value: Any, phrases: Phrases) -> str:
    return str(value) if isinstance(value, str) else phrases.equal(name, float(value))


def _apart(
    cube: xr.Dataset, other: xr.Dataset, first: xr.Dataset, second: xr.Dataset, phrases: Phrases
) -> Iterator[str]:
    """Name the differences between the studies: chosen points, and entries of the definitions."""
    for name in _elsewhere(first, second):
        a, b = first[name].item(), second[name].item()
        if isinstance(a, str):
            yield f"{name} ({a} and {b})"
        else:
            yield f"{phrases.label(name)} ({phrases.pair(name, a, 'and', b)})"
    one, two = (_parts(each) for each in (cube, other))
    for part in dict.fromkeys((*one, *two)):
        if part.rpartition(".")[2] not in _TOLD and one.get(part) != two.get(part):
            yield f"`{part}`"


def _elsewhere(first: xr.Dataset, second: xr.Dataset) -> list[str]:
    """Return the dimensions along which the two maps are fixed at different values.

    A name in SI units, such as `clearance_m`, replaces the name of the ratio if both studies have it.
    """
    names = [str(name) for name in first.coords if first[name].ndim == 0]
    pairs = {name: (first[name].item(), second[name].item()) for name in names}
    apart = [
        name for name, (a, b) in pairs.items() if not (a == b or (not isinstance(a, str) and same(a, b)))
    ]
    told = {COORDINATE_SOURCES[name] for name in apart if name in COORDINATE_SOURCES}
    return [name for name in apart if name not in told]


def _parts(cube: xr.Dataset) -> dict[str, Any]:
    """Return the entries of a study's definition.

    Entries of the block `physical` get keys such as `physical.mass_kg`.
    """
    study: dict[str, Any] = definition_of(cube)
    physical = study.pop("physical", None) or {}
    return study | {f"physical.{name}": value for name, value in physical.items()}


def _phrases(ours: Phrases, theirs: Phrases) -> Phrases:
    """Return the `Phrases` for sentences about both studies.

    If the studies convert ratios to units with different factors, only the names in `LONG_NAMES` have units.
    """
    keys = ours.quantities.keys()
    if keys == theirs.quantities.keys() and all(
        same(ours.quantities[name].factor, theirs.quantities[name].factor) for name in keys
    ):
        return ours
    return Phrases({name: each for name, each in ours.quantities.items() if name in LONG_NAMES})
