"""Steady response by the method of the paper: fixed time steps from rest until the sampled peaks have settled."""

from math import exp, inf, isfinite, nan, pi

import numpy as np

from damperlab.studies.variables import Status
from damperlab.worker.jit import kernel
from damperlab.worker.rk4 import Stepped, step_rk4
from damperlab.worker.solver.events import COUNTS, IMPACTS
from damperlab.worker.solver.particle import Particle
from damperlab.worker.steady.response.measures import Response, unmeasured
from damperlab.worker.steady.response.standard_errors import estimate, grows
from damperlab.worker.steady.response.trace import cycle_peaks
from damperlab.worker.steady.stopping_rules import Settings

_CONVERGED = int(Status.CONVERGED)
_MAX_CYCLES = int(Status.MAX_CYCLES)
_UNBOUNDED = int(Status.UNBOUNDED)
_CHUNK = 64  # Cycles between checks.
_BURN_IN = 0.2  # Fraction of max_cycles that is treated as transient if the peaks do not settle.
_FEWEST_STEPPED = 512  # Least number of cycles for which a standard error is used.


@kernel
def settle_stepped(
    damping_ratio: float,
    frequency_ratio: float,
    friction: float | None,
    particle: Particle | None,
    steps_per_cycle: int,
    settings: Settings,
) -> Response:
    """Compute the steady response of one design point by fixed time steps from rest.

    The arguments are those of `settle.settle`, with `steps_per_cycle` time steps per excitation cycle and instantaneous
    impacts. The response comes from sampled peaks; its energies, class, period and multiplier are unknown.

    Notes
    -----
    The run stops if the peaks of the last 64 cycles vary by less than `tolerance`, including their estimated
    future change. The future change is estimated as the remainder of a geometric series, since a free
    vibration of the structure decays as exp(−ζτ), and other transients decay faster. After a burn-in, the run
    also stops if the peaks show no trend and the standard error of their mean is below `tolerance`. The run
    ends at `max_cycles` at the latest. `amplitude_error` covers only the variation within the run, not the
    error of the integration method, which is of first order in the step.
    """
    halves = np.empty((2 * settings.max_cycles + 1, 2))
    peaks = np.empty((2, settings.max_cycles))
    # fraction of a free vibration that remains after `_CHUNK` cycles
    left = exp(-2.0 * pi * _CHUNK * damping_ratio / frequency_ratio)
    counts = np.zeros(COUNTS, np.int64)
    state = Stepped(0.0, -frequency_ratio, 0.0, 0.0)
    cycles = 0
    burn_in = int(_BURN_IN * settings.max_cycles)
    impacts_before = 0  # impacts in the transient
    status = _MAX_CYCLES
    first = 0  # first cycle of the measurement; `begin` is the first cycle of the mean
    begin = 0
    error = nan
    while cycles < settings.max_cycles:
        last = min(cycles + _CHUNK, settings.max_cycles)
        impacts_of_run = counts[IMPACTS]
        state = step_rk4(
            state,
            damping_ratio,
            frequency_ratio,
            friction,
            particle,
            steps_per_cycle,
            cycles,
            last,
            counts,
            halves,
        )
        chunk = cycles
        cycles = last
        if not isfinite(halves[2 * cycles, 0]):
            return unmeasured(_UNBOUNDED, cycles)
        cycle_peaks(halves, 2 * cycles, peaks)
        highest = peaks[0, chunk:cycles].max()
        differ = highest - peaks[0, chunk:cycles].min()
        within = differ / (1.0 - left) if left < 1.0 else inf
        if chunk > 0 and cycles - chunk == _CHUNK and within <= settings.tolerance * highest:
            first = begin = chunk
            impacts_before = impacts_of_run
            error = within
            status = _CONVERGED
            break
        if chunk < burn_in <= cycles:
            first = cycles
            impacts_before = counts[IMPACTS]
        if first > 0 and cycles - first >= _FEWEST_STEPPED:
            known = estimate(peaks[0], first, cycles)
            begin, error = known.first, known.error
            if known.stationary and error <= settings.tolerance * known.mean:
                status = _CONVERGED
                break
    if status == _MAX_CYCLES and cycles - first < _CHUNK:  # too few cycles remain after the burn-in
        first = 0
        impacts_before = 0
    if status == _MAX_CYCLES:
        if grows(peaks[0], first, cycles):
            return unmeasured(_UNBOUNDED, cycles)
        known = estimate(peaks[0], first, cycles)
        begin, error = known.first, known.error
    return unmeasured(status, cycles)._replace(
        amplitude_ratio=peaks[0, begin:cycles].mean(),
        amplitude_ratio_max=halves[2 * first + 1 : 2 * cycles + 1, 0].max(),
        relative_amplitude_ratio=peaks[1, begin:cycles].mean(),
        amplitude_error=error,
        impacts_per_cycle=(counts[IMPACTS] - impacts_before) / (cycles - first),
    )
