"""The motion in contact with a compliant wall: equations by Newton's law, polynomials and vibration by the exponential."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import expm
from tests.worker.forms import EPS, FIXED, both, in_form

from damperlab.worker.solver.motion.compliant_equations import compliant_equations, make_contact
from damperlab.worker.solver.motion.compliant_motion import (
    OF_ABSOLUTE,
    OF_RELATIVE,
    OF_WALL_FORCE,
    OF_Y,
    CompliantForcing,
    CompliantMotion,
    combine_rows,
)
from damperlab.worker.solver.motion.slow_subspace import (
    BASE_FIRST,
    CENTRE,
    CENTRE_RATE,
    DIM,
    Y_RATE,
    Y,
)
from damperlab.worker.solver.motion.taylor import TERMS, slope, value
from damperlab.worker.solver.motion.vibration import (
    form_of,
    form_of_w,
    form_of_wall_force,
    form_of_x,
    gain_of,
    size_of,
    subtract_vibration,
    value_of_form,
    vibration_after,
    vibration_at,
    vibration_of,
)
from damperlab.worker.solver.particle import Particle, Wall

Array = NDArray[np.float64]
R, TWO_ZETA, MASS_RATIO = 0.8, 0.1, 0.25
SHAKEN = CompliantForcing(TWO_ZETA, 0.3, 1.0, R, -R, R * R, 0.0, 1.0, R)
FORCED = CompliantForcing(TWO_ZETA, 0.3, 1.0, R, -R, 0.0, 1.0, 0.0, 0.0)
SOFT, STIFF, DAMPED = Wall(20.0, 1.0), Wall(1e6, 300.0), Wall(400.0, 3000.0)
anywhere = st.lists(st.floats(-1.0, 1.0), min_size=DIM, max_size=DIM).map(lambda c: np.round(c, 9))


@both
@pytest.mark.parametrize(
    ("forcing", "held"), [(SHAKEN, False), (FORCED, False), (SHAKEN, True)], ids=["shaken", "forced", "held"]
)
@FIXED
@given(c=anywhere)
def test_the_equations_are_newtons(form: str, held: bool, forcing: CompliantForcing, c: Array) -> None:
    """The wall's force is on both bodies, spring and dashpot on the structure, and friction moves it with its base if held."""
    mu = MASS_RATIO / (1.0 + MASS_RATIO)
    sine = c[BASE_FIRST]
    base_acceleration = 0.0 if forcing is FORCED else -R * R * sine
    wall_force = SOFT.stiffness * c[Y] + SOFT.damping * c[Y_RATE]
    x, w = c[CENTRE] + mu * c[Y], c[CENTRE_RATE] + mu * c[Y_RATE]
    force = sine if forcing is FORCED else 0.0
    u_acceleration = base_acceleration if held else force - (TWO_ZETA * w + x) - wall_force
    depth_acceleration = u_acceleration - wall_force / MASS_RATIO
    rates = in_form(compliant_equations, form)(forcing, MASS_RATIO, SOFT, held) @ c
    size = 1.0 + SOFT.stiffness + SOFT.damping
    assert abs(rates[Y_RATE] - depth_acceleration) <= 32 * EPS * size / MASS_RATIO
    assert rates[Y] == c[Y_RATE]
    if not held:
        centre_acceleration = u_acceleration - base_acceleration - mu * depth_acceleration
        # what the wall does to the two bodies cancels here, but for its rounding
        assert abs(rates[CENTRE_RATE] - centre_acceleration) <= 64 * EPS * size / MASS_RATIO
        assert rates[CENTRE] == c[CENTRE_RATE]


def motion_of(wall: Wall, held: bool) -> CompliantMotion:
    contact = make_contact(SHAKEN, Particle(1.0, 0.5, MASS_RATIO), wall)
    return contact.held if held else contact.slipping


