"""Observables in contact with a compliant wall: energies, mean square and peaks, also over a long step.

Under a record the meter also has ∫v², ∫u''² and the largest |u''|, which is finite in contact. Under a harmonic
excitation the meter has ∫u''² and the largest |u''| on request (`measure_compliant_acceleration.py`).
"""

from typing import NamedTuple

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.compliant_regime import (
    AnyRegime,
    CompliantRegime,
    buffers_of,
    wall_of,
)
from damperlab.worker.solver.excitation.excitation import Excitation, base_displacement
from damperlab.worker.solver.excitation.record_base import RecordBase
from damperlab.worker.solver.excitation.sine_base import SineForce
from damperlab.worker.solver.motion.compliant_motion import Buffers
from damperlab.worker.solver.motion.slow_subspace import Y_RATE
from damperlab.worker.solver.motion.taylor import ORDER, TERMS, rate_into, slope, value
from damperlab.worker.solver.motion.vibration import (
    LinearForm,
    Vibration,
    form_of,
    form_of_w,
    form_of_wall_force,
    form_of_x,
)
from damperlab.worker.solver.observe.measure_compliant_acceleration import (
    acceleration_at,
    form_of_acceleration,
    largest,
    raise_acceleration_in_contact,
    raise_over_long_step,
    record_acceleration,
    slip_acceleration_into,
)
from damperlab.worker.solver.observe.meter import (
    ACCELERATION_SQUARE,
    FRICTION_LOSS,
    IMPACT_LOSS,
    PEAK,
    RELATIVE_PEAK,
    RELATIVE_SQUARE,
    SQUARE,
    STUCK,
    VISCOUS_LOSS,
    WORK_IN,
    Meter,
)
from damperlab.worker.solver.observe.quadrature import GAUSS, GAUSS_NODES, GAUSS_WEIGHTS
from damperlab.worker.solver.scene import Scene

LEAST_DECAY = 1e-9
"""Least |tr Λ| t of a long step. For smaller values, the integral J (`measure_vibration`) is inaccurate, because J is a
difference of two end values, divided by tr Λ.
"""


@inlined
def takes_integrals(meter: Meter) -> bool:
    """Whether a meter accumulates integrals in contact, for energies or for ∫u''²."""
    return meter.energies is not None or meter.acceleration is not None


@kernel
def measure_contact(
    meter: Meter, moved: float, t: float, damping: float, regime: AnyRegime, scene: Scene
) -> None:
    """Add a segment of length t to the integrals, from its polynomials; v changes by `moved` over the segment.

    `damping` is C while the wall pushes, and 0 after detachment.
    """
    sums, base, buffers = meter.sums, scene.base, buffers_of(scene)
    work = 0.0
    loss = 0.0
    mean_square = 0.0
    struck = 0.0
    relative_square = 0.0
    acceleration_square = 0.0
    for i in range(GAUSS):
        at = GAUSS_NODES[i] * t
        w = 0.0
        if regime.sticks:
            transmitted = _held_force(base, buffers, at)
        else:
            w = slope(buffers.relative, at)
            transmitted = -(base.two_zeta * w + value(buffers.relative, at))
        u = value(buffers.absolute, at) - regime.offset
        y_rate = slope(buffers.y, at)
        if isinstance(base, SineForce):
            work += GAUSS_WEIGHTS[i] * value(buffers.excitation, at) * w
        else:
            work += GAUSS_WEIGHTS[i] * transmitted * slope(buffers.excitation, at)
        loss += GAUSS_WEIGHTS[i] * w * w
        mean_square += GAUSS_WEIGHTS[i] * u * u
        struck += GAUSS_WEIGHTS[i] * y_rate * y_rate
        if isinstance(base, RecordBase):
            v = value(buffers.relative, at) - regime.offset
            relative_square += GAUSS_WEIGHTS[i] * v * v
        if meter.acceleration is not None:
            acceleration = acceleration_at(transmitted, at, regime, base, buffers)
            acceleration_square += GAUSS_WEIGHTS[i] * acceleration * acceleration
    if isinstance(base, RecordBase):
        sums[RELATIVE_SQUARE] += t * relative_square
    if meter.acceleration is not None:
        sums[ACCELERATION_SQUARE] += t * acceleration_square
    sums[WORK_IN] += t * work
    sums[VISCOUS_LOSS] += t * base.two_zeta * loss
    sums[SQUARE] += t * mean_square
    sums[IMPACT_LOSS] += t * damping * struck
    if scene.friction is not None:
        if regime.sticks:
            sums[STUCK] += t
        else:
            sums[FRICTION_LOSS] += scene.friction * abs(moved)  # w keeps its sign on a segment


@inlined
def _held_force(base: Excitation, buffers: Buffers, t: float) -> float:
    """Force of the base on a mass that friction holds during contact with a wall.

    Under an exciting force the result is 0, because neither the work nor u'' depends on this force.
    """
    if isinstance(base, RecordBase):
        return value(buffers.wall_force, t) + record_acceleration(buffers, t)
    if isinstance(base, SineForce):
        return 0.0
    square = base.frequency_ratio * base.frequency_ratio
    return value(buffers.wall_force, t) - square * value(buffers.excitation, t)


