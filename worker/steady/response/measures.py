"""The measures of one design point, computed from a trace."""

from math import nan, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.variables import ResponseClass
from damperlab.worker.jit import kernel
from damperlab.worker.steady.response.energy import unbalanced
from damperlab.worker.steady.response.standard_errors import mean_and_error
from damperlab.worker.steady.response.trace import (
    HALF_PEAK,
    HALF_RELATIVE_PEAK,
    HALF_SPEED,
    IMPACTS_SO_FAR,
    LOSSES,
    Stretch,
    largest_in,
    mean_peak_of_period,
)

_UNKNOWN = int(ResponseClass.UNKNOWN)
_LOCKED = int(ResponseClass.LOCKED)
_NO_IMPACT = int(ResponseClass.NO_IMPACT)
_CARRIED = int(ResponseClass.CARRIED)
_SYMMETRIC = int(ResponseClass.SYMMETRIC)
_ASYMMETRIC = int(ResponseClass.ASYMMETRIC)
_SUBHARMONIC = int(ResponseClass.SUBHARMONIC)

INTEGRATED = frozenset(
    (
        "amplitude_ratio_rms",
        "energy_residual",
        "dissipation_per_cycle",
        "dissipation_viscous",
        "dissipation_friction",
        "dissipation_impact",
        "dissipation_particle",
        "dissipation_error",
    )
)
"""Measures that need integrals over the motion. The integrals are not computed if a study stores none of these
measures.
"""

FEWEST_STUCK = 1.0 - 1e-6
"""Least stick fraction of the class LOCKED; below 1, because at γ_F = r² a locked mass slips at single instants."""


ACCELERATION = frozenset(("acceleration_ratio", "acceleration_ratio_rms"))
"""Measures of u''. If a study stores none of these measures, u'' is not measured."""


class Response(NamedTuple):
    """The measures of one design point, named as in `damperlab.studies.variables`."""

    amplitude_ratio: float
    amplitude_ratio_max: float
    amplitude_ratio_rms: float
    relative_amplitude_ratio: float
    acceleration_ratio: float
    acceleration_ratio_rms: float
    amplitude_error: float
    energy_residual: float
    response_class: int
    period: int
    floquet_multiplier: float
    impacts_per_cycle: float
    impacts_error: float
    impact_speed_max: float
    stick_fraction: float
    dissipation_per_cycle: float
    dissipation_viscous: float
    dissipation_friction: float
    dissipation_impact: float
    dissipation_particle: float
    dissipation_error: float
    cycles: int
    status: int


# Values of the fields before `cycles` in a response without measures.
_UNMEASURED: tuple[Any, ...] = (nan,) * 8 + (_UNKNOWN, 0) + (nan,) * 11


class MeanPeaks(NamedTuple):
    """Mean peaks of |u| and |v|, and the standard errors of impacts per cycle and of the shares of dissipation."""

    amplitude: float
    relative: float
    impacts_error: float
    dissipation_error: float


@kernel
def unmeasured(status: int, cycles: int) -> Response:
    """Response without measures, for example of a point whose run ended early."""
    return Response(*_UNMEASURED, cycles, status)  # type: ignore[call-arg]


@kernel
def share_stuck(stretch: Stretch, frequency_ratio: float) -> float:
    """Fraction of the time of a stretch in which friction holds the mass."""
    cycles = 0.5 * (stretch.last - stretch.first)
    return stretch.stuck / (cycles * 2.0 * pi / frequency_ratio)


@kernel
def periodic_class(period_halves: int, stuck: float, impacts: float, carried: bool) -> tuple[int, int]:
    """Class and period [excitation cycles] of a response that repeats after `period_halves` mirrored half cycles.

    `carried` is True if friction carries the particle along with the mass throughout.
    """
    period = period_halves if period_halves % 2 == 1 else period_halves // 2
    if stuck >= FEWEST_STUCK:  # a particle may keep moving between walls at rest
        return _LOCKED, 1 if impacts == 0 else period
    if carried:
        return _CARRIED, period
    if impacts == 0:
        return _NO_IMPACT, period
    if period_halves == 1:
        return _SYMMETRIC, period
    if period_halves == 2:
        return _ASYMMETRIC, period
    return _SUBHARMONIC, period


@kernel
def mean_of_period(trace: NDArray[np.float64], period_halves: int, error: float) -> MeanPeaks:
    """Mean peaks over one period of `period_halves` half cycles, which are the rows 1 … period_halves of the trace."""
    amplitude = mean_peak_of_period(trace, HALF_PEAK, period_halves)
    relative = mean_peak_of_period(trace, HALF_RELATIVE_PEAK, period_halves)
    return MeanPeaks(amplitude, relative, 0.0, error / amplitude if amplitude > 0.0 else 0.0)


