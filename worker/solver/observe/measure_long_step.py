"""Observables over a long step of a decaying contact vibration: the slow motion plus the vibration's contribution.

The slow motion is integrated like an ordinary segment (`measure_contact.py`).
"""

from typing import NamedTuple

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.compliant_regime import CompliantRegime, buffers_of, wall_of
from damperlab.worker.solver.excitation.excitation import base_displacement, has_force
from damperlab.worker.solver.excitation.record_base import RecordBase
from damperlab.worker.solver.motion.slow_subspace import Y_RATE
from damperlab.worker.solver.motion.taylor import (
    ORDER,
    TERMS,
    acceleration_into,
    curvature_bound,
    rate_into,
    value,
)
from damperlab.worker.solver.motion.vibration import (
    ENVELOPE_SAFETY,
    LinearForm,
    Vibration,
    form_of,
    form_of_w,
    form_of_wall_force,
    form_of_x,
    gain_of,
    size_of,
    vibration_after,
)
from damperlab.worker.solver.observe.acceleration import add_square
from damperlab.worker.solver.observe.measure_contact import integrate_contact
from damperlab.worker.solver.observe.meter import (
    ACCELERATION_PEAK,
    ACCELERATION_SQUARE,
    IMPACT_LOSS,
    PEAK,
    RELATIVE_PEAK,
    RELATIVE_SQUARE,
    SQUARE,
    VISCOUS_LOSS,
    WORK_IN,
    Meter,
)
from damperlab.worker.solver.observe.peaks import largest
from damperlab.worker.solver.scene import Scene

LEAST_DECAY = 1e-9
"""Least |tr Λ| t of a long step. For smaller |tr Λ| t, the integral J (`measure_vibration`) is inaccurate,
because J is a difference of two end values, divided by tr Λ.
"""
_DROWNED = 1e-16  # below this fraction of the peak, a vibration does not change the digits of the peak


@kernel
def measure_long_step(
    meter: Meter,
    v_start: float,
    v_end: float,
    t: float,
    before: Vibration,
    after: Vibration,
    regime: CompliantRegime,
    scene: Scene,
) -> None:
    """Add a long step of length t to all requested observables.

    `longest_step` ensures that no displacement inside the step exceeds a recorded peak.
    """
    sums, base, buffers = meter.sums, scene.base, buffers_of(scene)
    integrate_contact(meter, v_end - v_start, t, wall_of(scene).damping, regime, scene)
    if meter.acceleration is not None:
        add_square(meter, t, buffers.absolute, buffers.rate)
    if meter.energies is not None:
        measure_vibration(meter, t, before, after, regime, scene)
    u_start = v_start + base_displacement(base, buffers.excitation, 0.0)
    u_end = v_end + base_displacement(base, buffers.excitation, t)
    sums[PEAK] = max(sums[PEAK], max(abs(u_start), abs(u_end)))
    sums[RELATIVE_PEAK] = max(sums[RELATIVE_PEAK], max(abs(v_start), abs(v_end)))
    if meter.acceleration is not None:
        # |u''| of a slipping mass under a record stays below the peak, as `longest_step` ensures
        if regime.sticks or not isinstance(base, RecordBase):
            _raise_acceleration(meter, t, before, regime, scene)


@kernel
def measure_vibration(
    meter: Meter, t: float, before: Vibration, after: Vibration, regime: CompliantRegime, scene: Scene
) -> None:
    """Add the vibration's contribution to the integrals of the slow motion over a long step.

    Notes
    -----
    Integration by parts gives ∫ p l·f dt = Σ (−1)ᵏ [p⁽ᵏ⁾ l·Λ⁻ᵏ⁻¹ f]. The sum is finite, because p is a polynomial. J =
    ∫ f fᵀ dt solves ΛJ + JΛᵀ = [f fᵀ].
    """
    sums, base, motion, buffers = meter.sums, scene.base, regime.motion, buffers_of(scene)
    rate, offset = buffers.rate, regime.offset
    squares = _squares(before, after, motion.rates)
    x, w, y_rate = form_of_x(motion), form_of_w(motion), form_of(Y_RATE, motion)
    transmitted = LinearForm(-(base.two_zeta * w.first + x.first), -(base.two_zeta * w.second + x.second))
    if regime.sticks:
        w = LinearForm(0.0, 0.0)
        transmitted = form_of_wall_force(motion, wall_of(scene))
    if has_force(base):  # the force does work on the moving mass
        sums[WORK_IN] += _by_parts(buffers.excitation, 0.0, w, t, before, after, regime, scene)
    else:
        rate_into(buffers.excitation, 0, rate)
        sums[WORK_IN] += _by_parts(rate, 0.0, transmitted, t, before, after, regime, scene)
    rate_into(buffers.y, 0, rate)
    cross = _by_parts(rate, 0.0, y_rate, t, before, after, regime, scene)
    sums[IMPACT_LOSS] += wall_of(scene).damping * (2.0 * cross + _own(y_rate, squares))
    if regime.sticks:
        return
    rate_into(buffers.relative, 0, rate)
    cross = _by_parts(rate, 0.0, w, t, before, after, regime, scene)
    sums[VISCOUS_LOSS] += base.two_zeta * (2.0 * cross + _own(w, squares))
    cross = _by_parts(buffers.absolute, offset, x, t, before, after, regime, scene)
    sums[SQUARE] += 2.0 * cross + _own(x, squares)
    if isinstance(base, RecordBase):
        cross = _by_parts(buffers.relative, offset, x, t, before, after, regime, scene)
        sums[RELATIVE_SQUARE] += 2.0 * cross + _own(x, squares)
    if meter.acceleration is not None:
        acceleration = _form_of_acceleration(regime, scene)
        acceleration_into(buffers.absolute, rate)
        cross = _by_parts(rate, 0.0, acceleration, t, before, after, regime, scene)
        sums[ACCELERATION_SQUARE] += 2.0 * cross + _own(acceleration, squares)


