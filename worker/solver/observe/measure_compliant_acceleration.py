"""Acceleration u'' of the structure in contact with a compliant wall: its polynomial and its largest value."""

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.compliant_regime import (
    AnyRegime,
    CompliantRegime,
    buffers_of,
    wall_of,
)
from damperlab.worker.solver.excitation.excitation import Excitation
from damperlab.worker.solver.excitation.record_base import RecordBase
from damperlab.worker.solver.excitation.sine_base import SineForce
from damperlab.worker.solver.motion.compliant_motion import Buffers
from damperlab.worker.solver.motion.extrema import raised
from damperlab.worker.solver.motion.taylor import ORDER, TERMS, curvature_bound, rate_into, value
from damperlab.worker.solver.motion.vibration import (
    ENVELOPE_SAFETY,
    LinearForm,
    Vibration,
    form_of_w,
    form_of_wall_force,
    form_of_x,
    gain_of,
    size_of,
    vibration_after,
)
from damperlab.worker.solver.observe.meter import ACCELERATION_PEAK, Meter
from damperlab.worker.solver.scene import Scene

_DROWNED = 1e-16  # below this fraction of the peak, a vibration does not change the digits of the peak


@inlined
def record_acceleration(buffers: Buffers, t: float) -> float:
    """Acceleration s'' of a record, from the polynomial of s."""
    acceleration: float = 2.0 * buffers.excitation[2] + 6.0 * buffers.excitation[3] * t
    return acceleration


@inlined
def acceleration_at(
    transmitted: float, t: float, regime: AnyRegime, base: Excitation, buffers: Buffers
) -> float:
    """Return u'' from the polynomials and the force `transmitted` by spring, dashpot and friction."""
    if isinstance(base, SineForce):
        if regime.sticks:
            return 0.0
        return (transmitted + value(buffers.excitation, t)) - value(buffers.wall_force, t)
    return transmitted - value(buffers.wall_force, t)


@kernel
def slip_acceleration_into(base: Excitation, buffers: Buffers, out: Floats) -> None:
    """Write the coefficients of u'' of a slipping mass: −(2ζw + x), minus the wall force, plus the exciting force."""
    for n in range(ORDER):
        out[n] = (
            -(base.two_zeta * (n + 1) * buffers.relative[n + 1] + buffers.relative[n]) - buffers.wall_force[n]
        )
    out[ORDER] = 0.0
    if isinstance(base, SineForce):
        for n in range(ORDER):
            out[n] += buffers.excitation[n]


@kernel
def raise_acceleration_in_contact(meter: Meter, t: float, regime: AnyRegime, scene: Scene) -> None:
    """Raise the peak to the largest |u''| of a segment, from its polynomials."""
    sums, base, buffers = meter.sums, scene.base, buffers_of(scene)
    if regime.sticks:
        if isinstance(base, RecordBase):  # s'' is linear in time
            ends = max(abs(record_acceleration(buffers, 0.0)), abs(record_acceleration(buffers, t)))
            sums[ACCELERATION_PEAK] = max(sums[ACCELERATION_PEAK], ends)
        elif not isinstance(base, SineForce):
            r_squared = base.frequency_ratio * base.frequency_ratio
            for n in range(TERMS):
                buffers.rate[n] = r_squared * buffers.excitation[n]
            peak = sums[ACCELERATION_PEAK]
            sums[ACCELERATION_PEAK] = largest(buffers.rate, 0.0, t, peak, buffers.scratch)
    else:
        slip_acceleration_into(base, buffers, buffers.rate)
        peak = sums[ACCELERATION_PEAK]
        sums[ACCELERATION_PEAK] = largest(buffers.rate, 0.0, t, peak, buffers.scratch)


@kernel
def largest(polynomial: Floats, offset: float, t: float, peak: float, scratch: Floats) -> float:
    """Return the larger of `peak` and the largest |p − offset| over [0, t]."""
    ends = max(abs(polynomial[0] - offset), abs(value(polynomial, t) - offset))
    peak = max(peak, ends)
    curvature = curvature_bound(polynomial, t)
    if ends + 0.125 * t * t * curvature <= peak or abs(polynomial[1]) > t * curvature:
        return peak
    rate_into(polynomial, 0, scratch)
    most = curvature_bound(scratch, t)
    return raised(peak, polynomial, offset, scratch, t, most)


@kernel
def form_of_acceleration(regime: CompliantRegime, scene: Scene) -> LinearForm:
    """Linear form of the vibration's contribution to u'' of a slipping mass."""
    x, w = form_of_x(regime.motion), form_of_w(regime.motion)
    wall_force = form_of_wall_force(regime.motion, wall_of(scene))
    two_zeta = scene.base.two_zeta
    return LinearForm(
        -(two_zeta * w.first + x.first) - wall_force.first,
        -(two_zeta * w.second + x.second) - wall_force.second,
    )


@kernel
def raise_over_long_step(
    meter: Meter, t: float, vibration: Vibration, regime: CompliantRegime, scene: Scene
) -> None:
    """Raise the peak to the largest |u''| of a long step, for slow motion and vibration together.

    The length of the step does not depend on u'', so that a point has the same bits whether u'' is measured or not. The
    step is divided into spans in which a polynomial represents the vibration. The division ends when the slow motion
    and the envelope of the vibration prove that no higher value follows.
    """
    if regime.sticks:
        raise_acceleration_in_contact(meter, t, regime, scene)
        return
    sums, motion, buffers = meter.sums, regime.motion, buffers_of(scene)
    slow, both, scratch = buffers.rate, buffers.start, buffers.scratch
    slip_acceleration_into(scene.base, buffers, slow)
    form = form_of_acceleration(regime, scene)
    gain = ENVELOPE_SAFETY * gain_of(form, motion.weight)
    peak = sums[ACCELERATION_PEAK]
    time_left = t
    while time_left > 0.0:
        envelope = gain * size_of(vibration, motion.weight)
        ends = max(abs(slow[0]), abs(value(slow, time_left)))
        if ends + 0.125 * time_left * time_left * curvature_bound(slow, time_left) + envelope <= peak:
            break
        if envelope <= _DROWNED * peak:
            peak = largest(slow, 0.0, time_left, peak, scratch)
            break
        step = min(motion.step, time_left)
        _add_vibration(slow, vibration, form, motion.rates, both)
        peak = largest(both, 0.0, step, peak, scratch)
        vibration = vibration_after(vibration, motion.rates, step)
        _shift(slow, step)
        time_left = time_left - step
    sums[ACCELERATION_PEAK] = peak


@kernel
def _add_vibration(slow: Floats, vibration: Vibration, form: LinearForm, rates: Floats, out: Floats) -> None:
    """Write the coefficients of the sum of a polynomial and the linear form of exp(Λt) f."""
    first, second = vibration
    for n in range(TERMS):
        out[n] = slow[n] + (form.first * first + form.second * second)
        one = (rates[0] * first + rates[1] * second) / (n + 1)
        second = (rates[2] * first + rates[3] * second) / (n + 1)
        first = one


@kernel
def _shift(p: Floats, t: float) -> None:
    """Replace the coefficients of p(τ) by the coefficients of p(t + τ), by repeated Horner steps."""
    for i in range(ORDER):
        for j in range(ORDER - i):
            n = ORDER - 1 - j
            p[n] += t * p[n + 1]
