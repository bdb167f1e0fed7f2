"""That the best lies at the end of an axis, so that a better one may lie beyond: of designs and of dampers alike."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from damperlab.studies.answers.flatness import LOSS
from damperlab.studies.answers.phrases import Phrases


def end_of(axis: np.ndarray, value: float, name: str) -> str:
    """Name the end of an axis at which a value lies; nothing where it lies at none, or nothing can lie beyond it."""
    if value == axis.max() and not (name == "restitution" and value == 1):
        return "upper"
    return "lower" if value == axis.min() and value > 0 else ""


def say_beyond(ends: Mapping[str, list[Any]], phrases: Phrases) -> str:
    """Say what to compute beyond the ends of axes at which the best lies; nothing where it lies at none."""
    beyond = (
        f"{phrases.label(name)} {'above' if end == 'upper' else 'below'} {phrases.value(name, value, '.3g')}"
        for name, (end, value) in ends.items()
    )
    return f"{', '.join(beyond)}." if ends else ""


def ends_of_damper(
    cube: xr.Dataset, metric: str, counting: Mapping[str, np.ndarray], best: Mapping[str, int]
) -> dict[str, list[Any]]:
    """Find at which ends of the study's axes the best damper lies.

    Parameters
    ----------
    cube : Dataset
        The study.
    metric : str
        What dampers were ranked by.
    counting : mapping of int arrays
        Grid indices of the cases that counted, by dimension; of a dimension that is not named all do.
    best : mapping of int
        Grid index of the best damper along each of its dimensions.

    Returns
    -------
    dict of list
        End and value, by dimension. An axis along which no damper is worse by more than a tenth is left out.
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
