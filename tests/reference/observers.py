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
        """Take the ends of the step and, where the rate changes sign, the extremum between."""
        self._take(0, lambda x: [a + b for a, b in zip(x[0], x[1], strict=True)], motion, start, end)
        self._take(1, lambda x: x[0], motion, start, end)

    def _take(
        self, which: int, values: Callable[[Sample], list[Real]], motion: Motion, start: Place, end: Place
    ) -> None:
        old, new = values(start[1]), values(end[1])
        peak = max(abs(old[0]), abs(new[0]))
        if old[1] * new[1] < 0:

            def slope(h: Real) -> tuple[Real, Real]:
                y = values(motion.at(h))
                return y[1], y[2]

            top = zero_between(slope, start[0], end[0], old[1] > 0, self._noise)
            peak = max(peak, abs(values(motion.at(top))[0]))
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
        """Take the ends of the step, its middle and, where the rate of u'' changes sign, the extremum between."""
        old, new = _acceleration(start[1]), _acceleration(end[1])
        middle = _acceleration(motion.at((start[0] + end[0]) / 2))[0]
        self.square += (end[0] - start[0]) * (old[0] ** 2 + 4 * middle**2 + new[0] ** 2) / 6
        self.peak = max(self.peak, abs(old[0]), abs(new[0]))
        if old[1] * new[1] < 0:

            def slope(h: Real) -> tuple[Real, Real]:
                a = _acceleration(motion.at(h))
                return a[1], a[2]

            top = zero_between(slope, start[0], end[0], old[1] > 0, self._noise)
            self.peak = max(self.peak, abs(_acceleration(motion.at(top))[0]))

    def end_cycle(self) -> None:
        """Nothing is kept per cycle."""


def _acceleration(sample: Sample) -> list[Real]:
    """u'' and its first two derivatives."""
    return [a + b for a, b in zip(sample[0][2:], sample[1][2:], strict=True)]
