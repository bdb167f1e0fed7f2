"""The excitation of the structure: a base shaken by a sine or by a record, or a sinusoidal force on the structure.

The integrator accesses the excitation only through the functions of this module. The compiler keeps only the
branch for a record or for a sine. A `Sine` is a shaken base or a force, depending on its amplitudes. Products
with 1 and sums with 0 are exact, so the zero force does not change even the last bit of the motion on a
shaken base.
"""

from typing import NamedTuple

from damperlab.worker.jit import inlined
from damperlab.worker.physics.friction import hold_force
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.excitation.record_base import RecordBase
from damperlab.worker.solver.excitation.sine import Sine
from damperlab.worker.solver.motion.compliant_motion import CompliantForcing
from damperlab.worker.solver.motion.taylor import TERMS, slope, value
from damperlab.worker.solver.state import State, mirrored

Excitation = Sine | RecordBase


class Phase(NamedTuple):
    """The excitation at one instant.

    Attributes
    ----------
    first, second : float
        Factors of the two rows of Taylor coefficients: sin φ and cos φ, or s'' and s''' of a record.
    position, rate : float
        s and s'; 0 under a force.
    inertia_force : float
        −s'', the inertial force on a unit mass that moves with the base; 0 under a force.
    force : float
        The exciting force on the structure; 0 on a shaken base.
    most : float
        Bound on |s''| until the end of the panel.
    """

    first: float
    second: float
    position: float
    rate: float
    inertia_force: float
    force: float
    most: float


@inlined
def phase_of_sine(base: Sine, sine: float, cosine: float) -> Phase:
    """Harmonic excitation at the instant with the given sine and cosine of the phase angle."""
    position, rate, most = base.displacement * sine, base.velocity * cosine, base.acceleration
    return Phase(sine, cosine, position, rate, most * sine, base.force * sine, most)


@inlined
def phase_at(base: Excitation, k: int) -> Phase:
    """Excitation at the start of panel k."""
    if isinstance(base, RecordBase):
        return _phase_of_record(
            base.acceleration[k], base.jerk[k], base.position[k], base.rate[k], base.most[k]
        )
    return phase_of_sine(base, base.sine[k], base.cosine[k])


@inlined
def phase_until(base: Excitation, k: int) -> Phase:
    """Excitation at the end of panel k. If s'' of a record jumps there, the limit from within the panel is used."""
    if isinstance(base, RecordBase):
        acceleration = base.acceleration[k] + base.jerk[k] * base.window
        return _phase_of_record(
            acceleration, base.jerk[k], base.position[k + 1], base.rate[k + 1], base.most[k]
        )
    return phase_of_sine(base, base.sine[k + 1], base.cosine[k + 1])


@inlined
def phase_after(base: Excitation, phase: Phase, excitation: Floats, t: float) -> Phase:
    """Excitation at a time t after `phase` in the same panel, from the polynomial of `expand_excitation`."""
    at, rate = value(excitation, t), slope(excitation, t)
    if isinstance(base, RecordBase):
        return _phase_of_record(phase.first + phase.second * t, phase.second, at, rate, phase.most)
    return phase_of_sine(base, at, rate / base.frequency_ratio)


@inlined
def _phase_of_record(acceleration: float, jerk: float, position: float, rate: float, most: float) -> Phase:
    return Phase(acceleration, jerk, position, rate, -acceleration, 0.0, most)


@inlined
def base_displacement(base: Excitation, excitation: Floats, t: float) -> float:
    """Displacement s of the base, from the polynomial of `expand_excitation`; 0 under a force."""
    if isinstance(base, RecordBase):
        return value(excitation, t)
    return base.displacement * value(excitation, t)


@inlined
def base_velocity(base: Excitation, excitation: Floats, t: float) -> float:
    """Velocity s' of the base, from the polynomial of `expand_excitation`; 0 under a force."""
    if isinstance(base, RecordBase):
        return slope(excitation, t)
    return base.displacement * slope(excitation, t)


@inlined
def expand_base(base: Excitation, phase: Phase, out: Floats) -> None:
    """Write the Taylor coefficients of the base displacement s, about the time of `phase`."""
    expand_excitation(base, phase, out)
    if isinstance(base, Sine):
        for n in range(TERMS):
            out[n] = base.displacement * out[n]


@inlined
def expand_excitation(base: Excitation, phase: Phase, out: Floats) -> None:
    """Write the Taylor coefficients of the base displacement s, or of the force, about the time of `phase`."""
    for n in range(TERMS):
        out[n] = phase.first * base.rows[n] + phase.second * base.rows[TERMS + n]
    if isinstance(base, RecordBase):
        out[0] = phase.position
        out[1] = phase.rate


