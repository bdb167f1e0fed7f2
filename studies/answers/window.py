"""A part of a map, thinned to what a screen can show."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from damperlab.studies.answers.faults import QueryFault
from damperlab.studies.faults import Fault

FEWEST = 2
"""Values along an axis that stay in any case: its ends."""


def window(
    answer: xr.Dataset,
    ranges: Mapping[str, tuple[float, float] | None] | None = None,
    most: int | None = None,
) -> xr.Dataset:
    """Cut a part out of a map and keep evenly spaced grid lines of it.

    What stays are values of grid points as they were computed, not means over cells: a narrow feature between two
    lines that stay is not seen until the part is made smaller. The note says so.

    Parameters
    ----------
    answer : Dataset
        Of `resonance_map`, dimensions (y, x).
    ranges : mapping of (float, float) or None
        Lowest and highest value of either dimension.
    most : int, optional
        Most values along either dimension, 2 or more. The first and the last one of the part stay.

    Returns
    -------
    Dataset
        The part. Its note says what was left out; counts and completeness stay those of the whole map.

    Raises
    ------
    QueryFault
        Where no grid point is within a range.
    """
    sentences = []
    index: dict[str, NDArray[np.intp]] = {}
    for name in (str(dimension) for dimension in answer["status"].dims):
        inside = _inside(answer[name].values, name, (ranges or {}).get(name))
        kept = inside if most is None else _spread(inside, most)
        if kept.size < inside.size:
            sentences.append(f"{kept.size:,} of {inside.size:,} values of {name} are shown.")
        index[name] = kept
    part = answer.isel({name: kept for name, kept in index.items() if kept.size < answer.sizes[name]})
    if sentences:
        sentences.append("Ask for a smaller part to see what lies between.")
    note = " ".join([str(answer.attrs.get("note", "")), *sentences]).strip()
    return part.assign_attrs(note=note, thinned=bool(sentences))


def _inside(values: NDArray[np.float64], name: str, limits: tuple[float, float] | None) -> NDArray[np.intp]:
    if limits is None:
        return np.arange(values.size)
    low, high = limits
    inside = np.flatnonzero((values >= low) & (values <= high))
    if inside.size == 0:
        allowed = f"a range with some of the values from {values.min():.10g} to {values.max():.10g}"
        raise QueryFault(Fault(f"range of {name}", f"{low:.10g} to {high:.10g}", allowed, "widen it"))
    return inside


def _spread(places: NDArray[np.intp], most: int) -> NDArray[np.intp]:
    if places.size <= most:
        return places
    return places[np.round(np.linspace(0, places.size - 1, max(FEWEST, most))).astype(np.intp)]
