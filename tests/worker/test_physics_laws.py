"""The laws of physics, each in both of its forms: friction, impact and the compliant wall."""

from math import inf, pi

import mpmath
from hypothesis import example, given
from hypothesis import strategies as st
from tests.worker.forms import EPS, FIXED, both, in_form

from damperlab.worker.physics.compliant_wall import (
    calibrate,
    contact_time_of_stiffness,
    reduced_mass,
    spring_energy,
    wall_constants,
    wall_force,
)
from damperlab.worker.physics.friction import breakaway, hold_force, slip_direction
from damperlab.worker.physics.impact import impact_loss, kept_energy, part, rebound

numbers = st.floats(-1e3, 1e3)


@both
@FIXED
@given(v=numbers, acceleration=numbers, friction=st.floats(1e-3, 1e3), inertia=st.floats(1.0, 11.0))
def test_the_mass_starts_only_where_friction_is_too_small_and_with_the_force(
    form: str, v: float, acceleration: float, friction: float, inertia: float
) -> None:
    force = in_form(hold_force, form)(v, acceleration, inertia)
    # jitted, product and difference are rounded once
    assert abs(force - (inertia * acceleration - v)) <= EPS * (abs(inertia * acceleration) + abs(v))
    most = inertia * abs(acceleration)
    limit = in_form(breakaway, form)(friction, most)
    assert friction < limit <= friction + 2e-14 * (friction + most)
    slip = in_form(slip_direction, form)(force, limit)
    assert slip == (0.0 if abs(force) <= limit else (1.0 if force > 0.0 else -1.0))
    assert in_form(slip_direction, form)(-force, limit) == -slip


speeds = st.floats(-1e3, 1e3)
restitutions = st.floats(0.0, 1.0)
ratios = st.floats(0.0, 10.0)


@both
@FIXED
@given(u=speeds, p=speeds, e=restitutions, mass=ratios)
def test_rebound_keeps_momentum_and_reverses_the_approach(
    form: str, u: float, p: float, e: float, mass: float
) -> None:
    jump, after = in_form(rebound, form)(u, p, e, mass)
    size = 16.0 * EPS * (abs(u) + abs(p)) * (1.0 + mass)  # a handful of roundings of terms of this size
    assert abs(jump + mass * (after - p)) <= size
    assert abs((after - (u + jump)) - e * (u - p)) <= size


@both
@FIXED
@given(u=speeds, p=speeds, e=restitutions, mass=ratios)
def test_the_loss_is_the_kinetic_energy_that_is_gone(
    form: str, u: float, p: float, e: float, mass: float
) -> None:
    jump, after = in_form(rebound, form)(u, p, e, mass)
    before = 0.5 * (u * u + mass * p * p)
    left = 0.5 * ((u + jump) ** 2 + mass * after * after)
    loss = in_form(impact_loss, form)(u - p, e, mass)
    assert abs(before - left - loss) <= 64.0 * EPS * (1.0 + mass) * (abs(u) + abs(p)) ** 2


@both
@FIXED
@given(speed=speeds, e=restitutions, mass=ratios)
def test_joining_and_parting_is_one_rebound(form: str, speed: float, e: float, mass: float) -> None:
    jump, _ = in_form(rebound, form)(speed, 0.0, 0.0, mass)
    back, p_back = in_form(part, form)(e * speed, mass)
    whole, p_whole = in_form(rebound, form)(speed, 0.0, e, mass)
    size = 16.0 * EPS * abs(speed) * (1.0 + mass)
    assert abs(jump + back - whole) <= size
    assert abs((speed + jump) + p_back - p_whole) <= size
    kept = in_form(kept_energy, form)(speed, e, mass)
    everything = in_form(impact_loss, form)(speed, 0.0, mass)
    assert abs(kept + in_form(impact_loss, form)(speed, e, mass) - everything) <= 8.0 * EPS * everything


@both
@FIXED
@given(e=st.floats(0.01, 0.999), time=st.floats(1e-6, 10.0), mass=st.floats(1e-3, 10.0))
@example(e=0.1353352832366127, time=1.0, mass=0.1)  # e⁻², where the wall is critically damped
@example(e=0.05, time=1.0, mass=0.1)  # overdamped
@example(e=1e-3, time=1e-8, mass=0.1)
def test_a_free_impact_ends_after_the_contact_time_with_e_of_its_approach(
    form: str, e: float, time: float, mass: float
) -> None:
    stiffness, damping = in_form(wall_constants, form)(e, time, mass)
    rate, share = in_form(calibrate, form)(e, time)
    with mpmath.workdps(40):
        mu = mpmath.mpf(mass) / (1 + mpmath.mpf(mass))
        k, c = mpmath.mpf(stiffness) / mu, mpmath.mpf(damping) / mu
        # of the depth and its rate; in units of the contact time, so that all numbers are of order one
        moved = mpmath.expm(mpmath.matrix([[0, time], [-k * time, -c * time]])) * mpmath.matrix([0, 1])
        depth, depth_rate = moved[0], moved[1]
        force = (k * depth + c * depth_rate) * time
    # angle and constants are rounded to a few units, and e = exp(−2θ cot θ) passes the angle's error on thirtyfold
    assert abs(depth_rate + e) <= 1e-13
    assert abs(force) <= 1e-12
    assert abs(rate * rate * float(mu) / stiffness - 1) <= 1e-14
    assert abs(2 * share * rate * float(mu) / damping - 1) <= 1e-14
    back = in_form(contact_time_of_stiffness, form)(e, stiffness, mass)
    assert abs(back / time - 1) <= 1e-13


@both
def test_an_elastic_wall_is_half_a_period_of_its_spring(form: str) -> None:
    assert in_form(calibrate, form)(1.0, 0.25) == (pi / 0.25, 0.0)
    assert in_form(contact_time_of_stiffness, form)(1.0, 0.0, 0.1) == inf


@both
@FIXED
@given(k=st.floats(0, 1e6), c=st.floats(0, 1e3), depth=st.floats(-1, 1), rate=st.floats(-10, 10))
def test_a_wall_pushes_and_never_pulls(form: str, k: float, c: float, depth: float, rate: float) -> None:
    force = in_form(wall_force, form)(k, c, depth, rate)
    assert force >= 0.0
    if depth <= 0.0:
        assert force == 0.0
    # jitted, product and sum are rounded once
    elastic, viscous = k * depth, c * rate
    expected = max(elastic + viscous, 0.0) if depth > 0.0 else 0.0
    assert abs(force - expected) <= EPS * (abs(elastic) + abs(viscous))
    energy = in_form(spring_energy, form)(k, depth)
    assert abs(energy - 0.5 * k * max(depth, 0.0) ** 2) <= 2 * EPS * energy
    assert in_form(reduced_mass, form)(1.0) == 0.5
