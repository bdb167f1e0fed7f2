"""Plain marching, the slow way that needs no idea of a steady response: what the search for one is compared with.

By half cycles, with the kernels of an orbit and of a motion from rest, which are compiled anyway.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.accuracy.steady_answers import Point
from damperlab.worker.solver.events import ARRIVED, BUDGET, IDLE, IMPACTS
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.observe.meter import METERS, PEAK, Meter
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.solver.segment_log import empty_log
from damperlab.worker.solver.state import State


class Halves(NamedTuple):
    """Largest |u| and number of impacts of each half cycle, and the state after the last."""

    peaks: NDArray[np.float64]
    impacts: NDArray[np.int64]
    end: State

    @property
    def windows(self) -> NDArray[np.float64]:
        """Largest |u| of each cycle, of those too that begin in the middle of another."""
        return np.maximum(self.peaks[:-1], self.peaks[1:])


def metered(
    damping_ratio: float,
    frequency_ratio: float,
    friction: float | None,
    particle: Particle | None,
    state: State,
    halves: int,
    forced: bool = False,
    measured: bool = True,
) -> Halves:
    """March on by half cycles, with everything made anew that a march needs."""
    scene = make_scene(damping_ratio, frequency_ratio, friction, particle, True, forced)
    counts = scene.counts
    counts[BUDGET] = 100_000 * halves
    sums = np.zeros(METERS)
    meter = Meter(sums) if measured else None
    log = empty_log(1000)
    peaks, struck = np.zeros(halves), np.zeros(halves, np.int64)
    for half in range(halves):
        log.cursor[0] = counts[IDLE] = 0
        before, sums[PEAK] = counts[IMPACTS], 0.0
        state, outcome = half_cycle(state, scene, meter, log)
        assert outcome == ARRIVED
        peaks[half], struck[half] = sums[PEAK], counts[IMPACTS] - before
    return Halves(peaks, struck, state)


def marched(
    damping_ratio: float,
    frequency_ratio: float,
    friction: float | None,
    particle: Particle | None,
    state: State,
    halves: int,
    forced: bool = False,
) -> State:
    """March on by half cycles, and measure nothing."""
    return metered(damping_ratio, frequency_ratio, friction, particle, state, halves, forced, False).end


def plain_end(point: Point, state: State, cycles: int) -> State:
    """State some cycles later."""
    return marched(*point, state, 2 * cycles)


def plain_means(point: Point, period: int, cycles: int) -> NDArray[np.float64]:
    """Mean peak of each period, from rest on, in at most so many cycles; of cycles that begin at every half cycle."""
    count = 2 * period * (cycles // period)
    windows = metered(*point, point.rest(), count + 1).windows
    means: NDArray[np.float64] = windows.reshape(-1, 2 * period).mean(axis=1)
    return means
