"""Rules by which a run ends."""

from math import log, pi
from typing import NamedTuple

from damperlab.worker.jit import kernel
from damperlab.worker.solver.scene import Scene
from damperlab.worker.steady.response.standard_errors import Estimate

LARGEST_BURN_IN = 0.2
"""Largest burn-in, as a fraction of `max_cycles` and of the allowed events.

Without damping, nothing else limits the burn-in.
"""
FEWEST_MEASURED = 768
"""Least number of measured cycles for which a standard error is used."""

_TRANSIENT_LEFT = 0.02  # Fraction of a free vibration that remains after the burn-in.
# Frequency ratio, 1/e, below which a burn-in is longer.
# At this ratio, the remaining transient is 0.02 e² = 15 % of the response's velocity.
# The test of stationarity detects a transient of this size.
_SLOW = 0.37
_CORRELATIONS = 100.0  # Least number of correlation times in the measured cycles.
# Smallest and largest ratio of the numbers of cycles at two successive checks.
# An error estimate is uncertain by a tenth, so the required number of cycles is uncertain by a fifth.
# With a larger ratio, a run could exceed the required number by more than this uncertainty.
_SOONEST_LOOK = 1.05
_LATEST_LOOK = 1.25


class Settings(NamedTuple):
    """Criteria for stopping, from the study's block `steady`.

    The last two fields say whether energies and acceleration are measured.
    """

    max_cycles: int
    tolerance: float
    periodic_tolerance: float
    energies: bool | None = True
    acceleration: bool | None = None


@kernel
def burn_in_of(scene: Scene, settings: Settings) -> int:
    """Number of half cycles after which the free vibration of the structure, e^(−ζτ), has nearly decayed.

    The burn-in ends when `_TRANSIENT_LEFT` of the vibration remains, after ln(50) r/(2πζ) = 0.62 r/ζ cycles, but at
    least one cycle. A longer transient is detected from the data (`standard_errors.estimate`).

    Far below resonance a run from rest starts with the velocity r of the base, whereas the response's velocity relative
    to the base is of the order r³. So for r below `_SLOW` the transient must decay further. With a carried particle,
    the transient decays as e^(−ζτ/(1 + β)).
    """
    longest = LARGEST_BURN_IN * settings.max_cycles
    base = scene.base
    if base.two_zeta <= 0.0:
        return 2 * int(longest)
    exponent = -log(_TRANSIENT_LEFT)
    if base.frequency_ratio < _SLOW:
        exponent += 2.0 * log(_SLOW / base.frequency_ratio)
        if scene.particle is not None:
            exponent *= 1.0 + scene.particle.mass_ratio
    needed = exponent * base.frequency_ratio / (pi * base.two_zeta)
    return 2 * int(min(max(needed, 1.0), longest))


@kernel
def is_known(mean: Estimate, settings: Settings) -> bool:
    """Whether the mean of a response that does not repeat is known to the tolerance, from enough stationary data."""
    measured = mean.last - mean.first
    return (
        mean.error <= settings.tolerance * mean.mean
        and measured >= FEWEST_MEASURED
        and measured >= _CORRELATIONS * mean.correlation
        and mean.stationary
    )


@kernel
def next_estimate(mean: Estimate, settings: Settings) -> int:
    """Number of metered cycles at the next check, planned from the current estimate.

    Each check is planned in advance. Checking repeatedly until the error happens to be small would understate the
    error.
    """
    measured = mean.last - mean.first
    needed = _CORRELATIONS * mean.correlation
    if mean.mean > 0.0:
        needed = max(measured * (mean.error / (settings.tolerance * mean.mean)) ** 2, needed)
    return mean.first + int(min(max(needed, _SOONEST_LOOK * measured), _LATEST_LOOK * measured))