@pytest.mark.parametrize(
    ("wall", "held"), [(SOFT, False), (STIFF, True), (DAMPED, False)], ids=["soft", "stiff", "damped"]
)
@FIXED
@given(start=anywhere)
def test_polynomials_are_the_exponential(wall: Wall, held: bool, start: Array) -> None:
    motion = motion_of(wall, held)
    t = motion.step
    at_start = start.copy()
    if held:
        at_start[CENTRE_RATE] = 0.0  # friction holds the mass
    end = expm(compliant_equations(SHAKEN, MASS_RATIO, wall, held) * t) @ at_start
    found = np.empty((4, TERMS))
    for which in range(4):
        combine_rows(which, at_start, DIM, motion.rows, found[which])
    x = end[CENTRE] + motion.share * end[Y]
    w = end[CENTRE_RATE] + motion.share * end[Y_RATE]
    # the rate of y comes and goes over the step, many times what its place does
    rounding = 256 * EPS * max(1.0, 1.0 / t)
    assert value(found[OF_RELATIVE], t) == pytest.approx(x, abs=rounding)
    assert value(found[OF_ABSOLUTE], t) == pytest.approx(x + end[BASE_FIRST], abs=rounding)
    assert value(found[OF_Y], t) == pytest.approx(end[Y], abs=rounding)
    assert slope(found[OF_Y], t) == pytest.approx(end[Y_RATE], abs=rounding / t)
    if not held:
        assert slope(found[OF_RELATIVE], t) == pytest.approx(w, abs=rounding / t)
    force = wall.stiffness * end[Y] + wall.damping * end[Y_RATE]
    size = wall.stiffness + wall.damping / t
    assert value(found[OF_WALL_FORCE], t) == pytest.approx(force, abs=rounding * size)


@pytest.mark.parametrize(
    ("wall", "fast", "held"), [(STIFF, 2, True), (DAMPED, 1, False)], ids=["stiff", "damped"]
)
@FIXED
@given(start=anywhere, share=st.floats(0.1, 1.0))
def test_slow_motion_and_vibration_are_the_motion(
    wall: Wall, fast: int, held: bool, start: Array, share: float
) -> None:
    """However long the span: the slow one by its polynomials, the vibration by its own exponential."""
    motion = motion_of(wall, held)
    assert motion.fast == fast
    if held:
        start[CENTRE_RATE] = 0.0
    t = share * motion.slow_step
    end = expm(compliant_equations(SHAKEN, MASS_RATIO, wall, held) * t) @ start
    vibration = vibration_at(start, motion)
    assert vibration == pytest.approx(vibration_of(start, motion)[0], rel=8 * EPS, abs=1e4 * EPS)
    slow = start.copy()
    subtract_vibration(slow, vibration, motion)
    size = 1.0 + size_of(vibration, motion.weight)
    # nothing of the vibration is left but its rounding, which is known as such
    assert size_of(vibration_at(slow, motion), motion.weight) <= 64 * EPS * size * max(1.0, motion.weight)
    later = vibration_after(vibration, motion.rates, t)
    relative, depth = np.empty(TERMS), np.empty(TERMS)
    combine_rows(OF_RELATIVE, slow, DIM - motion.fast, motion.slow_rows, relative)
    combine_rows(OF_Y, slow, DIM - motion.fast, motion.slow_rows, depth)
    # the split is iterated to its last digits, and the powers of the slow matrix are summed up to 1/16!
    near = 1e-12 * size
    assert value(depth, t) + value_of_form(later, form_of(Y, motion)) == pytest.approx(end[Y], abs=near)
    x = end[CENTRE] + motion.share * end[Y]
    assert value(relative, t) + value_of_form(later, form_of_x(motion)) == pytest.approx(x, abs=near)
    if not held:
        w = end[CENTRE_RATE] + motion.share * end[Y_RATE]
        assert slope(relative, t) + value_of_form(later, form_of_w(motion)) == pytest.approx(w, abs=near)


@FIXED
@given(start=anywhere)
def test_the_walls_force_has_no_more_of_the_vibration_than_its_gain(start: Array) -> None:
    motion = motion_of(STIFF, False)
    vibration = vibration_at(start, motion)
    form = form_of_wall_force(motion, STIFF)
    depth, rate = form_of(Y, motion), form_of(Y_RATE, motion)
    force = STIFF.stiffness * value_of_form(vibration, depth) + STIFF.damping * value_of_form(vibration, rate)
    most = gain_of(form, motion.weight) * size_of(vibration, motion.weight)
    assert value_of_form(vibration, form) == pytest.approx(force, abs=64 * EPS * most)
    assert abs(force) <= most * (1.0 + 64 * EPS)
