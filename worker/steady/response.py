"""The measures of one design point, and how they follow from a meter."""

from math import nan, pi, sqrt
from typing import NamedTuple

from damperlab.studies.variables import ResponseClass
from damperlab.worker.jit import kernel
from damperlab.worker.solver.state import FRICTION_LOSS, IMPACT_LOSS, SPEED, SQUARE, STUCK, VISCOUS_LOSS
from damperlab.worker.steady.energy import energy_residual

_UNKNOWN = int(ResponseClass.UNKNOWN)
_LOCKED = int(ResponseClass.LOCKED)
_NO_IMPACT = int(ResponseClass.NO_IMPACT)
_SYMMETRIC = int(ResponseClass.SYMMETRIC)
_ASYMMETRIC = int(ResponseClass.ASYMMETRIC)
_SUBHARMONIC = int(ResponseClass.SUBHARMONIC)

INTEGRATED = frozenset(
    (
        "amplitude_ratio_rms",
        "energy_residual",
        "dissipation_viscous",
        "dissipation_friction",
        "dissipation_impact",
    )
)
"""Measures that need integrals over the motion; a study that stores none of them is computed without."""

FEWEST_STUCK = 1.0 - 1e-6
"""Share of time from which a mass counts as locked: at γ_F = r² it touches slip at single instants."""


class Response(NamedTuple):
    """The measures of one design point, named as in `damperlab.studies.variables`."""

    amplitude_ratio: float
    amplitude_ratio_max: float
    amplitude_ratio_rms: float
    relative_amplitude_ratio: float
    amplitude_error: float
    energy_residual: float
    response_class: int
    period: int
    floquet_multiplier: float
    impacts_per_cycle: float
    impact_speed_max: float
    stick_fraction: float
    dissipation_viscous: float
    dissipation_friction: float
    dissipation_impact: float
    cycles: int
    status: int


@kernel
def failed(status, cycles):
    """Response of a point whose march ended early."""
    return Response(
        nan, nan, nan, nan, nan, nan, _UNKNOWN, 0, nan, nan, nan, nan, nan, nan, nan, cycles, status
    )


@kernel
def periodic_class(lag, stuck, impacts):
    """Class and period [excitation cycles] of a response that repeats after `lag` mirrored half cycles."""
    period = lag if lag % 2 == 1 else lag // 2
    if stuck >= FEWEST_STUCK:
        return _LOCKED, 1
    if impacts == 0:
        return _NO_IMPACT, period
    if lag == 1:
        return _SYMMETRIC, period
    if lag == 2:
        return _ASYMMETRIC, period
    return _SUBHARMONIC, period


@kernel
def measured_response(
    meter,
    peaks,
    first,
    last,
    impacts,
    stored_before,
    stored_after,
    frequency_ratio,
    lag,
    unsteady_class,
    multiplier,
    error,
    cycles,
    status,
):
    """Response from what was metered over the cycles first … last − 1.

    Parameters
    ----------
    meter : Meter
        Sums over those cycles; without energies, what follows from them is NaN.
    peaks : array, shape (cycles, 2)
        Peaks of |u| and |v| of each cycle.
    impacts : int
        Impacts in those cycles.
    stored_before, stored_after : float
        Stored energy at their ends.
    lag : int
        Period in mirrored half cycles; 0 for a response that is not periodic, whose class is `unsteady_class`.
    multiplier, error, cycles, status
        Handed through.
    """
    count = last - first
    amplitude = 0.0
    relative = 0.0
    largest = 0.0
    for i in range(first, last):
        amplitude += peaks[i, 0]
        relative += peaks[i, 1]
        largest = max(largest, peaks[i, 0])
    time = count * 2.0 * pi / frequency_ratio
    sums = meter.sums
    residual = nan
    rms = nan
    share = nan
    if meter.energies is not None:
        losses = sums[VISCOUS_LOSS] + sums[FRICTION_LOSS] + sums[IMPACT_LOSS]
        # a locked mass loses nothing: no shares of rounding
        share = 1.0 / losses if losses > 1e-12 * stored_before else 0.0
        residual = energy_residual(sums, stored_before, stored_after)
        rms = sqrt(2.0 * sums[SQUARE] / time)
    stuck = min(sums[STUCK] / time, 1.0)
    kind = unsteady_class
    period = 0
    if lag > 0:
        kind, period = periodic_class(lag, stuck, impacts)
    return Response(
        amplitude / count,
        largest,
        rms,
        relative / count,
        error,
        residual,
        kind,
        period,
        multiplier,
        impacts / count,
        sums[SPEED],
        stuck,
        sums[VISCOUS_LOSS] * share,
        sums[FRICTION_LOSS] * share,
        sums[IMPACT_LOSS] * share,
        cycles,
        status,
    )
