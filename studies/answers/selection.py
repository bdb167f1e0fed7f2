"""Functions that all questions use to check names, choose grid points, read variables, and describe the choices."""

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.answers.excited import definition_of
from damperlab.studies.answers.nearness import check_reach, nearest_place, same
from damperlab.studies.answers.phrases import Phrases
from damperlab.studies.answers.query_fault import refused
from damperlab.studies.faults import describe, listing, nearest
from damperlab.studies.field import At
from damperlab.studies.ground.builtin import whole_id
from damperlab.studies.kinds import kind_of
from damperlab.studies.unit_names import AMPLITUDES
from damperlab.studies.units import coordinates_in_units, results_in_units
from damperlab.studies.variables import STEPPED, Status

if TYPE_CHECKING:
    import xarray as xr

COMPANIONS: tuple[str, ...] = ("amplitude_error", "response_class", "growth", "status")
"""Variables that accompany a metric, so that no value appears without its error, class and status."""


class Lead(NamedTuple):
    """Values of the best design along the dimensions that a question leaves open.

    `called` names the design in words, and `complete` is the share of the designs that are computed.
    """

    at: Mapping[str, float]
    called: str
    complete: float = 1.0


NO_LEAD = Lead({}, "")


def dimensions_of(cube: "xr.Dataset") -> tuple[str, ...]:
    """Return the dimensions of a study's cube, in order."""
    return tuple(map(str, cube["status"].dims))


def main_metric(cube: "xr.Dataset") -> str:
    """Return the name of the default metric for a study."""
    return kind_of(cube.sizes).metric


def check_dimension(cube: "xr.Dataset", field: str, name: str, taken: Iterable[str] = ()) -> None:
    """Raise `QueryFault` unless `name` is a dimension of the cube and is not in `taken`."""
    dimensions = dimensions_of(cube)
    allowed = [dimension for dimension in dimensions if dimension not in taken]
    if name not in allowed:
        advice = "choose one that no other argument uses" if name in dimensions else _guess(name, allowed)
        raise refused(field, describe(name), f"one of {listing(allowed)}", advice)


def check_metric(cube: "xr.Dataset", name: str, field: str = "metric") -> None:
    """Raise `QueryFault` unless the cube holds the variable `name`."""
    if name in cube.data_vars:
        return
    in_units = (each.name for each in results_in_units(cube))
    stored = list(dict.fromkeys((*map(str, cube.data_vars), *in_units)))
    if name in kind_of(cube.sizes).variables:
        found, advice = (
            f"{name}, which the study does not store",
            f"{_submit(cube, name)}, or choose one of them",
        )
    else:
        found, advice = describe(name), _guess(name, stored)
    raise refused(field, found, f"one of {listing(stored)}", advice)


def check_quantity(cube: "xr.Dataset", name: str, told: str) -> None:
    """Raise `QueryFault` if the cube lacks the variable or the variable holds codes. `told` completes the message."""
    check_metric(cube, name)
    if coded(cube, name):
        advice = "choose a metric that is a quantity"
        raise refused("metric", name, "a quantity", advice, f"{name} holds codes, {told}.")


def require_stored(cube: "xr.Dataset", field: str, *names: str, otherwise: str | None = None) -> None:
    """Raise `QueryFault` if the cube lacks a variable that a question needs in addition to the metric.

    Parameters
    ----------
    cube : Dataset
        A study's cube.
    field : str
        The argument that needs the variables, as the user typed the argument.
    *names : str
        The variables.
    otherwise : str, optional
        Alternative in the message. By default, the advice is to leave the argument out. "" gives no alternative.
    """
    missing = [name for name in names if name not in cube.data_vars]
    if missing:
        advice = _submit(cube, *missing)
        otherwise = f"leave {field} out" if otherwise is None else otherwise
        if otherwise:
            advice += f", or {otherwise}"
        allowed = f"a study that stores {'it' if len(missing) == 1 else 'them'}"
        found = f"a study that does not store {listing(missing)}"
        told = f"The study does not store {listing(missing)}, which `{field}` needs."
        raise refused(field, found, allowed, advice, told)


