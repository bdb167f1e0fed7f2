"""Frequencies of a response over the band, chosen so that the peak of the response is found reliably.

A particle that stays on its wall is added mass, and the structure then resonates at r = 1/√(1+β). If the particle
exerts no force, the structure resonates at r = 1. Between 1/√(1+β) and 1, and within a margin on either side, samples
are spaced by the half width of the structure's own resonance, ζ. A resonance of this half width is a Lorentzian. Its
peak is at most half a step from a sample, so this sample reaches 1/√(1 + ¼) of the height of the peak. Every maximum
that reaches the share `SHOWN` of the largest sample is then bracketed.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.specification.excitation import Excitation
from damperlab.studies.specification.specification import OF_STRUCTURE, Specification

NARROWEST, WIDEST = 0.001, 0.008
"""Smallest and largest step between resonances. If the damping ratio is below the smallest step, samples alone do not
resolve the resonance.
"""
MOST_STEPS = 60
"""Largest number of samples between resonances."""
OUTSIDE = 8
"""Number of samples on either side of the resonances."""
COARSE = 3
"""Step of the coarse samples, which are computed first, as a multiple of the survey's step."""
SHOWN = 0.85
"""A maximum is bracketed if it reaches this share of the largest value."""
BRACKETS = 3
"""Largest number of maxima bracketed in one step."""
CLOSER = 0.001
"""Step near the largest value, where a rise between two samples could change the result."""
INNER = 7
"""Number of new samples in the interval on either side of a bracketed maximum."""
NARROW = 1e-5
"""Width of an interval that is not divided further: a hundredth of the smallest step between resonances."""
DIGITS = 9
"""Decimals to which a frequency ratio is rounded, so that equal frequencies are equal numbers after any computation."""


@dataclass(frozen=True)
class Survey:
    """The frequency ratios at which every design of a specification is sampled under one excitation.

    Parameters
    ----------
    low, high : float
        Ends of the band.
    step : float
        Step of the samples between the resonances.
    fine, coarse : tuple of float
        All sampled frequencies, and a selection of these for the first computation of a candidate. Neither tuple
        includes the ends of the band.
    """

    low: float
    high: float
    step: float
    fine: tuple[float, ...]
    coarse: tuple[float, ...]

    @classmethod
    def of(cls, asked: Specification, excitation: Excitation) -> "Survey":
        """Choose the frequencies for the band of an excitation and the heaviest particle that is allowed."""
        low, high = excitation.low, excitation.high
        mass = asked.choices["particle_mass_kg"].stop / asked.structure.mass_kg
        riding = 1.0 / math.sqrt(1.0 + mass)
        zeta = asked.structure.damping_ratio
        margin = 0.25 * (1.0 - riding) + 5.0 * min(zeta, 0.02) + 0.005
        first, last = riding - margin, 1.0 + margin
        step = max(min(max(zeta, NARROWEST), WIDEST), (last - first) / MOST_STEPS)
        # tolerances shift the band relative to the structure's own frequency
        off = {name: each.size for name, each in asked.tolerances.items() if name in OF_STRUCTURE}
        mass, frequency = off.get("mass_kg", 0.0), off.get("natural_frequency_hz", 0.0)
        lowest, highest = (
            asked.structure.built_off(-side * mass, side * frequency, 0.0)[0] for side in (-1, 1)
        )
        steps = range(math.ceil((first - 1.0) / step), math.floor((last - 1.0) / step) + 1)
        inner = {k: round(1.0 + k * step, DIGITS) for k in steps}
        outer = [
            *_towards(first, low / (1.0 + highest)),
            *_towards(last, high / (1.0 + lowest)),
        ]
        fine = sorted({*inner.values(), *outer})
        coarse = sorted({*(r for k, r in inner.items() if k % COARSE == 0), *outer[::2]})
        return cls(low, high, step, tuple(fine), tuple(coarse))

    def sample(self, mass_ratio: float, shift: float, fine: bool) -> tuple[float, ...]:
        """Return the sampled frequencies for a structure, relative to its own natural frequency.

        `shift` is the relative deviation of this natural frequency from nominal.

        The frequencies include both ends of the band, and the resonance with a particle that stays on its
        wall.
        """
        low, high = self.low / (1.0 + shift), self.high / (1.0 + shift)
        riding = round(1.0 / math.sqrt(1.0 + mass_ratio), DIGITS)
        every = {*(self.fine if fine else self.coarse), riding}
        return tuple(sorted({low, high, *(r for r in every if low < r < high)}))


def _towards(edge: float, end: float) -> list[float]:
    """Return frequencies from the `edge` of the range of resonances to an end of the band, in growing steps.

    The list is empty if the band ends within the range of resonances.
    """
    if (end - edge) * (edge - 1.0) <= 0.0:
        return []
    return [round(float(r), DIGITS) for r in np.geomspace(edge, max(end, 1e-4), OUTSIDE + 2)[1:-1]]


