"""Coulomb friction at rest: the force that holds, and the direction in which the mass starts."""

from hypothesis import given
from hypothesis import strategies as st
from tests.worker.forms import EPS, FIXED, both, in_form

from damperlab.worker.physics.friction import breakaway, hold_force, slip_direction

numbers = st.floats(-1e3, 1e3)
ratios = st.floats(1e-3, 1e3)


@both
@FIXED
@given(v=numbers, acceleration=numbers, friction=ratios, inertia=st.floats(1.0, 11.0))
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
