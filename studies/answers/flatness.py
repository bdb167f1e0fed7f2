"""How flat an optimum is along each parameter, and whether it lies at the end of an axis."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.answers.design_question import FREQUENCY, DesignQuestion
from damperlab.studies.answers.judging import judge, new_tally
from damperlab.studies.answers.phrases import RATIOS, Phrases
from damperlab.studies.answers.slab import Slab

if TYPE_CHECKING:
    import xarray as xr

LOSS = 0.1
"""A design counts as equally good if its value exceeds that of the optimum by no more than this share."""


def flatness(
    cube: "xr.Dataset", question: DesignQuestion, design: dict[str, int], value: float
) -> list[dict[str, Any]]:
    """Walk from a design along each of its parameters until `LOSS` is exceeded.

    Parameters
    ----------
    cube, question : Dataset, DesignQuestion
        The cube, and the judgement of designs.
    design : dict of int
        Grid index of each of the five design dimensions.
    value : float
        The judged result of the design.

    Returns
    -------
    list of dict
        One entry for each dimension with more than one value. It has `dimension` and `value`. `low` and `high` are the
        farthest grid points on either side up to which every value is known and at most `LOSS` larger. `below` and
        `above` are the next grid points beyond them, or None at the end of the axis. The border lies between `low` and
        `below`, and between `high` and `above`; there is no interpolation. `resolved`: whether the next designs on
        both sides are known to be as good. `worse`: whether one of them is not. The response then changes by more than
        `LOSS` from one grid point to the next, and a much better design may lie between them. `unknown`: whether one of
        them has no value because it was not computed, failed, or is left out.
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


def say_flatness(found: list[dict[str, Any]], phrases: Phrases = RATIOS) -> str:
    """Describe in words how flat an optimum is."""
    if not found:
        return ""
    spans = "; ".join(_span(entry, phrases) for entry in found)
    return f"Within {LOSS:.0%} of the best, one parameter at a time: {spans}."


def _span(entry: dict[str, Any], phrases: Phrases) -> str:
    """Name the values of one parameter over which a design stays as good."""
    name = entry["dimension"]
    low, high = phrases.value(name, entry["low"]), phrases.value(name, entry["high"])
    first = " (end of the axis)" if entry["below"] is None else ""
    last = " (end of the axis)" if entry["above"] is None else ""
    if entry["low"] == entry["high"]:
        return f"{phrases.label(name)} only at {low}{first or last}"
    return f"{phrases.label(name)} from {low}{first} to {high}{last}"


def end_of(axis: np.ndarray, value: float, name: str) -> str:
    """Name the end of an axis at which a value lies; empty if it lies at neither end, or if no values beyond that end
    are possible.
    """
    if value == axis.max() and not (name == "restitution" and value == 1):
        return "upper"
    return "lower" if value == axis.min() and value > 0 else ""


def say_beyond(ends: Mapping[str, list[Any]], phrases: Phrases) -> str:
    """Say what to compute beyond the ends of axes at which the best design lies; empty if it lies at no end."""
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
        Grid indices of the cases that were judged, by dimension; all indices if a dimension is not named.
    best : mapping of int
        Grid index of the best damper along each of its dimensions.

    Returns
    -------
    dict of list
        End and value, by dimension. An axis is left out if no damper along it is worse by more than a tenth.
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
