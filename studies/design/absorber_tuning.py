"""Tuning of an absorber for the smallest worst case over the bands, and over all structures within the tolerances."""

import math
from collections.abc import Callable
from functools import partial
from itertools import product

import numpy as np

from damperlab.studies.design.absorber_band import Absorbers, Floats, worst_of_each
from damperlab.studies.design.absorber_structure import built, hardest, judged_of, over_bands, structures
from damperlab.studies.specification.specification import Specification
from damperlab.studies.tmd.absorber import Absorber

BELOW, ABOVE, APART = 0.4, 0.5, 0.025
"""The search extends `BELOW` and `ABOVE` the tuning with the smallest peak over all frequencies, in steps of `APART`.
`BELOW`, `ABOVE` and `APART` are logarithms of frequency ratios.
"""
BESIDE_BAND, FARTHEST = 0.25, 2.3
"""The search also covers each band, and extends `BESIDE_BAND` beyond both ends of the band. A band may be far
from resonance, but the search extends at most `FARTHEST` from the tuning with the smallest peak.
`BESIDE_BAND` and `FARTHEST` are logarithms of frequency ratios.
"""
DAMPINGS = np.exp(np.linspace(-5.0, 1.0, 13))
"""Damping ratios of the search, relative to the damping ratio with the smallest peak over all frequencies."""
LOWS = 3
"""Number of the starts with the lowest values, which are refined further."""
WIDE = (0.05, 0.8)
"""Half-widths of the first grid around a start, in the logarithms of tuning and damping ratio."""
SIDE = np.linspace(-1.0, 1.0, 5)
CLOSER, ROUNDS, FEW = 0.7, 20, 6
"""The grid of `SIDE` × `SIDE` points around the best point is narrowed by the factor `CLOSER`, `ROUNDS`
times. A first search, around each of many starts, narrows the grid only `FEW` times.
"""
ALONG = np.linspace(-1.0, 1.0, 9)
ASIDE, NARROWER, HALVINGS, STRETCHES = 0.03, 0.3, 8, 5
"""The best tuning is followed along the values `ALONG` of the damping. For each damping, tunings are tried
whose logarithms differ by up to `ASIDE`, and this range of tunings is halved `HALVINGS` times. The best
tuning is followed `STRETCHES` times; each time, the ranges of damping and tuning are then multiplied by
`NARROWER`.
"""
EXCHANGES, ENOUGH = 6, 1.01
"""Largest number of exchanges, and ratio of worst case to expected worst case that requires an exchange.

An exchange adds the structure with the worst case to the structures for which the absorber is tuned.
"""


def tuned_for(asked: Specification, start: Absorber) -> Absorber:
    """Tune an absorber for the smallest worst case over the bands.

    The absorber is tuned for a set of structures. Then the structure with the worst case is added to the set, and the
    absorber is tuned again (method of exchange). The tuning ends when the set already contains this structure.
    """
    judged = judged_of(asked)
    # more damping hardly ever increases the motion of the structure
    known = [shares for shares in structures(asked) if shares.get("damping_ratio", 0.0) <= 0.0]

    def among(shares: list[dict[str, float]], tunings: Floats, dampings: Floats) -> Floats:
        many = Absorbers(start.mass_ratio, tunings, dampings)
        every = (over_bands(asked, built(asked, many, each), judged, worst_of_each) for each in shares)
        return np.asarray(np.max([value for each in every for value in each], axis=0))

    nominal, worst = partial(among, known[:1]), partial(among, known)

    def refined(tunings: Floats, dampings: Floats) -> tuple[float, Absorber]:
        values, *found = _least(worst, tunings, dampings)
        least = int(values.argmin())
        best = Absorber(start.mass_ratio, *(float(each[least]) for each in found))
        return _followed(worst, float(values[least]), best)

    tunings, dampings = _tunings(asked, start), start.damping_ratio * DAMPINGS
    heights = worst(*(side.ravel() for side in np.meshgrid(tunings, dampings, indexing="ij")))
    places = np.array(sorted(_lows(heights.reshape(tunings.size, dampings.size)))).T
    starts = np.append(start.tuning, tunings[places[0]]), np.append(start.damping_ratio, dampings[places[1]])
    # local minima are found on the nominal structure, and compared on all structures together
    values, *found = _least(nominal, *starts, FEW)
    lowest = np.argsort(values, kind="stable")[:LOWS]
    expected, absorber = refined(*(each[lowest] for each in found))
    tuned = []
    for _ in range(EXCHANGES):
        value, shares = hardest(asked, absorber, judged)
        tuned.append((value, absorber))
        if value <= ENOUGH * expected:
            break
        known.append(shares)
        expected, absorber = refined(np.array([absorber.tuning]), np.array([absorber.damping_ratio]))
    return min(tuned, key=lambda each: each[0])[1]