@kernel
def raise_peaks(meter: Meter, t: float, regime: AnyRegime, scene: Scene) -> None:
    """Raise the peaks of |u|, |v| and, on request, |u''| to the largest values of a segment, from its polynomials."""
    sums, offset, buffers = meter.sums, regime.offset, buffers_of(scene)
    sums[PEAK] = largest(buffers.absolute, offset, t, sums[PEAK], buffers.scratch)
    if scene.friction is None:
        sums[RELATIVE_PEAK] = largest(buffers.relative, offset, t, sums[RELATIVE_PEAK], buffers.scratch)
    else:  # with friction, |v| peaks only where a segment ends
        ends = max(abs(buffers.relative[0] - offset), abs(value(buffers.relative, t) - offset))
        sums[RELATIVE_PEAK] = max(sums[RELATIVE_PEAK], ends)
    if meter.acceleration is not None:
        raise_acceleration_in_contact(meter, t, regime, scene)


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
    """Add a long step of length t to all requested observables; inside the step, no displacement exceeds a peak."""
    sums, base, excitation = meter.sums, scene.base, buffers_of(scene).excitation
    if takes_integrals(meter):
        measure_contact(meter, v_end - v_start, t, wall_of(scene).damping, regime, scene)
        measure_vibration(meter, t, before, after, regime, scene)
    elif regime.sticks:
        sums[STUCK] += t
    u_start = v_start + base_displacement(base, excitation, 0.0)
    u_end = v_end + base_displacement(base, excitation, t)
    sums[PEAK] = max(sums[PEAK], max(abs(u_start), abs(u_end)))
    sums[RELATIVE_PEAK] = max(sums[RELATIVE_PEAK], max(abs(v_start), abs(v_end)))
    if meter.acceleration is not None:
        if not isinstance(base, RecordBase):
            raise_over_long_step(meter, t, before, regime, scene)
        elif regime.sticks:
            # |u''| of a slipping mass stays below the peak, as `longest_step` ensures
            raise_acceleration_in_contact(meter, t, regime, scene)


@kernel
def measure_vibration(
    meter: Meter, t: float, before: Vibration, after: Vibration, regime: CompliantRegime, scene: Scene
) -> None:
    """Add the vibration's contribution to the integrals of the slow motion over a long step.

    Notes
    -----
    Integrated by parts, ∫ p l·f dt is the series Σ (−1)ᵏ [p⁽ᵏ⁾ l·Λ⁻ᵏ⁻¹ f], which ends because p is a polynomial.
    J = ∫ f fᵀ dt solves ΛJ + JΛᵀ = [f fᵀ].
    """
    sums, base, motion, buffers = meter.sums, scene.base, regime.motion, buffers_of(scene)
    rate = buffers.rate
    squares = _squares(before, after, motion.rates)
    x, w, y_rate = form_of_x(motion), form_of_w(motion), form_of(Y_RATE, motion)
    transmitted = LinearForm(-(base.two_zeta * w.first + x.first), -(base.two_zeta * w.second + x.second))
    if regime.sticks:
        w = LinearForm(0.0, 0.0)
        transmitted = form_of_wall_force(motion, wall_of(scene))
    if isinstance(base, SineForce):  # the force does work as the mass moves
        for i in range(TERMS):
            rate[i] = buffers.excitation[i]
        sums[WORK_IN] += _by_parts(rate, w, t, before, after, regime, scene)
    else:
        rate_into(buffers.excitation, 0, rate)
        sums[WORK_IN] += _by_parts(rate, transmitted, t, before, after, regime, scene)
    rate_into(buffers.y, 0, rate)
    cross = _by_parts(rate, y_rate, t, before, after, regime, scene)
    sums[IMPACT_LOSS] += wall_of(scene).damping * (2.0 * cross + _own(y_rate, squares))
    if regime.sticks:
        return
    rate_into(buffers.relative, 0, rate)
    cross = _by_parts(rate, w, t, before, after, regime, scene)
    sums[VISCOUS_LOSS] += base.two_zeta * (2.0 * cross + _own(w, squares))
    for i in range(TERMS):
        rate[i] = buffers.absolute[i]
    rate[0] -= regime.offset
    cross = _by_parts(rate, x, t, before, after, regime, scene)
    sums[SQUARE] += 2.0 * cross + _own(x, squares)
    if isinstance(base, RecordBase):
        for i in range(TERMS):
            rate[i] = buffers.relative[i]
        rate[0] -= regime.offset
        cross = _by_parts(rate, x, t, before, after, regime, scene)
        sums[RELATIVE_SQUARE] += 2.0 * cross + _own(x, squares)
    if meter.acceleration is not None:
        acceleration = form_of_acceleration(regime, scene)
        slip_acceleration_into(base, buffers, rate)
        cross = _by_parts(rate, acceleration, t, before, after, regime, scene)
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
    form: LinearForm,
    t: float,
    before: Vibration,
    after: Vibration,
    regime: CompliantRegime,
    scene: Scene,
) -> float:
    """Return ∫ p l·f dt over [0, t] for a polynomial p and a linear form."""
    inverse, scratch = regime.motion.inverse, buffers_of(scene).scratch
    l1, l2 = form
    first, second = before
    one, two = after
    for i in range(TERMS):
        scratch[i] = polynomial[i]
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
