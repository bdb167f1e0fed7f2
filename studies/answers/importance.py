"""Which parameter matters: the shares of a result's variance over the grid that each explains alone."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from damperlab.studies.answers.design_question import axes_within
from damperlab.studies.answers.phrases import Phrases, said
from damperlab.studies.answers.selection import (
    as_float,
    check_quantity,
    completeness,
    count,
    dimensions_of,
    main_metric,
)
from damperlab.studies.answers.slab import slabs_of
from damperlab.studies.faults import counted
from damperlab.studies.kinds import kind_of
from damperlab.studies.questions import Varied
from damperlab.studies.units import results_in_units
from damperlab.studies.variables import Status

ROUNDING = 1e-12
"""Relative spread of a result below which it is the same everywhere."""


def importance(cube: xr.Dataset, asked: Varied = Varied()) -> xr.Dataset:
    """Share out the variance of a result over the grid among the parameters.

    Every design of the grid counts the same, whatever the steps of its axes: a range in which the grid is finer weighs more.
    What is shared out is the largest value over the uncontrolled dimension, as in a map: over the frequencies, or the records.
    The first-order share of a parameter is the variance of the mean of the result at each of its values, over the variance of
    all [1]_: what would be known of the result if this parameter alone were known. What the shares leave of 1 belongs to
    combinations of parameters.

    Parameters
    ----------
    cube : Dataset
        A study's cube, read slab by slab.
    asked : Varied
        The result, and the part of the grid.

    Returns
    -------
    Dataset
        Dimension `dimension`: the parameters with more than one value, the largest share first. Variables: `share`;
        `effect`, the span of the mean of the result over the parameter's values, in its units; `number` of values.
        Attributes: `interactions` (1 less the sum of the shares), `mean` and `standard_deviation` of the result, `metric`,
        `over` (the uncontrolled dimension), `designs` and those `without` a value, `complete`, `points`, `points_failed`,
        `note`.

    Raises
    ------
    QueryFault
        If the metric is not in the cube or has codes, or nothing of the grid is in a range.

    References
    ----------
    .. [1] I. M. Sobol', Global sensitivity indices for nonlinear mathematical models, Math. Comput. Simul. 55 (2001) 271-280.
    """
    in_units = {each.name: each for each in results_in_units(cube)}
    metric = asked.metric or main_metric(cube)
    quantity = in_units.get(metric)
    source = metric if quantity is None else quantity.source
    check_quantity(cube, source, "which have no variance")
    axes = axes_within(cube, asked.ranges)
    over = kind_of(cube.sizes).uncontrolled
    names = tuple(name for name in dimensions_of(cube) if name != over)
    sums = _Sums(tuple(axes[name].size for name in names))
    for slab in slabs_of(cube, axes, names):
        places = [np.searchsorted(axes[name], slab.index[name]) for name in names]
        status, values = (slab.read(name).reshape(*slab.shape, -1) for name in ("status", source))
        sums.take(places, status, as_float(values))
    return _answer(cube, names, axes, sums, {"metric": metric, "over": over, "quantity": quantity})


class _Sums:
    """Number and sum of the values at each value of each parameter, all less the first one, so that no digit is lost."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.shape = shape
        self.number = [np.zeros(size, np.int64) for size in shape]
        self.sums = [np.zeros(size) for size in shape]
        self.first = math.nan
        self.squares = 0.0
        self.computed = self.failed = self.points = 0

    def take(self, slab: Sequence[np.ndarray], status: np.ndarray, values: np.ndarray) -> None:
        """Take in the designs of one slab; the last axis is reduced to its largest value."""
        computed, failed = count(status)
        self.computed, self.failed = self.computed + computed, self.failed + failed
        self.points += status.size
        good = ((status >= Status.CONVERGED) & (status <= Status.MAX_CYCLES)).all(axis=-1)
        largest = np.where(np.isnan(values), -np.inf, values).max(axis=-1)
        known = good & np.isfinite(largest)
        if not known.any():
            return
        if math.isnan(self.first):
            self.first = float(largest[known][0])
        moved = np.where(known, largest - self.first, 0.0)
        self.squares += float((moved**2).sum())
        for axis, part in enumerate(slab):
            others = tuple(other for other in range(len(slab)) if other != axis)
            self.number[axis][part] += known.sum(axis=others)
            self.sums[axis][part] += moved.sum(axis=others)


