"""That the best lies at the end of an axis, so that a better one may lie beyond: said alike of designs and of dampers."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from damperlab.studies.answers.flatness import LOSS
from damperlab.studies.answers.phrases import PRINTED_OF_SI, Phrases
from damperlab.studies.units import InUnits


def say_ends(ends: list[str]) -> str:
    """Say at which ends of its axes the best lies; nothing where it lies at none."""
    if not ends:
        return ""
    return f"The optimum lies at {' and '.join(ends)}: a better one may lie beyond, in a study with a longer axis."


def end_of(axis: np.ndarray, value: float, name: str, phrases: Phrases) -> str:
    """Name the end of an axis at which a value lies; nothing where it lies at none, or nothing can lie beyond it."""
    if value == axis.max() and not (name == "restitution" and value == 1):
        where = "upper"
    elif value == axis.min() and value > 0:
        where = "lower"
    else:
        return ""
    return f"the {where} end of {phrases.symbol(name)} ({phrases.value(name, value)})"


def ends_of_damper(
    cube: xr.Dataset, metric: str, counting: Mapping[str, np.ndarray], best: Mapping[str, int]
) -> str:
    """Say at which ends of the study's axes the best damper lies.

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
    str
        A sentence. An axis along which no damper is worse by more than a tenth is left out: its end means nothing.
    """
    phrases = Phrases({name: InUnits(name, name, 1.0, "", "") for name in PRINTED_OF_SI})
    cases = {name: index for name, index in counting.items() if name not in best}
    ends = []
    for name in best:
        axis = cube[name].values
        at = {other: place for other, place in best.items() if other != name}
        line = cube[metric].isel(cases | at).transpose(name, ...).values.reshape(axis.size, -1).astype(float)
        known = line[~np.isnan(line).any(axis=1)].max(axis=1)
        here = float(line[best[name]].max())
        if axis.size > 1 and (known > here * (1 + LOSS)).any():
            ends.append(end_of(axis, float(axis[best[name]]), name, phrases))
    return say_ends([end for end in ends if end])