def brackets(r: NDArray[np.float64], values: NDArray[np.float64], shown: float = SHOWN) -> tuple[float, ...]:
    """Return further frequencies around the largest maxima of a sampled response.

    Parameters
    ----------
    r, values : ndarray, (n,)
        Ascending frequencies, and the response at each frequency.
    shown : float
        Share of the largest value that a maximum must reach.

    Returns
    -------
    tuple of float
        Ascending frequencies in the intervals next to the `BRACKETS` highest maxima that reach `shown` times the
        largest value. Empty if none of these intervals is wider than `NARROW`.
    """
    if r.size < 2:
        return ()
    padded = np.concatenate(([-np.inf], values, [-np.inf]))
    top = (padded[1:-1] >= padded[:-2]) & (padded[1:-1] >= padded[2:]) & (values >= shown * values.max())
    places = np.flatnonzero(top)
    places = places[np.argsort(-values[places], kind="stable")][:BRACKETS]
    found: set[float] = set()
    for place in places:
        for other in (place - 1, place + 1):
            if 0 <= other < r.size:
                found |= _inside(r[place], r[other])
    return tuple(sorted(found))


def _inside(one: float, other: float) -> set[float]:
    """Return `INNER` frequencies that divide the interval between two frequencies; none if the interval is at most
    `NARROW` wide.
    """
    if abs(other - one) <= NARROW:
        return set()
    return {round(float(each), DIGITS) for each in np.linspace(one, other, INNER + 2)[1:-1]}


def onsets(r: NDArray[np.float64], impacts: NDArray[np.float64]) -> tuple[float, ...]:
    """Return further frequencies in the intervals in which impacts set in or end.

    Where impacts set in or end, the response may jump. Between the two sides of the jump, a third response
    may occupy a narrow range of frequencies.

    Parameters
    ----------
    r, impacts : ndarray, (n,)
        Ascending frequencies, and the impacts per cycle at each frequency.

    Returns
    -------
    tuple of float
        Ascending frequencies; empty if impacts neither set in nor end in an interval wider than `NARROW`.
    """
    places = np.flatnonzero((impacts[:-1] > 0.0) != (impacts[1:] > 0.0))
    return tuple(sorted(each for k in places for each in _inside(r[k], r[k + 1])))


def between(r: NDArray[np.float64], values: NDArray[np.float64]) -> tuple[float, ...]:
    """Return further frequencies in the intervals wider than `CLOSER` where the response is near its largest value.

    A peak that is narrower than the spacing of the samples may lie on the flank of a higher peak. On the
    flank no sample is a maximum, so `brackets` misses the narrow peak.

    Parameters
    ----------
    r, values : ndarray, (n,)
        Ascending frequencies, and the response at each frequency.

    Returns
    -------
    tuple of float
        Frequencies that divide every high interval into parts no wider than `CLOSER`. An interval is high if the
        response at one of its ends is at least `SHOWN` times the largest value.
    """
    high = np.maximum(values[:-1], values[1:]) >= SHOWN * values.max()
    found: list[float] = []
    for first, last in zip(r[:-1][high], r[1:][high], strict=True):
        parts = math.ceil((last - first) / CLOSER)
        found.extend(round(float(each), DIGITS) for each in np.linspace(first, last, parts + 1)[1:-1])
    return tuple(found)


def rise(r: NDArray[np.float64], values: NDArray[np.float64]) -> float:
    """Estimate the difference between the largest sample and the peak next to this sample.

    On an interval next to the sample, the response is assumed to rise no more steeply than on the intervals before and
    after. The peak is where two lines meet: the line through the sample with the slope before the interval,
    and the line through the next sample with the slope after the interval. If the two lines meet outside the
    interval, the response jumps. Up to a jump, the response is assumed to rise as steeply as before the
    sample.
    """
    place = int(values.argmax())
    return max(
        _rise_ahead(r[place::side], values[place::side], r[place::-side], values[place::-side])
        for side in (1, -1)
    )


def _rise_ahead(
    r: NDArray[np.float64],
    values: NDArray[np.float64],
    back: NDArray[np.float64],
    behind: NDArray[np.float64],
) -> float:
    """Return the rise on the first interval of a response, from the slopes on both sides of this interval."""
    if r.size < 2 or back.size < 2 or not np.isfinite(np.r_[values[:3], behind[:3]]).all():
        return 0.0
    width, slopes = abs(r[1] - r[0]), np.diff(behind[:3]) / -np.abs(np.diff(back[:3]))
    # a much steeper slope than before is a jump
    up = float(np.minimum(slopes[0], 2.0 * abs(slopes[1])) if slopes.size > 1 else slopes[0])
    if r.size > 2:
        down = (values[1] - values[2]) / abs(r[2] - r[1])
        above = float(values[1] + down * width - values[0])
        if above >= 0.0:
            return up * above / (up + down) if up + down > 0.0 else 0.0
        return min(up * float(width), -above)  # at a jump, the response falls by more than it rose before
    return up * float(width)
