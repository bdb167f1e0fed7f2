"""Find the grid value that a typed number means, such as 0.7000000000000001 for 0.7."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damperlab.studies.answers.query_fault import refused

SAME = 1e-9
"""Relative difference up to which two values of a parameter are equal."""


def same(a: ArrayLike, b: ArrayLike) -> NDArray[np.bool_]:
    """Whether values are equal, up to a relative difference of `SAME`."""
    first, second = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    return np.asarray(np.abs(first - second) <= SAME * np.maximum(np.abs(first), np.abs(second)))


def nearest_place(values: ArrayLike, wanted: float) -> int:
    """Return the index of the grid value nearest to a number, or the first index if several values are equally near."""
    return int(np.abs(np.asarray(values, dtype=float) - wanted).argmin())


def inside(values: ArrayLike, low: float, high: float) -> NDArray[np.bool_]:
    """Whether values are within a range, both ends included, up to a relative difference of `SAME`."""
    at = np.asarray(values, dtype=float)
    return np.asarray(((at >= low) & (at <= high)) | same(at, low) | same(at, high))


FACTOR = 10.0
"""Largest factor by which a number may differ from the value of an axis that has a single value.

A number in a wrong unit, such as mm instead of m, differs by a larger factor.
"""
_SLIPS = {"_m": (("mm", 1e-3), ("µm", 1e-6), ("cm", 1e-2)), "_kg": (("g", 1e-3),), "_hz": (("kHz", 1e3),)}
"""Units that people use instead of SI units, with their factors."""


def within_reach(values: NDArray[np.float64], wanted: float) -> bool:
    """Whether a number is near enough to an axis to stand for a grid value.

    The number may lie beyond an end of the axis by at most the length of the axis. If the axis has one value, the
    number must lie within a factor `FACTOR` of this value.
    """
    low, high = float(np.min(values)), float(np.max(values))
    if low < high:
        return bool(inside(wanted, 2.0 * low - high, 2.0 * high - low))
    # if the only value is 0, as in a study without friction, every number is accepted
    return low <= 0.0 or bool(inside(wanted, low / FACTOR, low * FACTOR))


def check_reach(name: str, values: NDArray[np.float64], wanted: float) -> None:
    """Raise `QueryFault` for a value that is too far outside an axis; see `within_reach`.

    Parameters
    ----------
    name : str
        Name of the dimension in the question, such as `clearance_ratio` or `clearance_m`.
    values : ndarray, shape (n,)
        The values of the axis, in the unit of `name`.
    wanted : float
        The value in the question.
    """
    if within_reach(values, wanted):
        return
    low, high = float(np.min(values)), float(np.max(values))
    ends = f"{low:.6g}" if low == high else f"{low:.6g} to {high:.6g}"
    axis = f"the only value of the study, {ends}" if low == high else f"the study's axis from {ends}"
    told = f"{{field}} is {wanted:.10g}, far outside {axis}: the nearest grid point would answer another question."
    advice = "name a value within it" if low < high else "name that value, or leave it out"
    for suffix, slips in _SLIPS.items():
        for unit, factor in slips if name.endswith(suffix) else ():
            if inside(wanted * factor, low, high):
                advice = f"write {wanted * factor:.6g} if {wanted:.10g} {unit} is meant; else {advice}"
                break
    advice += ", or compute a study that includes the value asked for"
    raise refused(name, f"{wanted:.10g}", f"a value from {ends}", advice, told)
