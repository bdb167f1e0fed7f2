"""The measures of one design point, and their derivation from a trace."""

from math import nan, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.variables import ResponseClass
from damperlab.worker.jit import kernel
from damperlab.worker.steady.response.energy import unbalanced
from damperlab.worker.steady.response.standard_errors import mean_and_error
from damperlab.worker.steady.response.trace import (
    HALF_PEAK,
    HALF_SPEED,
    IMPACTS_SO_FAR,
    LOSSES,
    Stretch,
    largest_in,
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
"""Measures that need integrals over the motion. If a study stores none of them, the integrals are not computed."""

FEWEST_STUCK = 1.0 - 1e-6
"""Share of time above which a mass counts as locked, because at γ_F = r² it slips at single instants."""


ACCELERATION = frozenset(("acceleration_ratio", "acceleration_ratio_rms"))
"""Measures of u''. If a study stores neither, u'' is not measured."""


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


class Kind(NamedTuple):
    """The kind of response, and its errors.

    Attributes
    ----------
    response_class, period : int
        Period in excitation cycles; 0 for a response that is not periodic.
    multiplier : float
        Largest Floquet multiplier; NaN for a response that is not periodic.
    error : float
        Standard error of the mean peak; for a periodic response, the distance from periodicity.
    cycles, status : int
        Cycles of the run, and its outcome.
    """

    response_class: int
    period: int
    multiplier: float
    error: float
    cycles: int
    status: int


class Largest(NamedTuple):
    """Largest |u|, and the largest speed of an impact, of a response."""

    peak: float
    speed: float


class MeanPeaks(NamedTuple):
    """Mean peaks of |u| and |v|, and the standard errors of impacts per cycle and of the shares of dissipation."""

    amplitude: float
    relative: float
    impacts_error: float
    dissipation_error: float


@kernel
def failed(status: int, cycles: int) -> Response:
    """Response of a point whose run ended early."""
    return Response(
        nan,
        nan,
        nan,
        nan,
        nan,
        nan,
        nan,
        nan,
        _UNKNOWN,
        0,
        nan,
        nan,
        nan,
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


@kernel
def share_stuck(stretch: Stretch, frequency_ratio: float) -> float:
    """Share of a stretch in which friction holds the mass."""
    cycles = 0.5 * (stretch.last - stretch.first)
    return stretch.stuck / (cycles * 2.0 * pi / frequency_ratio)


@kernel
def periodic_class(period_halves: int, stuck: float, impacts: float, carried: bool) -> tuple[int, int]:
    """Class and period [excitation cycles] of a response that repeats after `period_halves` mirrored half cycles.

    `carried` says whether the particle's friction carries it along all the time.
    """
    period = period_halves if period_halves % 2 == 1 else period_halves // 2
    if stuck >= FEWEST_STUCK:  # a particle may keep moving between walls that stay at rest
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
    """Means over one period of `period_halves` half cycles, which are the rows 1 … period_halves of the trace.

    One interval of a whole cycle begins at every half cycle, so that a motion and its mirror image have the same mean.
    """
    amplitude = 0.0
    relative = 0.0
    for i in range(period_halves):
        here = trace[i + 1]
        after = trace[(i + 1) % period_halves + 1]
        amplitude += max(here[0], after[0])
        relative += max(here[1], after[1])
    amplitude /= period_halves
    return MeanPeaks(amplitude, relative / period_halves, 0.0, error / amplitude if amplitude > 0.0 else 0.0)


@kernel
def mean_of_run(
    trace: NDArray[np.float64], peaks: NDArray[np.float64], series: NDArray[np.float64], first: int, last: int
) -> MeanPeaks:
    """Means over the metered cycles first … last − 1 of a run that does not repeat, with their standard errors.

    Parameters
    ----------
    trace : array
        Of the run.
    peaks : array, shape (2, ≥ last)
        Of |u| and of |v| in each cycle.
    series : array, shape (≥ last,)
        Overwritten.
    first, last : int
        Cycles.
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
def largest_of_run(trace: NDArray[np.float64], stretch: Stretch, mean: MeanPeaks) -> Largest:
    """Largest values in the last three quarters of the metered cycles of a run that does not repeat.

    A remaining transient may already be negligible in a mean, but not yet in a largest peak. The burn-in is that of the
    structure alone; the particle, and the mass with it, settle more slowly. If a run is short, its last cycles may all
    be below the mean, or without an impact.
    """
    first = stretch.first + (stretch.last - stretch.first) // 8 * 2
    peak = max(largest_in(trace, first, stretch.last, HALF_PEAK), mean.amplitude)
    speed = largest_in(trace, first, stretch.last, HALF_SPEED)
    return Largest(peak, speed if speed > 0.0 else stretch.speed)


@kernel
def _error_of_shares(trace: NDArray[np.float64], series: NDArray[np.float64], first: int, last: int) -> float:
    """Largest standard error of the shares of dissipation, as that of a ratio of means, linearised."""
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
    largest: Largest,
    acceleration: tuple[float, float] | None,
    kind: Kind,
) -> Response:
    """Response from the metered sums.

    Parameters
    ----------
    stretch : Stretch
        Totals of the metered half cycles.
    energies : True or None
        Whether integrals were metered; without them, derived measures are NaN.
    frequency_ratio : float
        r.
    mean : MeanPeaks
        Mean peaks, and errors.
    largest : Largest
        Largest peak and impact speed.
    acceleration : tuple or None
        Mean peak of |u''|, and ∫u''² dτ; None if u'' was not metered, and derived measures are then NaN.
    kind : Kind
        Class, period and status.
    """
    cycles = 0.5 * (stretch.last - stretch.first)
    time = cycles * 2.0 * pi / frequency_ratio
    residual = nan
    rms = nan
    share = nan
    shares_error = nan
    per_cycle = nan
    if energies is not None:
        losses = stretch.viscous + stretch.friction + stretch.impact + stretch.rubbing
        # a locked mass dissipates nothing, so shares would be those of rounding
        share = 1.0 / losses if losses > 1e-12 * stretch.stored_before else 0.0
        shares_error = mean.dissipation_error if share > 0.0 else 0.0
        per_cycle = losses / cycles if share > 0.0 else 0.0
        residual = unbalanced(
            stretch.work,
            losses,
            stretch.stored_before,
            stretch.stored_after,
            max(stretch.peak, stretch.relative_peak),
        )
        rms = sqrt(2.0 * stretch.square / time)
    acceleration_peak = nan
    acceleration_rms = nan
    if acceleration is not None:
        acceleration_peak = acceleration[0]
        acceleration_rms = sqrt(2.0 * acceleration[1] / time)
    return Response(
        amplitude_ratio=mean.amplitude,
        amplitude_ratio_max=largest.peak,
        amplitude_ratio_rms=rms,
        relative_amplitude_ratio=mean.relative,
        acceleration_ratio=acceleration_peak,
        acceleration_ratio_rms=acceleration_rms,
        amplitude_error=kind.error,
        energy_residual=residual,
        response_class=kind.response_class,
        period=kind.period,
        floquet_multiplier=kind.multiplier,
        impacts_per_cycle=stretch.impacts / cycles,
        impacts_error=mean.impacts_error,
        impact_speed_max=largest.speed,
        stick_fraction=min(share_stuck(stretch, frequency_ratio), 1.0),
        dissipation_per_cycle=per_cycle,
        dissipation_viscous=stretch.viscous * share,
        dissipation_friction=stretch.friction * share,
        dissipation_impact=stretch.impact * share,
        dissipation_particle=stretch.rubbing * share,
        dissipation_error=shares_error,
        cycles=kind.cycles,
        status=kind.status,
    )
