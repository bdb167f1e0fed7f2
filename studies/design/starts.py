"""Responses of the nominal damper after several initial states, and the share of starts that lead to each response."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from damperlab.studies.design.book import Book, Wanted
from damperlab.studies.design.build import Build
from damperlab.studies.design.curve import Curve
from damperlab.studies.design.score import Score, binding
from damperlab.studies.design.search import Search
from damperlab.studies.design.steps import Step
from damperlab.studies.shapes import Count, Measured
from damperlab.studies.specification.excitation import Amplitude
from damperlab.studies.specification.specification import STARTS, Specification
from damperlab.studies.variables import ResponseClass

if TYPE_CHECKING:
    import xarray as xr

FROM = {
    "rest": " from rest",
    "worst": f" from the worst of {STARTS} starts",
    "likely": f" in the responses that most of {STARTS} starts lead to",
}
"""Phrases for the initial states of the judged responses."""
BY_RANK = (
    ("attractor_share", "amplitude_ratio"),
    ("attractor_share_second", "amplitude_ratio_second"),
    ("attractor_share_third", "amplitude_ratio_third"),
)
"""Variables of share and amplitude for each distinct response, the most frequent response first."""
SAME = 1e-6
"""Relative difference within which two amplitudes belong to the same response. The response from rest is always one of
the responses, because the first start is at rest.
"""


@dataclass(frozen=True)
class Reached:
    """One of several responses at a frequency.

    Parameters
    ----------
    displacement : float
        Displacement of the structure, in the unit of lengths.
    value : float or None
        Value of the measure in its unit; None if the value is not stored for this response.
    share : float
        Share of all starts that lead to this response.
    response_class : str or None
        Class of the response in words, for the most frequent response and the response from rest, otherwise None.
    from_rest : bool
        Whether the start at rest leads to this response.
    """

    displacement: Measured
    value: float | None
    share: Measured
    response_class: str | None
    from_rest: bool


@dataclass(frozen=True)
class Several:
    """A frequency at which different starts lead to different responses.

    Parameters
    ----------
    frequency_ratio : float
        The frequency, relative to the natural frequency.
    frequency_hz : float or None
        The frequency in hertz; None without units.
    attractors : int
        Number of different responses.
    highest : float
        The largest displacement of all responses, in the unit of lengths.
    responses : tuple of Reached
        Up to three of the responses, the most frequent first.
    share_left : float
        Share of all starts that lead to further responses, or that failed.
    """

    frequency_ratio: Measured
    frequency_hz: float | None
    attractors: Count
    highest: Measured
    responses: tuple[Reached, ...]
    share_left: Measured


@dataclass(frozen=True)
class Starts:
    """Responses of the nominal damper after several starts, under the largest amplitude of the binding excitation.

    Parameters
    ----------
    count, frequencies : int
        Number of starts at each frequency, and number of frequencies.
    several : int
        Number of frequencies at which the starts lead to different responses.
    worst : float
        The largest displacement of all responses, in the unit of lengths.
    frequency_ratio : float
        Frequency of the largest displacement, relative to the natural frequency.
    frequency_hz : float or None
        This frequency in hertz; None without units.
    beyond : int or None
        Number of frequencies at which a start leads to more than the upper bound of the stated worst case. None if the
        measure is not the displacement, because other results are not stored for every start.
    where : tuple of Several
        The frequencies that `several` counts, ascending.
    """

    count: Count
    frequencies: Count
    several: Count
    worst: Measured
    frequency_ratio: Measured
    frequency_hz: float | None
    beyond: int | None
    where: tuple[Several, ...]


def started(search: Search, build: Build, over: Score) -> Step[None]:
    """Compute the nominal damper from several starts; `over` is the damper's worst case over the bands."""
    largest = binding(search.asked, over).largest
    at = (*search.sample(build, largest, False), build.own(over.frequency_ratio))
    yield search.book.from_starts(Wanted(build, largest, tuple(sorted(set(at)))))