@kernel
def mean_of_run(
    trace: NDArray[np.float64], peaks: NDArray[np.float64], series: NDArray[np.float64], first: int, last: int
) -> MeanPeaks:
    """Mean peaks over the metered cycles first … last − 1 of a run that does not repeat, and standard errors.

    `peaks` are the peaks of |u| and of |v| in each cycle; `series` is a work array for one number per cycle.
    """
    amplitude = 0.0
    relative = 0.0
    for i in range(first, last):
        amplitude += peaks[0, i]
        relative += peaks[1, i]
        series[i] = trace[2 * i + 2, IMPACTS_SO_FAR] - trace[2 * i, IMPACTS_SO_FAR]
    _, impacts_error = mean_and_error(series, first, last)
    count = last - first
    return MeanPeaks(
        amplitude / count, relative / count, impacts_error, _error_of_shares(trace, series, first, last)
    )


@kernel
def largest_of_run(trace: NDArray[np.float64], stretch: Stretch, mean: MeanPeaks) -> tuple[float, float]:
    """Largest |u| and largest impact speed in the last three quarters of the metered cycles of a run that does not repeat.

    A remaining transient may be negligible in a mean but determine the largest peak. The burn-in follows from
    the decay of the structure alone, but a mass with a particle settles more slowly. If the largest peak of
    the last three quarters is below the mean peak, the mean peak is used. If the last three quarters have no
    impact, the largest impact speed of all metered cycles is used.
    """
    first = stretch.first + (stretch.last - stretch.first) // 8 * 2
    peak = max(largest_in(trace, first, stretch.last, HALF_PEAK), mean.amplitude)
    speed = largest_in(trace, first, stretch.last, HALF_SPEED)
    return peak, speed if speed > 0.0 else stretch.speed


@kernel
def _error_of_shares(trace: NDArray[np.float64], series: NDArray[np.float64], first: int, last: int) -> float:
    """Largest standard error of a share of dissipation, from the linearised ratio of two means."""
    total = 0.0
    for loss in LOSSES:
        total += trace[2 * last, loss] - trace[2 * first, loss]
    if not total > 0.0:
        return 0.0
    per_cycle = total / (last - first)
    worst = 0.0
    for loss in LOSSES:
        share = (trace[2 * last, loss] - trace[2 * first, loss]) / total
        for i in range(first, last):
            of_cycle = 0.0
            for other in LOSSES:
                of_cycle += trace[2 * i + 2, other] - trace[2 * i, other]
            of_mechanism = trace[2 * i + 2, loss] - trace[2 * i, loss]
            series[i] = (of_mechanism - share * of_cycle) / per_cycle
        _, error = mean_and_error(series, first, last)
        worst = max(worst, error)
    return worst


@kernel
def measured_response(
    stretch: Stretch,
    energies: bool | None,
    frequency_ratio: float,
    mean: MeanPeaks,
    acceleration: tuple[float, float] | None,
) -> Response:
    """Compute the response from the totals of the metered half cycles, without class, period, multiplier and status.

    The measures that need integrals are NaN if `energies` is None. `acceleration` contains the mean peak of
    |u''| and ∫u''² dτ; the measures of u'' are NaN if `acceleration` is None.
    """
    cycles = 0.5 * (stretch.last - stretch.first)
    time = cycles * 2.0 * pi / frequency_ratio
    response = unmeasured(0, 0)._replace(
        amplitude_ratio=mean.amplitude,
        amplitude_ratio_max=stretch.peak,
        relative_amplitude_ratio=mean.relative,
        impacts_per_cycle=stretch.impacts / cycles,
        impacts_error=mean.impacts_error,
        impact_speed_max=stretch.speed,
        stick_fraction=min(share_stuck(stretch, frequency_ratio), 1.0),
    )
    if energies is not None:
        losses = stretch.viscous + stretch.friction + stretch.impact + stretch.rubbing
        # a locked mass dissipates nothing, so the shares would be ratios of rounding errors
        share = 1.0 / losses if losses > 1e-12 * stretch.stored_before else 0.0
        peak = max(stretch.peak, stretch.relative_peak)
        response = response._replace(
            amplitude_ratio_rms=sqrt(2.0 * stretch.square / time),
            energy_residual=unbalanced(
                stretch.work, losses, stretch.stored_before, stretch.stored_after, peak
            ),
            dissipation_per_cycle=losses / cycles if share > 0.0 else 0.0,
            dissipation_viscous=stretch.viscous * share,
            dissipation_friction=stretch.friction * share,
            dissipation_impact=stretch.impact * share,
            dissipation_particle=stretch.rubbing * share,
            dissipation_error=mean.dissipation_error if share > 0.0 else 0.0,
        )
    if acceleration is not None:
        response = response._replace(
            acceleration_ratio=acceleration[0],
            acceleration_ratio_rms=sqrt(2.0 * acceleration[1] / time),
        )
    return response
