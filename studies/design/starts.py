"""The damper as drawn from other starts than rest."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from damperlab.studies.design.book import Wanted
from damperlab.studies.design.build import Build
from damperlab.studies.design.builds import SEED
from damperlab.studies.design.score import Score, binding
from damperlab.studies.design.search import Search
from damperlab.studies.design.steps import Step
from damperlab.studies.specification.excitation import Excitation
from damperlab.studies.specification.specification import Specification

STARTS = 12
"""Starts of the damper as drawn, one of them rest."""


@dataclass(frozen=True)
class Starts:
    """What other starts than rest lead the damper as drawn to, under the largest amplitude of the excitation that binds.

    Parameters
    ----------
    count, frequencies : int
        Starts at each of so many frequencies.
    several : int
        Frequencies at which they lead to more than one response.
    worst : float
        The largest amplitude of any, in the unit of lengths.
    frequency_ratio : float
        Where that is.
    beyond : int
        Frequencies at which some start leads to more than the stated worst case is at most.
    """

    count: int
    frequencies: int
    several: int
    worst: float
    frequency_ratio: float
    beyond: int


def started(search: Search, build: Build, over: Score) -> Step[None]:
    """Compute the damper as drawn, whose worst case over the bands is given, from several starts."""
    largest = binding(search.asked, over).largest
    at = (*search.sample(build, largest, False), build.own(over.frequency_ratio))
    yield search.book.from_starts(Wanted(build, largest, tuple(sorted(set(at)))), STARTS, SEED)


def starts_of(
    asked: Specification, excitation: Excitation, cubes: list[xr.Dataset], bound: float
) -> Starts | None:
    """Sum up what starts lead to, where the displacement is what is measured."""
    if asked.measure.name != "worst_displacement" or not cubes:
        return None
    r = np.concatenate([cube["frequency_ratio"].values for cube in cubes])
    base_m = excitation.largest.base_m(r)
    worst_of = base_m * np.concatenate([cube["amplitude_ratio_worst"].values.ravel() for cube in cubes])
    if not np.isfinite(worst_of).any():
        return None
    place = int(np.nanargmax(worst_of))
    return Starts(
        count=STARTS,
        frequencies=worst_of.size,
        several=sum(int((cube["attractors"].values > 1).sum()) for cube in cubes),
        worst=float(worst_of[place]),
        frequency_ratio=float(r[place]),
        beyond=int((worst_of > bound).sum()),
    )