class _Squares(NamedTuple):
    """The elements of the symmetric matrix J."""

    first: float
    both: float
    second: float


@kernel
def _squares(before: Vibration, after: Vibration, rates: Floats) -> _Squares:
    """Return J = ∫ f fᵀ dt over a long step, from the vibration at the two ends of the step.

    Let Λ = [[a, b], [c, d]]. The vector j of the elements J₁₁, J₁₂ and J₂₂ is the solution of
    [[2a, 2b, 0], [c, a + d, b], [0, 2c, 2d]] j = [(f₁², f₁f₂, f₂²)].
    """
    first, second = before
    one, two = after
    a, b, c, d = rates[0], rates[1], rates[2], rates[3]
    q11 = one * one - first * first
    q12 = one * two - first * second
    q22 = two * two - second * second
    trace = a + d
    determinant = a * d - b * c
    bottom = 2.0 * trace * determinant
    return _Squares(
        ((determinant + d * d) * q11 - 2.0 * b * d * q12 + b * b * q22) / bottom,
        (-c * d * q11 + 2.0 * a * d * q12 - a * b * q22) / bottom,
        (c * c * q11 - 2.0 * a * c * q12 + (determinant + a * a) * q22) / bottom,
    )


@inlined
def _own(form: LinearForm, squares: _Squares) -> float:
    """Return ∫ (l·f)² dt for a linear form, from J."""
    return (
        form.first * form.first * squares.first
        + 2.0 * form.first * form.second * squares.both
        + form.second * form.second * squares.second
    )


@kernel
def _by_parts(
    polynomial: Floats,
    less: float,
    form: LinearForm,
    t: float,
    before: Vibration,
    after: Vibration,
    regime: CompliantRegime,
    scene: Scene,
) -> float:
    """Return ∫ (p − less) l·f dt over [0, t] for a polynomial p and a linear form."""
    inverse, scratch = regime.motion.inverse, buffers_of(scene).scratch
    l1, l2 = form
    first, second = before
    one, two = after
    for i in range(TERMS):
        scratch[i] = polynomial[i]
    scratch[0] -= less
    total = 0.0
    sign = 1.0
    for k in range(TERMS):
        first, second = inverse[0] * first + inverse[1] * second, inverse[2] * first + inverse[3] * second
        one, two = inverse[0] * one + inverse[1] * two, inverse[2] * one + inverse[3] * two
        term = value(scratch, t) * (l1 * one + l2 * two) - scratch[0] * (l1 * first + l2 * second)
        total += sign * term
        if k > 0 and abs(term) <= 1e-18 * abs(total):
            break
        sign = -sign
        for i in range(ORDER):
            scratch[i] = (i + 1) * scratch[i + 1]
        scratch[ORDER] = 0.0
    return total


@kernel
def _form_of_acceleration(regime: CompliantRegime, scene: Scene) -> LinearForm:
    """Linear form of the vibration's contribution to u''; 0 if friction holds the mass."""
    if regime.sticks:
        return LinearForm(0.0, 0.0)
    x, w = form_of_x(regime.motion), form_of_w(regime.motion)
    wall_force = form_of_wall_force(regime.motion, wall_of(scene))
    two_zeta = scene.base.two_zeta
    return LinearForm(
        -(two_zeta * w.first + x.first) - wall_force.first,
        -(two_zeta * w.second + x.second) - wall_force.second,
    )


@kernel
def _raise_acceleration(
    meter: Meter, t: float, vibration: Vibration, regime: CompliantRegime, scene: Scene
) -> None:
    """Raise the peak to the largest |u''| of a long step, for slow motion and vibration together.

    The length of the step does not depend on u'', so that measuring u'' does not change the motion. The step
    is divided into spans in which a polynomial represents the vibration. The search ends as soon as the slow
    motion and the envelope of the vibration exclude a higher |u''| in the rest of the step.
    """
    sums, motion, buffers = meter.sums, regime.motion, buffers_of(scene)
    slow, both, scratch = buffers.rate, buffers.start, buffers.scratch
    acceleration_into(buffers.absolute, slow)
    form = _form_of_acceleration(regime, scene)
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