def _tunings(asked: Specification, start: Absorber) -> Floats:
    """Return the tunings to examine: around the tuning with the smallest peak, and around each band."""
    own = math.log(start.tuning)
    ends = [own - BELOW, own + ABOVE]
    for each in asked.excitations:
        ends += [math.log(each.low) - BESIDE_BAND, math.log(each.high) + BESIDE_BAND]
    low, high = np.clip([min(ends), max(ends)], own - FARTHEST, own + FARTHEST)
    return np.exp(np.linspace(low, high, math.ceil((high - low) / APART) + 1))


def _lows(heights: Floats) -> set[tuple[int, int]]:
    """Return the grid points of all local minima, and the lowest grid point for each damping.

    With little damping, a minimum is narrower than a step of the grid, and may lie between two grid points.
    """
    padded = np.pad(heights, 1, constant_values=math.inf)
    rows, columns = heights.shape
    about = [padded[i : i + rows, j : j + columns] for i, j in product(range(3), repeat=2)]
    places = np.argwhere(heights <= np.minimum.reduce(about)).tolist()
    return {(i, j) for i, j in places} | {(i, j) for j, i in enumerate(heights.argmin(axis=0).tolist())}


def _least(
    worst: Callable[[Floats, Floats], Floats], tunings: Floats, dampings: Floats, rounds: int = ROUNDS
) -> tuple[Floats, Floats, Floats]:
    """Refine each of n absorbers by ever finer grids of `SIDE` × `SIDE` points.

    Return the least value, the tuning and the damping ratio of each refined absorber, all of shape (n,).
    """
    (wide, high), (p, q) = WIDE, (side.ravel() for side in np.meshgrid(SIDE, SIDE, indexing="ij"))
    values = np.full(tunings.size, math.inf)
    for _ in range(rounds):
        tried = tunings[:, None] * np.exp(wide * p), dampings[:, None] * np.exp(high * q)
        heights = worst(*(side.ravel() for side in tried)).reshape(tunings.size, p.size)
        least = heights.argmin(axis=1)[:, None]
        values, tunings, dampings = (
            np.take_along_axis(each, least, axis=1)[:, 0] for each in (heights, *tried)
        )
        wide, high = CLOSER * wide, CLOSER * high
    return values, tunings, dampings


def _followed(
    worst: Callable[[Floats, Floats], Floats], value: float, best: Absorber
) -> tuple[float, Absorber]:
    """Refine an absorber along the best tuning for each damping.

    Where two peaks of the response are equal, the minimum is a narrow, curved valley, which grids miss.
    """
    along, aside, reached, there = WIDE[1], ASIDE, value, best
    for _ in range(STRETCHES):
        dampings = there.damping_ratio * np.exp(along * ALONG)
        tunings = np.full(dampings.size, there.tuning)
        width = aside
        for _ in range(HALVINGS):
            tried = tunings[:, None] * np.exp(width * SIDE)
            heights = worst(tried.ravel(), np.repeat(dampings, SIDE.size)).reshape(tried.shape)
            lowest = heights.argmin(axis=1)[:, None]
            tunings = np.take_along_axis(tried, lowest, axis=1)[:, 0]
            width /= 2
        bottom = np.take_along_axis(heights, lowest, axis=1)[:, 0]
        least = int(bottom.argmin())
        if bottom[least] < reached:
            reached = float(bottom[least])
            there = Absorber(best.mass_ratio, float(tunings[least]), float(dampings[least]))
        along, aside = along * NARROWER, aside * NARROWER
    return reached, there