def _answer(
    cube: xr.Dataset,
    names: tuple[str, ...],
    axes: Mapping[str, np.ndarray],
    sums: _Sums,
    about: Mapping[str, Any],
) -> xr.Dataset:
    quantity = about["quantity"]
    designs, known = math.prod(sums.shape), int(sums.number[0].sum())
    mean = float(sums.sums[0].sum()) / known if known else math.nan
    variance = sums.squares / known - mean**2 if known else math.nan
    level = abs(mean + sums.first)
    flat = not variance > (ROUNDING * level) ** 2
    rows = []
    for axis, name in enumerate(names):
        if sums.shape[axis] == 1:
            continue
        there = sums.number[axis] > 0
        weights = sums.number[axis][there]
        means = sums.sums[axis][there] / weights
        between = float((weights * (means - mean) ** 2).sum()) / known if known else math.nan
        rows.append(
            (
                name,
                math.nan if flat else between / variance,
                float(np.ptp(means)) if known else math.nan,
                axes[name].size,
            )
        )
    rows.sort(key=lambda row: -row[1] if row[1] == row[1] else 0.0)
    factor = 1.0 if quantity is None else quantity.factor
    described = cube[quantity.source if quantity else about["metric"]].attrs
    units = quantity.units if quantity else described.get("units", "1")
    long_name = quantity.long_name if quantity else described.get("long_name", about["metric"])
    columns = {
        "share": (
            [row[1] for row in rows],
            "1",
            f"share of the variance of the {long_name} that the parameter explains alone",
        ),
        "effect": (
            [row[2] * factor for row in rows],
            units,
            f"span of the mean {long_name} over the parameter's values",
        ),
        "number": ([row[3] for row in rows], "1", "values of the parameter"),
    }
    answer = xr.Dataset(
        {
            name: ("dimension", np.array(array), {"units": unit, "long_name": text})
            for name, (array, unit, text) in columns.items()
        },
        {"dimension": np.array([row[0] for row in rows], dtype=str)},
    )
    rest = float(1 - answer["share"].values.sum())
    answer.attrs = {
        **completeness(sums.computed, sums.failed, sums.points),
        "metric": about["metric"],
        "over": about["over"],
        # what rounding leaves of one parameter's whole variance is no combination
        "interactions": (rest if abs(rest) > ROUNDING else 0.0) if rows and not flat else math.nan,
        "mean": (mean + sums.first) * factor,
        "standard_deviation": math.sqrt(max(variance, 0.0)) * factor if known else math.nan,
        "designs": designs,
        "without": designs - known,
    }
    answer.attrs |= said(cube, lambda phrases: {"note": _note(answer, long_name, flat, phrases)})
    return answer


def _note(answer: xr.Dataset, long_name: str, flat: bool, phrases: Phrases) -> str:
    found: dict[str, Any] = answer.attrs
    sentences = [f"Of {counted(found['designs'], 'design')}, each counted once."]
    if found["without"] == found["designs"]:
        sentences.append("None has a value yet.")
    elif flat:
        sentences.append(
            f"The {phrases.about(long_name)} is the same for all of them, so nothing matters here."
        )
    else:
        rows = zip(answer["dimension"].values, answer["share"].values, strict=True)
        shares = [f"{phrases.label(str(name))} {share:.0%}" for name, share in rows]
        sentences.append(
            f"Share of the variance of the {phrases.about(long_name)} that each parameter explains alone: {', '.join(shares)}; "
            f"combinations of parameters {found['interactions']:.0%}."
        )
    if 0 < found["without"] < found["designs"]:
        sentences.append(
            f"{found['without']} of them have no value at every point that counts and are left out; the shares of a grid with "
            "gaps overlap, so they need not add up."
        )
    return " ".join(sentences)
