"""Integration of many cycles in one kernel call, so that measured run times do not include the Python interpreter."""

import numpy as np

from damperlab.worker.jit import kernel
from damperlab.worker.solver.events import ARRIVED, BUDGET, IDLE, IMPACTS
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.observe.meter import METERS, PEAK, RELATIVE_PEAK, Meter
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.steady.response.energy import energy_residual, stored_energy
from damperlab.worker.steady.settle import at_rest

_SEGMENTS_PER_CYCLE = 20_000
_MOST_EVENTS = 5_000_000


@kernel
def march_from_rest(damping_ratio, frequency_ratio, friction, particle, cycles, meter):
    """Integrate a number of excitation cycles from rest.

    Parameters
    ----------
    damping_ratio, frequency_ratio, friction, particle
        Arguments as in `damperlab.worker.steady.settle.settle`.
    cycles : int
        Number of excitation cycles.
    meter : Meter or None
        Meter filled with zeros, which records energies and peaks; None if energies and peaks are not computed.

    Returns
    -------
    state : tuple of float
        u, u', p, p' at the end; p = p' = 0 without a particle.
    outcome : int
        Outcome as in `damperlab.worker.solver.integrate.half_cycle`.
    counts : int64 array, shape (COUNTS,)
        Number of events of each kind.
    measures : tuple of float
        Energy residual over all cycles, largest |u|, and mean over all cycles of the peak |u|; zeros without a meter.
    """
    energies = None
    if meter is not None:
        energies = meter.energies
    scene = make_scene(damping_ratio, frequency_ratio, friction, particle, energies, False)
    counts = scene.counts
    counts[BUDGET] = _SEGMENTS_PER_CYCLE * (cycles + 50)
    state = at_rest(frequency_ratio, friction, particle, False)
    stored = stored_energy(state, frequency_ratio, particle)
    outcome = ARRIVED
    largest = 0.0
    total = 0.0
    for half in range(2 * cycles):
        state, outcome = half_cycle(state, scene, meter, None)
        if outcome != ARRIVED:
            break
        if meter is not None:
            if half % 2 == 1:
                largest = max(largest, meter.sums[PEAK])
                total += meter.sums[PEAK]
                meter.sums[PEAK] = 0.0
                meter.sums[RELATIVE_PEAK] = 0.0
    residual = 0.0
    if meter is not None:
        residual = energy_residual(meter.sums, stored, stored_energy(state, frequency_ratio, particle))
    p = 0.0
    p_rate = 0.0
    if particle is not None:
        p = state.v - state.wall * (particle.clearance_ratio - state.gap)
        p_rate = state.p_rate
    end = (state.v, state.w + frequency_ratio, p, p_rate)
    return end, outcome, counts, (residual, largest, total / cycles)


@kernel
def march_halves(damping_ratio, frequency_ratio, friction, particle, state, silent, halves, forced=False):
    """Integrate `silent` half cycles from a state at phase 0, then record one half cycle for each row of `halves`.

    Parameters
    ----------
    damping_ratio, frequency_ratio, friction, particle, state
        Arguments as in `damperlab.worker.steady.settle.settle`.
    silent : int
        Number of half cycles before the recorded half cycles.
    halves : array, shape (half cycles, 3)
        Output array for the largest |u|, the largest |v| and the number of impacts of each recorded half cycle.
    forced : bool
        Whether a force on the structure replaces the shaken base.

    Returns
    -------
    state : State
        State at the end.
    outcome : int
        ARRIVED, or the reason why the integration ended early, such as too many events.
    """
    scene = make_scene(damping_ratio, frequency_ratio, friction, particle, None, forced)
    counts = scene.counts
    sums = np.zeros(METERS)
    meter = Meter(sums, None, None)
    counts[BUDGET] = _MOST_EVENTS
    outcome = ARRIVED
    for half in range(-silent, halves.shape[0]):
        sums[PEAK] = 0.0
        sums[RELATIVE_PEAK] = 0.0
        before = counts[IMPACTS]
        counts[IDLE] = 0
        state, outcome = half_cycle(state, scene, meter, None)
        if outcome != ARRIVED:
            break
        if half >= 0:
            halves[half, 0] = sums[PEAK]
            halves[half, 1] = sums[RELATIVE_PEAK]
            halves[half, 2] = counts[IMPACTS] - before
    return state, outcome
