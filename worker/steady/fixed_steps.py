"""Steady response by the paper's own method: step from rest until the sampled peaks have settled."""

from math import isfinite, nan

import numpy as np

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.jit import kernel
from damperlab.worker.rk4 import Stepped, step_rk4
from damperlab.worker.solver.events import COUNTS, IMPACTS
from damperlab.worker.steady.response.measures import Response, failed
from damperlab.worker.steady.response.standard_errors import grows, mean_and_error

_CONVERGED = int(Status.CONVERGED)
_MAX_CYCLES = int(Status.MAX_CYCLES)
_UNBOUNDED = int(Status.UNBOUNDED)
_UNKNOWN = int(ResponseClass.UNKNOWN)
_CHUNK = 64  # cycles between looks
_BURN_IN = 0.2  # share of max_cycles taken as transient where the peaks do not come to rest
_FEWEST_STEPPED = 512  # cycles before a standard error is believed


@kernel
def settle_stepped(damping_ratio, frequency_ratio, friction, particle, steps_per_cycle, settings):
    """Steady response of one design point by fixed steps from rest.

    Parameters
    ----------
    damping_ratio, frequency_ratio : float
        ζ and r.
    friction : float or None
        γ_F.
    particle : Particle or None
        The particle; its contacts take no time.
    steps_per_cycle : int
        Steps per excitation cycle.
    settings : Settings
        When to stop.

    Returns
    -------
    Response
        With what sampled peaks tell; energies, class, period and multiplier are not known.

    Notes
    -----
    The run stops when the peaks of the last 64 cycles agree to `tolerance`; or, beyond a burn-in, when the batch-means
    error of their mean is below it; or at `max_cycles`. `amplitude_error` speaks of the run alone: the error of the
    method itself, of first order in the step, comes on top and is not known to it.
    """
    peaks = np.empty((settings.max_cycles, 2))
    counts = np.zeros(COUNTS, np.int64)
    state = Stepped(0.0, -frequency_ratio, 0.0, 0.0)
    cycles = 0
    burn_in = int(_BURN_IN * settings.max_cycles)
    impacts_before = 0  # those of the transient
    status = _MAX_CYCLES
    first = 0
    mean = nan
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
            peaks,
        )
        chunk = cycles
        cycles = last
        if not isfinite(peaks[cycles - 1, 0]):
            return failed(_UNBOUNDED, cycles)
        lowest = peaks[chunk:cycles, 0].min()
        highest = peaks[chunk:cycles, 0].max()
        if chunk > 0 and cycles - chunk == _CHUNK and highest - lowest <= settings.tolerance * highest:
            first = chunk
            impacts_before = impacts_of_run
            error = highest - lowest
            status = _CONVERGED
            break
        if chunk < burn_in <= cycles:
            first = cycles
            impacts_before = counts[IMPACTS]
        if first > 0 and cycles - first >= _FEWEST_STEPPED:
            mean, error = mean_and_error(peaks[:, 0], first, cycles)
            if error <= settings.tolerance * mean:
                status = _CONVERGED
                break
    if status == _MAX_CYCLES and cycles - first < _CHUNK:  # too little is left after the burn-in
        first = 0
        impacts_before = 0
    if status == _MAX_CYCLES:
        if grows(peaks[:, 0], first, cycles):
            return failed(_UNBOUNDED, cycles)
        mean, error = mean_and_error(peaks[:, 0], first, cycles)
    return Response(
        peaks[first:cycles, 0].mean(),
        peaks[first:cycles, 0].max(),
        nan,
        peaks[first:cycles, 1].mean(),
        nan,
        nan,
        error,
        nan,
        _UNKNOWN,
        0,
        nan,
        (counts[IMPACTS] - impacts_before) / (cycles - first),
        nan,
        nan,
        nan,
        nan,
        nan,
        nan,
        nan,
        nan,
        cycles,
        status,
    )
