"""What is measured along the way, beside the state: peaks and energy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from tests.reference.motion import Motion, Sample
from tests.reference.numbers import Numbers, Real
from tests.reference.roots import zero_between

Place = tuple[Real, Sample]  # h after the start of the motion, and the motion there


class Observer(Protocol):
    """Sees every scan step of a run, cut at events."""

    def observe(self, motion: Motion, start: Place, end: Place) -> None:
        """See one step of `motion`."""

    def end_cycle(self) -> None:
        """Learn that an excitation cycle is over."""


class PeakObserver:
    """True extrema of u and v in every cycle: ``cycles`` holds (max |u|, max |v|)."""

    def __init__(self, numbers: Numbers) -> None:
        self._noise = numbers.rounding
        self._zero = numbers.convert(0)
        self._now = [self._zero, self._zero]
        self.cycles: list[tuple[Real, Real]] = []

    def observe(self, motion: Motion, start: Place, end: Place) -> None:
        """Take the largest of the step."""
        for which, values in enumerate((_displacement, _relative_displacement)):
            peak = _largest(values, motion, start, end, self._noise)
            self._now[which] = max(self._now[which], peak)

    def end_cycle(self) -> None:
        """Keep the peaks of the cycle."""
        self.cycles.append((self._now[0], self._now[1]))
        self._now = [self._zero, self._zero]


class AccelerationObserver:
    """Largest |u''| of a run, ends and true extrema of every step; and ∫u''² by Simpson's rule on each."""

    def __init__(self, numbers: Numbers) -> None:
        self._noise = numbers.rounding
        self.peak = self.square = numbers.convert(0)

    def observe(self, motion: Motion, start: Place, end: Place) -> None:
        """Take the largest of the step; its ends and its middle for the integral."""
        old, new = _acceleration(start[1]), _acceleration(end[1])
        middle = _acceleration(motion.at((start[0] + end[0]) / 2))[0]
        self.square += (end[0] - start[0]) * (old[0] ** 2 + 4 * middle**2 + new[0] ** 2) / 6
        self.peak = max(self.peak, _largest(_acceleration, motion, start, end, self._noise))

    def end_cycle(self) -> None:
        """Nothing is kept per cycle."""


def _largest(
    values: Callable[[Sample], list[Real]], motion: Motion, start: Place, end: Place, noise: Real
) -> Real:
    """Largest magnitude at the ends of a step and, where the rate changes sign, at the extremum between."""
    old, new = values(start[1]), values(end[1])
    peak = max(abs(old[0]), abs(new[0]))
    if old[1] * new[1] < 0:

        def slope(h: Real) -> tuple[Real, Real]:
            y = values(motion.at(h))
            return y[1], y[2]

        top = zero_between(slope, start[0], end[0], old[1] > 0, noise)
        peak = max(peak, abs(values(motion.at(top))[0]))
    return peak


def _displacement(sample: Sample) -> list[Real]:
    """u and its derivatives."""
    return [a + b for a, b in zip(sample[0], sample[1], strict=True)]


def _relative_displacement(sample: Sample) -> list[Real]:
    """v and its derivatives."""
    return sample[0]


def _acceleration(sample: Sample) -> list[Real]:
    """u'' and its first two derivatives."""
    return _displacement(sample)[2:]
