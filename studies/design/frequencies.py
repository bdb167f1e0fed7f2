"""Frequencies of a response over the band, chosen so that its peak is found reliably.

A particle that rides on its wall is added mass: the structure then resonates at r = 1/√(1+β), and at r = 1 where the particle
does not act. Between the two, and a margin beyond, frequencies are spaced by the half width of the structure's own
resonance, ζ. So a resonance of that width reaches at least 1/√(1 + ¼) of its height at one of them (a Lorentzian,
half a step off its peak). Every maximum of that height is then bracketed.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.specification.excitation import Excitation
from damperlab.studies.specification.specification import OF_STRUCTURE, Specification

NARROWEST, WIDEST = 0.001, 0.008
"""Steps between resonances; a lighter damping than the first is not resolved by samples alone."""
MOST_STEPS = 60
"""Most samples between resonances."""
OUTSIDE = 8
"""Samples on either side of the resonances."""
COARSE = 3
"""Step of the first look, in these steps."""
SHOWN = 0.85
"""Share of the largest value from which a maximum is bracketed."""
BRACKETS = 3
"""Most maxima bracketed in one step."""
CLOSER = 0.001
"""Step of a response where a rise between two samples would decide."""
INNER = 7
"""Samples on either side of a bracket."""
NARROW = 1e-5
"""Width of an interval [1] that is not divided further: a hundredth of the smallest step between resonances."""
DIGITS = 9
"""Decimals of a frequency ratio: one place is one number, however it was computed."""


@dataclass(frozen=True)
class Survey:
    """The frequency ratios at which every design of a specification is sampled under one excitation.

    Parameters
    ----------
    low, high : float
        The band.
    step : float
        Between resonances.
    fine, coarse : tuple of float
        All of them, and those of the first look; both without the ends of the band.
    """

    low: float
    high: float
    step: float
    fine: tuple[float, ...]
    coarse: tuple[float, ...]

    @classmethod
    def of(cls, asked: Specification, excitation: Excitation) -> "Survey":
        """Lay out the survey for the heaviest particle of a specification, over the band of an excitation."""
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
        """Give the frequencies, over its own natural frequency, of a structure with a relative deviation.

        Both ends of the band are among them, and the resonance of a particle that rides on its wall.
        """
        low, high = self.low / (1.0 + shift), self.high / (1.0 + shift)
        riding = round(1.0 / math.sqrt(1.0 + mass_ratio), DIGITS)
        every = {*(self.fine if fine else self.coarse), riding}
        return tuple(sorted({low, high, *(r for r in every if low < r < high)}))


def _towards(edge: float, end: float) -> list[float]:
    """Steps that grow from the edge of the resonances to an end of the band; empty if the band ends before."""
    if (end - edge) * (edge - 1.0) <= 0.0:
        return []
    return [round(float(r), DIGITS) for r in np.geomspace(edge, max(end, 1e-4), OUTSIDE + 2)[1:-1]]


def brackets(r: NDArray[np.float64], values: NDArray[np.float64], shown: float = SHOWN) -> tuple[float, ...]:
    """Give further frequencies around the largest maxima of a sampled response.

    Parameters
    ----------
    r, values : ndarray, (n,)
        Ascending frequencies and the response there.
    shown : float
        Share of the largest value that a maximum must reach.

    Returns
    -------
    tuple of float
        Inside the neighbouring intervals of every maximum that reaches `shown` of the largest value, the highest
        first; empty if none of those intervals is wider than `NARROW`.
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
            if 0 <= other < r.size and abs(r[other] - r[place]) > NARROW:
                inner = np.linspace(r[place], r[other], INNER + 2)[1:-1]
                found |= {round(float(each), DIGITS) for each in inner}
    return tuple(sorted(found))


def between(r: NDArray[np.float64], values: NDArray[np.float64]) -> tuple[float, ...]:
    """Give further frequencies in the wider intervals where the response is near its largest value.

    A peak on a flank is no maximum of the samples if it is narrower than their distance, so `brackets` misses it.

    Parameters
    ----------
    r, values : ndarray, (n,)
        Ascending frequencies and the response there.

    Returns
    -------
    tuple of float
        They divide every interval with an end at `SHOWN` of the largest value or more, into parts no wider than
        `CLOSER`.
    """
    high = np.maximum(values[:-1], values[1:]) >= SHOWN * values.max()
    found: list[float] = []
    for first, last in zip(r[:-1][high], r[1:][high], strict=True):
        parts = math.ceil((last - first) / CLOSER)
        found.extend(round(float(each), DIGITS) for each in np.linspace(first, last, parts + 1)[1:-1])
    return tuple(found)


def rise(r: NDArray[np.float64], values: NDArray[np.float64]) -> float:
    """Estimate by how much the peak next to the largest sample exceeds it.

    On an interval next to it the response is assumed to rise no more steeply than towards the interval from either
    end. The rise ends where both lines meet. If the value beyond is too low for that, the response jumps: it is
    assumed to rise up to the jump, as steeply as before it.
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
    """Give the rise on the first interval of a response, whose neighbour was sampled from behind."""
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
        return min(up * float(width), -above)  # a jump falls by more than the response rose before it
    return up * float(width)