def starts_of(
    asked: Specification, book: Book, build: Build, largest: Amplitude, bound: float
) -> Starts | None:
    """Summarise the responses to several starts.

    Parameters
    ----------
    asked, book, build : Specification, Book, Build
        The specification, all known results, and the damper.
    largest : Amplitude
        The amplitude under which the starts are computed.
    bound : float
        Upper bound of the stated worst case, in the unit of the measure.
    """
    cubes = book.from_many_starts
    if not cubes:
        return None
    r = np.concatenate([cube["frequency_ratio"].values for cube in cubes])
    worst_of = largest.base_m(r) * np.concatenate(
        [cube["amplitude_ratio_worst"].values.ravel() for cube in cubes]
    )
    if not np.isfinite(worst_of).any():
        return None
    place = int(np.nanargmax(worst_of))
    rest = book.curve(build, largest)
    where = sorted(
        (each for cube in cubes for each in _several(asked, cube, largest, rest)),
        key=lambda each: each.frequency_ratio,
    )
    displacement = asked.measured(largest).of_displacement
    return Starts(
        count=STARTS,
        frequencies=worst_of.size,
        several=len(where),
        worst=float(worst_of[place]),
        frequency_ratio=float(r[place]),
        frequency_hz=hertz(asked, float(r[place])),
        beyond=int((worst_of > bound).sum()) if displacement else None,
        where=tuple(where),
    )


def hertz(asked: Specification, ratio: float) -> float | None:
    """Return a frequency in hertz; None without units."""
    return ratio * asked.structure.natural_frequency_hz if asked.in_units else None


def _several(asked: Specification, cube: "xr.Dataset", largest: Amplitude, rest: Curve) -> Iterator[Several]:
    """Yield the frequencies at which the starts of a study lead to different responses."""
    every = cube.squeeze([name for name in cube.sizes if name != "frequency_ratio"], drop=True)
    for r in every["frequency_ratio"].values.tolist():
        at = every.sel(frequency_ratio=r)
        if int(at["attractors"]) < 2:
            continue
        base_m = float(largest.base_m(r))
        known = _from_rest(rest, r) if asked.judge == "rest" else {}
        measure = asked.measured(largest)
        unit = measure.factor * base_m * rest.rate**measure.order
        found = tuple(_reached(measure.variable, unit, at, base_m, known))
        yield Several(
            frequency_ratio=r,
            frequency_hz=hertz(asked, r),
            attractors=int(at["attractors"]),
            highest=base_m * float(at["amplitude_ratio_worst"]),
            responses=found,
            share_left=max(0.0, round(1.0 - sum(each.share for each in found), 9)),
        )


def _from_rest(rest: Curve, r: float) -> dict[str, float]:
    """Return the response from rest at a frequency; empty if the response is unknown."""
    place = np.flatnonzero(np.abs(rest.r - r) <= 1e-12)
    return {name: float(column[place[0]]) for name, column in rest.columns.items()} if place.size else {}


def _reached(
    variable: str, unit: float, at: "xr.Dataset", base_m: float, rest: dict[str, float]
) -> Iterator[Reached]:
    """Yield the responses at one frequency, the most frequent response first.

    All variables are stored for the most frequent response. For the response from rest, the search has
    computed all variables; this response is recognised by its amplitude. For all other responses, only
    amplitude and share are known. `unit` converts `variable` into the unit of the measure.
    """
    for rank, (share, amplitude) in enumerate(BY_RANK):
        if not float(at[share]) > 0.0:
            return
        ratio = float(at[amplitude])
        from_rest = bool(rest) and abs(rest["amplitude_ratio"] - ratio) <= SAME * max(ratio, 1.0)
        known: dict[str, float] = rest if from_rest else {}
        if rank == 0:
            known = {name: float(at[name]) for name in (variable, "response_class")}
        value = known.get(variable, ratio if variable == "amplitude_ratio" else None)
        kind = known.get("response_class")
        yield Reached(
            displacement=base_m * ratio,
            value=None if value is None else unit * value,
            share=float(at[share]),
            response_class=None if kind is None else ResponseClass(int(kind)).name.lower(),
            from_rest=from_rest,
        )
