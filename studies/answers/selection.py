"""What every question shares: checking names, choosing grid points, reading, saying what was chosen."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from studies.answers.faults import QueryFault
from studies.faults import Fault, describe, listing, nearest
from studies.variables import DIMENSIONS, Status

COMPANIONS: tuple[str, ...] = ("amplitude_error", "response_class", "status")
"""What is given beside a metric, so that nobody has to take a value on trust."""


def check_dimension(field: str, name: str, taken: Iterable[str] = ()) -> None:
    """Raise `QueryFault` unless `name` is a dimension that no other argument has `taken`."""
    allowed = [dimension for dimension in DIMENSIONS if dimension not in taken]
    if name not in allowed:
        advice = "choose one that no other argument uses" if name in DIMENSIONS else _guess(name, allowed)
        raise QueryFault(Fault(field, describe(name), f"one of {listing(allowed)}", advice))


def check_metric(cube: xr.Dataset, name: str, field: str = "metric") -> None:
    """Raise `QueryFault` unless the cube holds the variable `name`."""
    if name not in cube.data_vars:
        stored = [str(variable) for variable in cube.data_vars]
        raise QueryFault(Fault(field, describe(name), f"one of {listing(stored)}", _guess(name, stored)))


def _guess(name: str, known: list[str]) -> str:
    meant = nearest(name, known)
    return f"did you mean {meant}" if meant else "see the study's definition for what it holds"


def choose(cube: xr.Dataset, at: Mapping[str, float], free: tuple[str, ...]) -> dict[str, int]:
    """Choose a grid point for every dimension that is not `free`.

    Parameters
    ----------
    cube : Dataset
        The cube.
    at : mapping of float
        Wanted values; the nearest grid point is taken. A dimension that is not named is taken at its first
        point, the frequency ratio at the point nearest resonance, r = 1.
    free : tuple of str
        Dimensions that stay.

    Returns
    -------
    dict of int
        Index by dimension.

    Raises
    ------
    QueryFault
        If `at` names what is no dimension or is free, or a value is no finite number.
    """
    for name, value in at.items():
        check_dimension(name, name, free)
        if not math.isfinite(value):
            raise QueryFault(Fault(name, describe(value), "a finite number", "name a value on the axis"))
    index = {}
    for dimension in DIMENSIONS:
        if dimension in free:
            continue
        values = cube[dimension].values
        unasked = 1.0 if dimension == "frequency_ratio" else values[0]
        wanted = at.get(dimension, unasked)
        index[dimension] = int(np.argmin(np.abs(values - wanted)))
    return index


def say(cube: xr.Dataset, index: Mapping[str, int], at: Mapping[str, float]) -> str:
    """Put into words which grid points were chosen, and where that is not what was asked for."""
    phrases = []
    for name, position in index.items():
        values = cube[name].values
        phrase = f"{name} = {values[position]:.10g}"
        if name in at and at[name] != values[position]:
            phrase += f" (the grid point nearest to the {at[name]:.10g} asked for)"
        elif name not in at and values.size > 1:
            phrase += f" (not asked for; one of {values.size} on the grid)"
        phrases.append(phrase)
    return "At " + ", ".join(phrases) + "." if phrases else ""


def scalars(cube: xr.Dataset, index: Mapping[str, int]) -> dict[str, xr.DataArray]:
    """Give the chosen values as coordinates without a dimension."""
    return {name: cube[name].isel({name: position}) for name, position in index.items()}


def read(cube: xr.Dataset, name: str, index: Mapping[str, Any], dims: tuple[str, ...]) -> np.ndarray:
    """Read a variable at `index` with its dimensions in the order `dims`, which must be all that are left."""
    return np.asarray(cube[name].isel(index).transpose(*dims).values)


def as_float(values: np.ndarray) -> np.ndarray:
    """Give values as float64 with NaN where a count is missing; counts are never negative."""
    if values.dtype.kind == "f":
        return values.astype(np.float64, copy=False)
    return np.where(values < 0, np.nan, values.astype(np.float64))


def coded(cube: xr.Dataset, name: str) -> bool:
    """Whether the values are codes, which have no mean and no order."""
    return "flag_values" in cube[name].attrs


def completeness(computed: int, failed: int, points: int) -> dict[str, Any]:
    """Give the attributes that say how much of a slice is there.

    Parameters
    ----------
    computed, failed, points : int
        Points with any status but `NOT_COMPUTED`; those with a status of 2 or above; all.
    """
    return {"complete": computed / points, "points": points, "points_failed": failed}


def count(status: np.ndarray) -> tuple[int, int]:
    """Count the points that were computed, and those that failed."""
    return int((status != Status.NOT_COMPUTED).sum()), int((status > Status.MAX_CYCLES).sum())
