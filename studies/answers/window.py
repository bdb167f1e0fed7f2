"""A part of a map, thinned to the resolution of a screen."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from damperlab.studies.answers.design_question import within
from damperlab.studies.answers.phrases import RATIOS

FEWEST = 2
"""Number of values along an axis that are always kept: the two ends."""


def window(
    answer: xr.Dataset,
    ranges: Mapping[str, tuple[float, float] | None] | None = None,
    most: int | None = None,
) -> xr.Dataset:
    """Extract a part of a map, and keep evenly spaced grid lines of this part.

    The kept values are values at grid points, not means. If `most` allows it, the grid lines through the
    largest and the smallest value are kept. Other narrow features between two kept lines are lost; the note
    warns of this.

    Parameters
    ----------
    answer : Dataset
        The answer of `resonance_map`, dimensions (y, x). Its first variable is the metric. In an answer of
        `map_difference`, the difference is used instead of the metric.
    ranges : mapping of (float, float) or None
        Lowest and highest value along each dimension.
    most : int, optional
        Largest number of values along each dimension, 2 or more. The first and the last value of the part are
        kept. If `most` is at least 3, the grid line through the largest value is kept too. If `most` is at
        least 4, the grid line through the smallest value is also kept.

    Returns
    -------
    Dataset
        The part of the map. The note says what was left out. Counts and completeness refer to the complete map.

    Raises
    ------
    QueryFault
        If no grid point is within a range.
    """
    sentences = []
    names = [str(dimension) for dimension in answer["status"].dims]
    index = {name: within(answer, f"range of {name}", name, (ranges or {}).get(name)) for name in names}
    extremes = _extremes(answer, index) if most is not None else []
    for axis, name in enumerate(names):
        whole = index[name]
        if most is not None and whole.size > most:
            index[name] = _spread(whole, most, [place[axis] for place in extremes])
            sentences.append(
                f"{index[name].size:,} of {whole.size:,} values of {RATIOS.label(name)} are shown."
            )
    part = answer.isel({name: kept for name, kept in index.items() if kept.size < answer.sizes[name]})
    if sentences:
        if extremes and most is not None and most >= FEWEST + len(extremes):
            sentences.append("The largest and the smallest value are among those shown.")
        sentences.append("Ask for a smaller part to see what lies between.")
    note = " ".join([str(answer.attrs.get("note", "")), *sentences]).strip()
    return part.assign_attrs(note=note, thinned=bool(sentences))


def _extremes(answer: xr.Dataset, index: Mapping[str, NDArray[np.intp]]) -> list[tuple[int, int]]:
    """Return the positions of the largest and the smallest value of the part; empty if the values are codes."""
    metric = answer["difference"] if "difference" in answer else next(iter(answer.data_vars.values()))
    if "flag_values" in metric.attrs or metric.dtype.kind not in "fiu":
        return []
    values = metric.isel(dict(index)).transpose(*index).values.astype(float)
    known = np.isfinite(values)
    if not known.any():
        return []
    ranked = (np.where(known, values, -np.inf).argmax(), np.where(known, values, np.inf).argmin())
    return [(int(row), int(column)) for row, column in (np.unravel_index(at, values.shape) for at in ranked)]


def _spread(places: NDArray[np.intp], most: int, wanted: list[int]) -> NDArray[np.intp]:
    """Return evenly spaced positions, both ends included.

    Each position in `wanted` replaces the nearest evenly spaced position. The two ends are never replaced.
    """
    kept = np.round(np.linspace(0, places.size - 1, max(FEWEST, most))).astype(np.intp)
    fixed = {0, kept.size - 1}
    for place in wanted:
        free = [at for at in range(kept.size) if at not in fixed]
        if place in kept:
            fixed.add(int(np.flatnonzero(kept == place)[0]))
        elif free:
            at = min(free, key=lambda at: abs(int(kept[at]) - place))
            kept[at] = place
            fixed.add(at)
    return places[np.unique(kept)]
