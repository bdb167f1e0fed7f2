"""u'' of the structure in a compliant wall, where it is finite: its polynomial, its largest value, also over a long step."""

from math import sqrt

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.contact_regime import (
    AnyRegime,
    ContactRegime,
    Vibration,
    buffers_of,
    wall_of,
)
from damperlab.worker.solver.excitation.excitation import Excitation
from damperlab.worker.solver.excitation.record_base import RecordBase
from damperlab.worker.solver.excitation.sine_base import SineForce
from damperlab.worker.solver.memory import Floats
from damperlab.worker.solver.motion.contact_motion import Buffers
from damperlab.worker.solver.motion.extrema import raised
from damperlab.worker.solver.motion.slow_subspace import fast_later
from damperlab.worker.solver.motion.taylor import ORDER, TERMS, curvature_bound, rate_into, value
from damperlab.worker.solver.observe.meter import ACCELERATION_PEAK, Meter
from damperlab.worker.solver.scene import Scene

_SAFETY = 2.0  # the envelope of f falls exactly only without the coupling to the slow motion
_DROWNED = 1e-16  # of the peak: a vibration below it changes none of its digits


@inlined
def record_acceleration(buffers: Buffers, t: float) -> float:
    """Acceleration s'' of a record, from the polynomial of s."""
    acceleration: float = 2.0 * buffers.shaken[2] + 6.0 * buffers.shaken[3] * t
    return acceleration


@inlined
def acceleration_at(
    transmitted: float, t: float, regime: AnyRegime, base: Excitation, buffers: Buffers
) -> float:
    """u'' from the polynomials and what spring, dashpot and friction transmit; a mass that is held moves with its base."""
    if isinstance(base, SineForce):
        if regime.sticks:
            return 0.0
        return (transmitted + value(buffers.shaken, t)) - value(buffers.push, t)
    return transmitted - value(buffers.push, t)


@kernel
def acceleration_into(base: Excitation, buffers: Buffers, out: Floats) -> None:
    """Coefficients of u'' of a mass that slips, from the forces on it: −(2ζw + x) less the push, and what excites it."""
    for n in range(ORDER):
        out[n] = -(base.two_zeta * (n + 1) * buffers.relative[n + 1] + buffers.relative[n]) - buffers.push[n]
    out[ORDER] = 0.0
    if isinstance(base, SineForce):
        for n in range(ORDER):
            out[n] += buffers.shaken[n]


@kernel
def raise_acceleration_in_wall(meter: Meter, t: float, regime: AnyRegime, scene: Scene) -> None:
    """Raise the peak to the largest |u''| on the expanded polynomials."""
    sums, base, buffers = meter.sums, scene.base, buffers_of(scene)
    if regime.sticks:
        if isinstance(base, RecordBase):  # linear
            ends = max(abs(record_acceleration(buffers, 0.0)), abs(record_acceleration(buffers, t)))
            sums[ACCELERATION_PEAK] = max(sums[ACCELERATION_PEAK], ends)
        elif not isinstance(base, SineForce):
            r_squared = base.frequency_ratio * base.frequency_ratio
            for n in range(TERMS):
                buffers.rate[n] = r_squared * buffers.shaken[n]
            peak = sums[ACCELERATION_PEAK]
            sums[ACCELERATION_PEAK] = largest(buffers.rate, 0.0, t, peak, buffers.scratch)
    else:
        acceleration_into(base, buffers, buffers.rate)
        peak = sums[ACCELERATION_PEAK]
        sums[ACCELERATION_PEAK] = largest(buffers.rate, 0.0, t, peak, buffers.scratch)


@kernel
def largest(polynomial: Floats, offset: float, t: float, peak: float, scratch: Floats) -> float:
    """The larger of a peak and the largest |p − offset| over [0, t]."""
    ends = max(abs(polynomial[0] - offset), abs(value(polynomial, t) - offset))
    peak = max(peak, ends)
    curvature = curvature_bound(polynomial, t)
    if ends + 0.125 * t * t * curvature <= peak or abs(polynomial[1]) > t * curvature:
        return peak
    rate_into(polynomial, 0, scratch)
    most = curvature_bound(scratch, t)
    return raised(peak, polynomial, offset, scratch, t, most)


@kernel
def acceleration_of_vibration(regime: ContactRegime, scene: Scene) -> tuple[float, float]:
    """What u'' of a mass that slips has of each part of the vibration f."""
    motion, wall = regime.motion, wall_of(scene)
    writer, share = motion.writer, motion.share
    two_zeta = scene.base.two_zeta
    x1, x2 = writer[0] + share * writer[8], writer[1] + share * writer[9]
    w1, w2 = writer[2] + share * writer[10], writer[3] + share * writer[11]
    n1 = -(two_zeta * w1 + x1)
    n2 = -(two_zeta * w2 + x2)
    return (
        n1 - (wall.stiffness * writer[8] + wall.damping * writer[10]),
        n2 - (wall.stiffness * writer[9] + wall.damping * writer[11]),
    )


@kernel
def raise_over_long_step(
    meter: Meter, t: float, vibration: Vibration, regime: ContactRegime, scene: Scene
) -> None:
    """Raise the peak to the largest |u''| of a long step: slow motion, which is expanded, and vibration together.

    The step is as long as it is without a look at u'', so that a point has the same bits. It is gone through by spans that the
    vibration has a polynomial for, until envelope and slow motion prove that nothing higher can come.
    """
    if regime.sticks:
        raise_acceleration_in_wall(meter, t, regime, scene)
        return
    sums, motion, buffers = meter.sums, regime.motion, buffers_of(scene)
    slow, both, scratch = buffers.rate, buffers.start, buffers.scratch
    acceleration_into(scene.base, buffers, slow)
    of_first, of_second = acceleration_of_vibration(regime, scene)
    gain = _SAFETY * sqrt((of_first / motion.weight) ** 2 + of_second * of_second)
    first, second = vibration
    peak = sums[ACCELERATION_PEAK]
    time_left = t
    while time_left > 0.0:
        shaken = gain * sqrt(second * second + (motion.weight * first) ** 2)
        ends = max(abs(slow[0]), abs(value(slow, time_left)))
        if ends + 0.125 * time_left * time_left * curvature_bound(slow, time_left) + shaken <= peak:
            break
        if shaken <= _DROWNED * peak:
            peak = largest(slow, 0.0, time_left, peak, scratch)
            break
        step = min(motion.step, time_left)
        _add_vibration(slow, first, second, of_first, of_second, motion.rates, both)
        peak = largest(both, 0.0, step, peak, scratch)
        first, second = fast_later(motion.rates, first, second, step)
        _shift(slow, step)
        time_left = time_left - step
    sums[ACCELERATION_PEAK] = peak


@kernel
def _add_vibration(
    slow: Floats, first: float, second: float, of_first: float, of_second: float, rates: Floats, out: Floats
) -> None:
    """Coefficients of a polynomial and the linear form of exp(Ft) f together."""
    for n in range(TERMS):
        out[n] = slow[n] + (of_first * first + of_second * second)
        one = (rates[0] * first + rates[1] * second) / (n + 1)
        second = (rates[2] * first + rates[3] * second) / (n + 1)
        first = one


@kernel
def _shift(p: Floats, t: float) -> None:
    """Coefficients of p(t + …), in place: by Horner's scheme again and again."""
    for i in range(ORDER):
        for j in range(ORDER - i):
            n = ORDER - 1 - j
            p[n] += t * p[n + 1]
