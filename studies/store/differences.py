"""Point-by-point comparison of two versions of a study, which different solvers computed."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from typing_extensions import TypeAliasType

from damperlab.studies.kinds import kind_of
from damperlab.studies.shapes import Like
from damperlab.studies.store.export.slabs import slabs
from damperlab.studies.store.faults import NothingToDo
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.studies.variables import Status

if TYPE_CHECKING:
    import xarray as xr

NOT_RESULTS = ("run_time",)
"""Variables that are not compared, because they are measured and therefore never reproducible."""


@dataclass
class Difference:
    """Difference of one variable between two versions of a study.

    Parameters
    ----------
    variable : str
        Name of the variable.
    points : int
        Number of points at which the two values differ in any bit; NaN equals NaN.
    largest_relative : float, optional
        Largest \\|a − b\\| / max(\\|a\\|, \\|b\\|) over the points at which both values are finite. None for integer
        codes, and if no finite values differ.
    at : dict, optional
        Coordinates of the largest difference; for integer codes, coordinates of the first difference.
    older, newer : float, optional
        Values of the two versions at the coordinates `at`; None if a value is not finite.
    """

    variable: str
    points: int = 0
    largest_relative: float | None = None
    at: dict[str, Any] | None = None
    older: float | None = None
    newer: float | None = None


@dataclass
class Differences:
    """Differences between two versions of a study.

    Parameters
    ----------
    older, newer : str
        Ids of the two versions.
    points : int
        Number of points of the grid.
    compared : int
        Number of points computed in both versions.
    only_older, only_newer : int
        Number of points computed in only one of the two versions.
    differing : int
        Number of points at which any variable differs; run times are not compared.
    variables : list of Difference
        Variables that both versions store.
    """

    older: str
    newer: str
    points: int
    compared: int = 0
    only_older: int = 0
    only_newer: int = 0
    differing: int = 0
    variables: list[Difference] = field(default_factory=list)

    def document(self) -> dict[str, Any]:
        """Return the differences as JSON-able values."""
        return asdict(self)


DifferencesDocument = TypeAliasType("DifferencesDocument", Annotated[dict[str, Any], Like(Differences)])


def differences_of(store: Store, newer: Record, older: Record | None = None) -> Differences:
    """Compare two versions of a study, piece by piece. The cubes need not fit into memory.

    By default, `older` is the newest version before `newer` that has results.

    Raises
    ------
    NothingToDo
        If there is no earlier version, or `older` belongs to another study.
    BlockDamaged, StoreFault
        If one of the two versions cannot be read.
    """
    if older is None:
        before = [
            each for each in store.versions(newer.id) if each.version < newer.version and each.blocks_done
        ]
        if not before:
            told = f"Study {newer.id} has no older version with results to compare with."
            raise _no_other(f"{newer.id}, which has no older version with results", told)
        older = before[-1]
    if older.digest != newer.digest:
        told = f"{newer.id} and {older.id} are different studies, not two versions of one."
        raise _no_other(f"{newer.id} and {older.id}, which are two studies", told)
    cubes = store.cube(older.id), store.cube(newer.id)
    known = kind_of(cubes[1].sizes).variables
    names = [name for name in known if all(name in cube for cube in cubes) and name not in NOT_RESULTS]
    found = Differences(
        older.id, newer.id, newer.points_total, variables=[Difference(name) for name in names]
    )
    for piece in slabs(newer.shape, newer.chunk):
        place = dict(zip(cubes[1]["status"].dims, piece, strict=True))
        _compare(found, *(cube.isel(place) for cube in cubes))
    return found


def _compare(found: Differences, older: "xr.Dataset", newer: "xr.Dataset") -> None:
    there, here = (cube["status"].values != Status.NOT_COMPUTED for cube in (older, newer))
    both = there & here
    found.compared += int(np.count_nonzero(both))
    found.only_older += int(np.count_nonzero(there & ~here))
    found.only_newer += int(np.count_nonzero(here & ~there))
    differing = np.zeros(both.shape, bool)
    for difference in found.variables:
        one, other = older[difference.variable], newer[difference.variable]
        a, b = one.values, other.values
        unlike = both & (a != b)
        if a.dtype.kind == "f":
            unlike &= ~(np.isnan(a) & np.isnan(b))
        differing |= unlike
        if unlike.any():
            difference.points += int(np.count_nonzero(unlike))
            _note(difference, unlike, one, other)
    found.differing += int(np.count_nonzero(differing))


def _note(difference: Difference, unlike: np.ndarray, one: "xr.DataArray", other: "xr.DataArray") -> None:
    a, b = one.values, other.values
    largest = None
    place = int(np.argmax(unlike))
    if a.dtype.kind == "f":
        finite = unlike & np.isfinite(a) & np.isfinite(b)
        with np.errstate(all="ignore"):
            relative = np.where(finite, np.abs(a - b) / np.maximum(np.abs(a), np.abs(b)), -1.0)
        if finite.any():
            place = int(np.argmax(relative))
            largest = float(relative.flat[place])
    known = difference.largest_relative
    if difference.at is not None and (largest is None or (known is not None and known >= largest)):
        return
    index = np.unravel_index(place, a.shape)
    at = {str(name): one[name].values[i].item() for name, i in zip(one.dims, index, strict=True)}
    difference.at, difference.largest_relative = at, largest
    difference.older, difference.newer = (_number(values[index]) for values in (a, b))


def _number(value: np.generic) -> float | None:
    number = float(value)
    return number if np.isfinite(number) else None


def _no_other(found: str, told: str) -> NothingToDo:
    advice = "make another version with `damperlab recompute`"
    return NothingToDo("study", found, "two versions of one study", advice, told)


def words(found: Differences) -> Iterable[str]:
    """Yield sentences on the numbers of compared and differing points."""
    yield (
        f"{found.newer} and {found.older}: {found.compared} of {found.points} points are computed in both, "
        f"{found.differing} of them differ."
    )
    if found.only_older or found.only_newer:
        yield f"{found.only_older} points are in {found.older} alone, {found.only_newer} in {found.newer} alone."
