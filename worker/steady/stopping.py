"""Rules by which a run ends, each by its name."""

from math import log, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.solver.excitation.excitation import largest_forcing
from damperlab.worker.solver.excitation.sine_base import SineForce
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import State
from damperlab.worker.steady.response.statistics import Estimate
from damperlab.worker.steady.section.recurrence import recurrence

LARGEST_BURN_IN = 0.2
"""Share of `max_cycles`, or of the events allowed, that a burn-in may take: a structure without damping has no other bound."""
FEWEST_MEASURED = 768
"""Cycles before a standard error is believed."""

_TRANSIENT_LEFT = 0.02  # share of a free vibration that is left after the burn-in
_CORRELATIONS = 100.0  # correlation times that have to be measured
# The next look comes after so many times the cycles of the last, at the least and at the most: an error is itself uncertain by
# a tenth, what it asks for by a fifth, and a look further ahead would overshoot by as much.
_SOONEST_LOOK = 1.05
_LATEST_LOOK = 1.25
# Excess displacement, over min(1, P r²), below which creep towards the locked set cannot overshoot it.
_CREEP = 1e-2
_TIE = 1e-12


class Settings(NamedTuple):
    """When to stop: the study's `steady` block; and whether energies and acceleration are measured (as in `Meter`)."""

    max_cycles: int
    tolerance: float
    periodic_tolerance: float
    energies: bool | None = True
    acceleration: bool | None = None


@kernel
def burn_in_of(base: Any, settings: Settings) -> int:
    """Half cycles after which the slowest free vibration, that of the structure, has all but died: it falls as e^(−ζτ).

    Until `_TRANSIENT_LEFT` of it is left, ln(50) r/(2πζ) = 0.62 r/ζ cycles. What then is still no steady response is found by
    its data (`statistics.estimate`).
    """
    longest = LARGEST_BURN_IN * settings.max_cycles
    if base.two_zeta <= 0.0:
        return 2 * int(longest)
    needed = -log(_TRANSIENT_LEFT) * base.frequency_ratio / (pi * base.two_zeta)
    return 2 * int(min(needed, longest))


@kernel
def is_known(mean: Estimate, settings: Settings) -> bool:
    """Whether the mean of a response that does not repeat is known to the tolerance, from enough of it, without a drift."""
    measured = mean.last - mean.first
    return (
        mean.error <= settings.tolerance * mean.mean
        and measured >= FEWEST_MEASURED
        and measured >= _CORRELATIONS * mean.correlation
        and mean.stationary
    )


@kernel
def next_estimate(mean: Estimate, settings: Settings) -> int:
    """Metered cycles of the next look, planned from this one.

    Looks are few, and each at a length fixed before its data are seen: a mean that was looked at again and again, until its
    error happened to be small, would be off by more than its error.
    """
    measured = mean.last - mean.first
    needed = max(
        measured * (mean.error / (settings.tolerance * mean.mean)) ** 2, _CORRELATIONS * mean.correlation
    )
    return mean.first + int(min(max(needed, _SOONEST_LOOK * measured), _LATEST_LOOK * measured))


@kernel
def creep_limit(state: State, friction: float, scene: Scene) -> tuple[State, bool]:
    """Locked state that a one-sided creep tends to.

    With P the largest forcing, r² of a shaken base or the force of 1, for γ_F ≥ P every rest position |v| ≤ γ_F − P is locked
    for good. From outside by an excess x, each cycle slips inwards by about x²/(P r²), so the edge is reached only as 1/N:
    take the limit instead of stepping towards it. A particle rests where it is, if it stays clear of both walls.
    """
    forcing = largest_forcing(scene.base)
    frequency_ratio = scene.base.frequency_ratio
    edge = friction - forcing
    if edge < 0.0 and edge > -_TIE * forcing:
        edge = 0.0  # γ_F = r² but for the rounding of r²
    # a slip of the excess force x under a largest forcing P lasts about √(8x/P)/r and goes about x²/(P r²) far
    if (
        edge >= 0.0
        and state.slip == 0.0
        and state.p_rate == 0.0
        and state.riding == 0.0
        and edge < abs(state.v) <= edge + _CREEP * min(1.0, forcing * (frequency_ratio * frequency_ratio))
    ):
        v = edge if state.v > 0.0 else -edge
        gap = state.gap
        clear = True
        if scene.particle is not None:
            gap = state.gap - state.wall * (v - state.v)
            swing = 0.0 if isinstance(scene.base, SineForce) else 1.0  # of the base
            clear = abs(gap - scene.particle.clearance_ratio) + swing <= scene.particle.clearance_ratio
        if clear:
            return State(v, 0.0, 0.0, state.wall, gap, 0.0, 0.0, 0, 0, state.dwell), True
    return state, False


@kernel
def is_locked(state: State, friction: float, forcing: float, ring: NDArray[np.float64], half: int) -> bool:
    """Whether friction has held the mass for a cycle and holds it for good: P + |v| ≤ γ_F, and the particle is at rest."""
    return (
        state.slip == 0.0
        and state.p_rate == 0.0
        and forcing + abs(state.v) <= friction
        and recurrence(ring, half, 2) == 0.0
    )