def _submit(cube: "xr.Dataset", *names: str) -> str:
    advice = f"add {listing(names)} to `metrics` and submit again"
    known = kind_of(cube.sizes).variables
    if any(known[name].start for name in names):
        return f"{advice} with `start: {{kind: ensemble}}`"
    solver = definition_of(cube).get("solver", {})
    if solver.get("method") == "rk4" and not set(STEPPED).issuperset(names):
        return f"{advice} with `solver: {{method: event}}`"
    return advice


def _guess(name: str, known: list[str]) -> str:
    meant = nearest(name, known)
    return f"did you mean {meant}?" if meant else "the study's definition lists what it stores"


def check_axis(cube: "xr.Dataset", field: str, name: str, taken: Iterable[str] = ()) -> None:
    """Raise `QueryFault` unless `name` is a dimension of numbers and is not in `taken`.

    Texts have no numerical order.
    """
    check_dimension(cube, field, name, taken)
    if cube[name].dtype.kind == "U":
        allowed = [each for each in dimensions_of(cube) if cube[each].dtype.kind == "f" and each not in taken]
        advice = f"choose one {name} with `{name}=`, or reduce over all of them with `over={name}`"
        raise refused(field, describe(name), f"one of {listing(allowed)}", advice)


def check_free(cube: "xr.Dataset", at: At, axes: Iterable[str], answer: str) -> None:
    """Raise `QueryFault` if a question fixes the value of a dimension along which the answer runs.

    Parameters
    ----------
    cube : Dataset
        The cube.
    at : mapping of float or str
        The values that the question fixes, as ratios or in units.
    axes : iterable of str
        Dimensions of the answer.
    answer : str
        Name of the answer.
    """
    sources = {each.name: each.source for each in coordinates_in_units(cube)}
    axes = tuple(axes)
    for name, value in at.items():
        if sources.get(name, name) in axes:
            why = "the curve runs along it" if answer == "curve" else f"it is an axis of the {answer}"
            told = f"{{field}} cannot be fixed here, because {why}."
            advice = "leave it out: every value of it is in the answer"
            advice += "" if answer == "curve" else "; choose other axes with `x` and `y`"
            runs = f"the {answer} runs along {sources.get(name, name)}"
            raise refused(name, describe(value), f"nothing: {runs}", advice, told)


def choose(cube: "xr.Dataset", at: At, free: tuple[str, ...]) -> dict[str, int]:
    """Choose a grid point for every dimension that is not `free`.

    Parameters
    ----------
    cube : Dataset
        The cube.
    at : mapping of float or str
        Wanted values. The nearest grid point is taken; a record is found by its name. Along a dimension that is not
        named, the first point is taken, and along the frequency ratio the point nearest r = 1.
    free : tuple of str
        Dimensions along which no point is chosen.

    Returns
    -------
    dict of int
        Index by dimension.

    Raises
    ------
    QueryFault
        If `at` names an unknown or a free dimension, if a value is not a finite number or lies far outside its axis, or
        if the study has no record of that name.
    """
    for name in at:
        check_dimension(cube, name, name, free)
    index = {}
    for dimension in dimensions_of(cube):
        if dimension in free:
            continue
        values = cube[dimension].values
        unasked = 1.0 if dimension == "frequency_ratio" else values[0]
        wanted = at.get(dimension, unasked)
        if values.dtype.kind == "U":
            index[dimension] = _named(dimension, values, wanted)
            continue
        number = finite(dimension, wanted)
        check_reach(dimension, values, number)
        index[dimension] = nearest_place(values, number)
    return index


def _named(dimension: str, values: np.ndarray, wanted: object) -> int:
    whole = whole_id(str(wanted))
    found = np.flatnonzero(values == whole)
    if not found.size:
        known = values.tolist()
        raise refused(dimension, describe(wanted), f"one of {listing(known)}", _guess(whole, known))
    return int(found[0])


def finite(dimension: str, wanted: object) -> float:
    """Return a wanted value along a dimension; raise `QueryFault` if the value is not a finite number."""
    if not isinstance(wanted, float | int) or not math.isfinite(wanted):
        raise refused(dimension, describe(wanted), "a finite number", "name a value on the axis")
    return float(wanted)


