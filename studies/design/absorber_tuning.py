"""Tuning an absorber for the smallest worst case over the bands, for all structures within the tolerances."""

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
"""Range of the search below and above the tuning for the smallest peak over all frequencies, and its step, as
logarithms.
"""
BESIDE_BAND, FARTHEST = 0.25, 2.3
"""Range of the search beyond each band, which may be far from resonance, and its largest distance from that tuning, as
logarithms.
"""
DAMPINGS = np.exp(np.linspace(-5.0, 1.0, 13))
"""Range of the damping, relative to that for the smallest peak over all frequencies."""
LOWS = 3
"""Number of lowest points that are refined."""
WIDE = (0.05, 0.8)
"""Range of tuning and damping around each of these points, as logarithms."""
SIDE = np.linspace(-1.0, 1.0, 5)
CLOSER, ROUNDS, FEW = 0.7, 20, 6
"""The best of a grid of `SIDE` × `SIDE` is refined by a finer grid, many times; before that, many points are refined a
few times.
"""
ALONG = np.linspace(-1.0, 1.0, 9)
ASIDE, NARROWER, HALVINGS, STRETCHES = 0.03, 0.3, 8, 5
"""The bottom of a valley is followed along `ALONG` values of the damping. The best tuning for each is searched up to
`ASIDE` away, as a logarithm, a range that is halved `HALVINGS` times. Both ranges are then narrowed, `STRETCHES` times.
"""
EXCHANGES, ENOUGH = 6, 1.01
"""Number of times that the hardest structure is added to those the absorber is tuned for. It is added if its value is
more than the second number times the expected worst case.
"""


def tuned_for(asked: Specification, start: Absorber) -> Absorber:
    """Tune an absorber for the smallest worst case over the bands.

    The absorber is tuned for some structures. Then the structure with the worst case is added to them and the
    absorber tuned again, until no structure is worse than those it is tuned for (method of exchange).
    """
    judged = judged_of(asked)
    # more damping of the structure hardly ever increases its motion
    known = [shares for shares in structures(asked) if shares.get("damping_ratio", 0.0) <= 0.0]

    def among(shares: list[dict[str, float]], tunings: Floats, dampings: Floats) -> Floats:
        many = Absorbers(start.mass_ratio, tunings, dampings)
        every = (over_bands(asked, built(asked, many, each), judged, worst_of_each) for each in shares)
        return np.asarray(np.max([value for each in every for value in each], axis=0))

    nominal, worst = partial(among, known[:1]), partial(among, known)

    tunings, dampings = _tunings(asked, start), start.damping_ratio * DAMPINGS
    heights = worst(*(side.ravel() for side in np.meshgrid(tunings, dampings, indexing="ij")))
    begin = _lows(heights.reshape(tunings.size, dampings.size))
    starts = [
        start,
        *(Absorber(start.mass_ratio, float(tunings[i]), float(dampings[j])) for i, j in sorted(begin)),
    ]
    # the nominal structure distinguishes valleys; all structures together give the depth of each
    lowest = sorted((_least(nominal, one, FEW) for one in starts), key=lambda found: found[0])[:LOWS]
    expected, absorber = _followed(
        worst, *min((_least(worst, one) for _, one in lowest), key=lambda found: found[0])
    )
    found = []
    for _ in range(EXCHANGES):
        value, shares = hardest(asked, absorber, judged)
        found.append((value, absorber))
        if value <= ENOUGH * expected:
            break
        known.append(shares)
        expected, absorber = _followed(worst, *_least(worst, absorber))
    return min(found, key=lambda each: each[0])[1]


def _tunings(asked: Specification, start: Absorber) -> Floats:
    """Tunings to examine: around that for the smallest peak, and around each band."""
    own = math.log(start.tuning)
    ends = [own - BELOW, own + ABOVE]
    for each in asked.excitations:
        ends += [math.log(each.low) - BESIDE_BAND, math.log(each.high) + BESIDE_BAND]
    low, high = np.clip([min(ends), max(ends)], own - FARTHEST, own + FARTHEST)
    return np.exp(np.linspace(low, high, math.ceil((high - low) / APART) + 1))


def _lows(heights: Floats) -> set[tuple[int, int]]:
    """Give the lowest tuning for each damping, and all local minima.

    With little damping the minima are narrower than the grid, so their values on the grid need not be low.
    """
    padded = np.pad(heights, 1, constant_values=math.inf)
    rows, columns = heights.shape
    about = [padded[i : i + rows, j : j + columns] for i, j in product(range(3), repeat=2)]
    places = np.argwhere(heights <= np.minimum.reduce(about)).tolist()
    return {(i, j) for i, j in places} | {(i, j) for j, i in enumerate(heights.argmin(axis=0).tolist())}


def _least(
    worst: Callable[[Floats, Floats], Floats], best: Absorber, rounds: int = ROUNDS
) -> tuple[float, Absorber]:
    """Refine the best tuning so far by ever finer grids of `SIDE` × `SIDE`."""
    width = np.array(WIDE)
    p, q = (side.ravel() for side in np.meshgrid(SIDE, SIDE, indexing="ij"))
    value = math.inf
    for _ in range(rounds):
        tunings, dampings = best.tuning * np.exp(width[0] * p), best.damping_ratio * np.exp(width[1] * q)
        values = worst(tunings, dampings)
        least = int(values.argmin())
        value = float(values[least])
        best = Absorber(best.mass_ratio, float(tunings[least]), float(dampings[least]))
        width = width * CLOSER
    return value, best


def _followed(
    worst: Callable[[Floats, Floats], Floats], value: float, best: Absorber
) -> tuple[float, Absorber]:
    """Follow the best tuning for each damping. Where two peaks are equal, the valley is narrow and curved, and grids
    miss its bottom.
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