@inlined
def add_start_of_base(base: Excitation, phase: Phase, out: Floats) -> None:
    """Under a record, add the position and velocity of the base to the coefficients of x + s."""
    if isinstance(base, RecordBase):
        out[0] += phase.position
        out[1] += phase.rate


@inlined
def travel(base: Excitation, phase: Phase, end: Phase) -> float:
    """Displacement of the base over a complete panel."""
    if isinstance(base, RecordBase):
        t = base.window  # a difference of positions would lose digits if the base is far from its start
        return (phase.rate + (phase.first / 2.0 + phase.second * t / 6.0) * t) * t
    return end.position - phase.position


@inlined
def expand_forcing(base: Excitation, phase: Phase, sign: float, inertia: float, out: Floats) -> None:
    """Write the Taylor coefficients of `sign` times the friction force that holds the mass.

    The friction force balances the spring force and, in addition, the inertial force on a shaken base or the
    exciting force. The constant part that balances the spring force is omitted.
    """
    if isinstance(base, RecordBase):
        factor = sign * inertia
        for n in range(TERMS):
            out[n] = 0.0
        out[0] = -factor * phase.first
        out[1] = -factor * phase.second
    else:
        scale = sign * largest_to_hold(base, inertia)
        for n in range(TERMS):
            out[n] = scale * (phase.first * base.rows[n] + phase.second * base.rows[TERMS + n])


@inlined
def base_derivative_bound(base: Excitation, phase: Phase, order: int) -> float:
    """Bound on the `order`-th derivative of s until the end of the panel, for `order` 2 to 5."""
    if isinstance(base, RecordBase):
        if order == 2:
            return phase.most
        if order == 3:
            return abs(phase.second)
        return 0.0
    return _times_power(base.acceleration, base.frequency_ratio, order - 2)


@inlined
def with_force_bound(bound: float, base: Excitation, order: int) -> float:
    """Return `bound` plus a bound on the `order`-th derivative of the exciting force, for `order` 0 to 3."""
    if isinstance(base, RecordBase):
        return bound
    return bound + _times_power(base.force, base.frequency_ratio, order)


@inlined
def _times_power(a: float, r: float, order: int) -> float:
    for _ in range(order):
        a *= r
    return a


@inlined
def forcing_derivative_bound(base: Excitation, phase: Phase, order: int, inertia: float) -> float:
    """Bound on the first or second derivative of the friction force that holds the mass."""
    return with_force_bound(inertia * base_derivative_bound(base, phase, order + 2), base, order)


@inlined
def force_to_hold(phase: Phase, v: float, inertia: float) -> float:
    """Friction force required to hold the mass on the base, divided by k Z."""
    return hold_force(v - phase.force, phase.inertia_force, inertia)


@inlined
def largest_forcing(base: Excitation) -> float:
    """Largest |s''|, or largest exciting force, of the complete motion; a reference for rounding errors of forces."""
    return largest_to_hold(base, 1.0)


@inlined
def largest_to_hold(base: Excitation, inertia: float) -> float:
    """Largest inertial force, or largest exciting force, that friction balances while it holds the mass."""
    if isinstance(base, RecordBase):
        return inertia * base.largest
    return inertia * base.acceleration + base.force


@inlined
def has_force(base: Excitation) -> bool:
    """Whether the excitation is a force on the structure, with the base at rest."""
    if isinstance(base, RecordBase):
        return False
    return base.force > 0.0


@inlined
def amplitudes(base: Excitation) -> tuple[float, float]:
    """Factors that convert the function expanded in `base.rows` into s, and into the force on the structure."""
    if isinstance(base, RecordBase):
        return 1.0, 0.0
    return base.displacement, base.force


@inlined
def contact_forcing(base: Excitation) -> CompliantForcing:
    """Data of the excitation for the motion in contact with a compliant wall."""
    if isinstance(base, RecordBase):
        return CompliantForcing(base.two_zeta, base.window, 1.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0)
    r = base.frequency_ratio
    inertia, force, position, velocity = base.acceleration, base.force, base.displacement, base.velocity
    return CompliantForcing(
        base.two_zeta, base.window, max(1.0, r), r, -r, inertia, force, position, velocity
    )


@inlined
def next_half_start(base: Excitation, state: State) -> State:
    """Return the state at the start of the next half cycle: mirrored, so that the phase is 0 again.

    Under a record, which has no half cycles, return the state unchanged.
    """
    if isinstance(base, RecordBase):
        return state
    return mirrored(state)