def in_ratios(cube: "xr.Dataset", at: At) -> At:
    """Convert wanted values, which can be in SI units, to values along the cube's dimensions.

    Raises
    ------
    QueryFault
        If a dimension is given both as a ratio and in units, or if a value lies far outside its axis.
    """
    units = {each.name: each for each in coordinates_in_units(cube)}
    found: dict[str, float | str] = {}
    for name, value in at.items():
        source = units[name].source if name in units else name
        if name in units:
            check_reach(name, units[name].of(cube[source].values), finite(name, value))
        if source in found:
            advice = f"give either {name} or {source}" if name in units else "leave one of the two out"
            told = f"{{field}} gives a second value of {source}."
            raise refused(name, "a second value of one dimension", "one value for each", advice, told)
        found[source] = finite(name, value) / units[name].factor if name in units else value
    return found


def companions(cube: "xr.Dataset", metric: str) -> list[str]:
    """Return the names of `COMPANIONS` that the cube has.

    For an amplitude in metres, `amplitude_error_m` replaces `amplitude_error` if the cube has
    `amplitude_error_m`.
    """
    in_units = metric in AMPLITUDES.values() and "amplitude_error_m" in cube.data_vars
    names = ("amplitude_error_m" if name == "amplitude_error" and in_units else name for name in COMPANIONS)
    return [name for name in names if name in cube.data_vars and name != metric]


def say(cube: "xr.Dataset", index: Mapping[str, int], at: At, phrases: Phrases, lead: Lead) -> str:
    """Describe the chosen grid points, and say which points differ from the wanted values."""
    kind = kind_of(cube.sizes)
    met = [name for name in kind.dimensions if name not in kind.designs]
    chosen_at = []
    for name, position in index.items():
        values = cube[name].values
        if values.dtype.kind == "U":
            chosen = "" if name in at or values.size == 1 else f" (by default, one of {values.size})"
            chosen_at.append(f"{name} = {values[position]}{chosen}")
            continue
        phrase = f"{phrases.label(name)} = {phrases.value(name, values[position], '.10g')}"
        if name in at and not same(float(at[name]), values[position]):
            asked = phrases.value(name, float(at[name]), ".10g")
            phrase += f" (the grid point nearest to the {asked} asked for)"
        elif name in lead.at:
            worst = f"the worst of {values.size} for" if name in met else "of"
            phrase += f" ({worst} the {lead.called})"
        elif name not in at and values.size > 1:
            phrase += f" (by default, one of {values.size} grid values)"
        chosen_at.append(phrase)
    return "At " + ", ".join(chosen_at) + "." if chosen_at else ""


def scalars(cube: "xr.Dataset", index: Mapping[str, int]) -> "dict[str, xr.DataArray]":
    """Return the chosen values as scalar coordinates."""
    return {name: cube[name].isel({name: position}) for name, position in index.items()}


def read(cube: "xr.Dataset", name: str, index: Mapping[str, Any], dims: tuple[str, ...]) -> np.ndarray:
    """Read a variable at `index`. `dims` names all remaining dimensions, in the order of the result."""
    return np.asarray(cube[name].isel(index).transpose(*dims).values)


def as_float(values: np.ndarray) -> np.ndarray:
    """Return values as float64. A negative count marks a missing value and becomes NaN."""
    if values.dtype.kind == "f":
        return values.astype(np.float64, copy=False)
    return np.where(values < 0, np.nan, values.astype(np.float64))


def coded(cube: "xr.Dataset", name: str) -> bool:
    """Whether a variable holds codes, such as response classes, which have no mean and no order."""
    return "flag_values" in cube[name].attrs


def count(status: np.ndarray) -> NDArray[np.int64]:
    """Count the points that were computed (every status except `NOT_COMPUTED`), that failed, and all points."""
    computed, failed = status != Status.NOT_COMPUTED, status > Status.MAX_CYCLES
    return np.array([computed.sum(), failed.sum(), status.size])


def completeness(counts: NDArray[np.int64]) -> dict[str, Any]:
    """Return the attributes for the completeness of a slice, from the result of `count` or a sum of such results."""
    computed, failed, points = map(int, counts)
    return {"complete": computed / points, "points": points, "points_failed": failed}
