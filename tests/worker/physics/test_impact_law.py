"""The impact law: momentum, restitution and energy, for any velocities."""

from hypothesis import given
from hypothesis import strategies as st
from tests.worker.forms import EPS, FIXED, both, in_form

from damperlab.worker.physics.impact import impact_loss, kept_energy, part, rebound

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
@given(u=speeds, p=speeds, e=restitutions)
def test_a_particle_without_mass_changes_nothing(form: str, u: float, p: float, e: float) -> None:
    assert in_form(rebound, form)(u, p, e, 0.0)[0] == 0.0
