"""The coarse sub-grid of a large study: computed first, so that a map of the whole stands after seconds."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.axes import axis_values
from damperlab.studies.definition import MAX_NAME, Study
from damperlab.studies.kind import AnyStudy

COARSE_POINTS = 4096
"""Points of a sub-grid at most: ten seconds of two cores where a point takes 5 ms."""
SHARE = 20
"""A sub-grid has at most one of so many points of its study."""
FEWEST_POINTS = 64
"""A sub-grid of fewer points shows nothing."""
NAMED = ", coarse grid"


def coarse(study: AnyStudy) -> Study | None:
    """Thin every axis of a study, its ends kept.

    The values that are kept have the bits they have in the study, so what is computed of them is taken over by it.

    Parameters
    ----------
    study : AnyStudy
        The study.

    Returns
    -------
    Study or None
        None where the study is no steady response to a harmonic base, where a point depends on its neighbours, and where it
        is so small that its sub-grid would show nothing.
    """
    if not isinstance(study, Study) or study.settings() is None:
        return None
    document = study.document()
    entries = list(_entries(study, document))
    most = min(COARSE_POINTS, study.points // SHARE)
    counts = _counts([len(values) for _, _, values in entries], most)
    if not FEWEST_POINTS <= math.prod(counts) <= most:
        return None
    for (holder, name, values), count in zip(entries, counts, strict=True):
        holder[name] = values[np.linspace(0, len(values) - 1, count).round().astype(np.int64)].tolist()
    document["name"] = study.name[: MAX_NAME - len(NAMED)] + NAMED if study.name else NAMED.lstrip(", ")
    return Study.model_validate(document)


def _entries(
    study: Study, document: dict[str, Any]
) -> "list[tuple[dict[str, Any], str, NDArray[np.float64]]]":
    """Find what is varied: where the document says so, and its values."""
    axes = document.get("axes", {})
    given = [(axes, name, axis_values(getattr(study.axes, name))) for name in axes]
    if study.damping_ratio is not None:
        given.append((document, "damping_ratio", axis_values(study.damping_ratio)))
    if study.physical is not None:
        given += [(document["physical"], name, values) for name, values in study.physical.values().items()]
    return [entry for entry in given if len(entry[2]) > 1]


def _counts(lengths: list[int], most: int) -> list[int]:
    """Give how many values of each axis are kept: both ends of the short ones, the same share of each of the others."""
    counts = [2] * len(lengths)
    places = sorted(range(len(lengths)), key=lengths.__getitem__)
    for begin in range(len(places)):
        rest = places[begin:]
        share = (most / 2**begin / math.prod(lengths[place] for place in rest)) ** (1.0 / len(rest))
        if lengths[rest[0]] * share >= 2.0:
            for place in rest:
                counts[place] = int(lengths[place] * share)
            break
    return counts
