"""Find out how flat an optimum is along each parameter, and whether the optimum lies at the end of an axis."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.answers.design_question import DesignQuestion
from damperlab.studies.answers.judging import judge, new_tally
from damperlab.studies.answers.phrases import FREQUENCY, Phrases
from damperlab.studies.answers.slab import Slab

if TYPE_CHECKING:
    import xarray as xr

LOSS = 0.1
"""A design counts as equally good if its value exceeds that of the optimum by no more than this share."""


def flatness(
    cube: "xr.Dataset", question: DesignQuestion, design: dict[str, int], value: float
) -> list[dict[str, Any]]:
    """Find how far each parameter of a design can change before the judged result rises by more than `LOSS`.

    Parameters
    ----------
    cube, question : Dataset, DesignQuestion
        The cube, and the criteria by which designs are judged.
    design : dict of int
        Grid index of the design along each of its dimensions.
    value : float
        The judged result of the design.

    Returns
    -------
    list of dict
        One entry for each dimension with more than one value. `dimension` is the name of the dimension, and `value` is
        the value of the design along this dimension. `low` and `high` are the ends of a range of grid points around the
        design. From `low` to `high`, every result is known, and exceeds the result of the design by at most
        the share `LOSS`. `below` is the grid point below `low`, and `above` is the grid point above `high`;
        each is None at the end of the axis. The borders of the range lie between `below` and `low`, and
        between `high` and `above`; they are not interpolated. `resolved` says whether the neighbouring
        designs on both sides are known to be equally good. `worse` says whether a neighbour is known to be
        worse. If a neighbour is worse, the response changes by more than `LOSS` from one grid point to the
        next, and a much better design may lie between the two. `unknown` says whether a neighbour has no
        value because it was not computed, failed, or is left out.
    """
    found = []
    for name in question.design:
        if cube.sizes[name] == 1:
            continue
        axis = cube[name].values
        order = np.argsort(axis)
        index = {other: np.array([design[other]]) for other in question.design if other != name}
        index |= {name: np.arange(axis.size), FREQUENCY: question.axes[FREQUENCY]}
        line = judge(Slab(cube, question.design, (FREQUENCY,), index), question, new_tally())
        found_at = np.full(axis.size, np.nan)
        found_at[line[name]] = line["value"]
        along = found_at[order]
        good = along <= value * (1 + LOSS)
        here = low = high = int(np.flatnonzero(order == design[name])[0])
        while low > 0 and good[low - 1]:
            low -= 1
        while high < axis.size - 1 and good[high + 1]:
            high += 1
        ranked = axis[order]
        beside = [place for place in (here - 1, here + 1) if 0 <= place < axis.size]
        unknown = np.isnan(along[beside])
        found.append(
            {
                "dimension": name,
                "value": float(ranked[here]),
                "low": float(ranked[low]),
                "high": float(ranked[high]),
                "below": float(ranked[low - 1]) if low > 0 else None,
                "above": float(ranked[high + 1]) if high < axis.size - 1 else None,
                "resolved": bool(good[beside].all()),
                "worse": bool((~good[beside] & ~unknown).any()),
                "unknown": bool(unknown.any()),
            }
        )
    return found


def say_flatness(found: list[dict[str, Any]], phrases: Phrases) -> str:
    """Describe in words how flat an optimum is."""
    if not found:
        return ""
    spans = "; ".join(_span(entry, phrases) for entry in found)
    return f"Within {LOSS:.0%} of the best, one parameter at a time: {spans}."


def _span(entry: dict[str, Any], phrases: Phrases) -> str:
    name = entry["dimension"]
    low, high = phrases.value(name, entry["low"]), phrases.value(name, entry["high"])
    first = " (end of the axis)" if entry["below"] is None else ""
    last = " (end of the axis)" if entry["above"] is None else ""
    if entry["low"] == entry["high"]:
        return f"{phrases.label(name)} only at {low}{first or last}"
    return f"{phrases.label(name)} from {low}{first} to {high}{last}"


def end_of(axis: np.ndarray, value: float, name: str) -> str:
    """Return "upper" or "lower" if a value lies at an end of an axis that can be extended, otherwise an empty text."""
    if value == axis.max() and not (name == "restitution" and value == 1):
        return "upper"
    return "lower" if value == axis.min() and value > 0 else ""


def say_beyond(ends: Mapping[str, list[Any]], phrases: Phrases) -> str:
    """Say what to compute next if the best design lies at the end of an axis."""
    beyond = (
        f"{phrases.label(name)} {'above' if end == 'upper' else 'below'} {phrases.value(name, value, '.3g')}"
        for name, (end, value) in ends.items()
    )
    return f"{', '.join(beyond)}." if ends else ""


def ends_of_damper(
    cube: "xr.Dataset", metric: str, counting: Mapping[str, np.ndarray], best: Mapping[str, int]
) -> dict[str, list[Any]]:
    """Find at which ends of the study's axes the best damper lies.

    Parameters
    ----------
    cube : Dataset
        The study.
    metric : str
        The criterion of the ranking.
    counting : mapping of int arrays
        Grid indices of the judged cases, by dimension. Along a dimension that is not named, all indices were judged.
    best : mapping of int
        Grid index of the best damper along each of its dimensions.

    Returns
    -------
    dict of list
        By dimension: the end of the axis at which the best damper lies, "lower" or "upper", and the value at
        this end. An axis is left out if all dampers along the axis are at most a tenth worse than the best
        damper.
    """
    cases = {name: index for name, index in counting.items() if name not in best}
    ends: dict[str, list[Any]] = {}
    for name in best:
        axis = cube[name].values
        at = {other: place for other, place in best.items() if other != name}
        line = cube[metric].isel(cases | at).transpose(name, ...).values.reshape(axis.size, -1).astype(float)
        known = line[~np.isnan(line).any(axis=1)].max(axis=1)
        here = float(line[best[name]].max())
        value = float(axis[best[name]])
        end = end_of(axis, value, name)
        if end and axis.size > 1 and (known > here * (1 + LOSS)).any():
            ends[name] = [end, value]
    return ends
