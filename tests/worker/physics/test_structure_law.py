"""The structure alone, against the complex frequency response."""

from math import inf

import mpmath
from hypothesis import given
from hypothesis import strategies as st
from tests.worker.forms import EPS, FIXED, both, in_form

from damperlab.worker.physics.structure import relative_transmissibility, transmissibility


@both
@FIXED
@given(damping=st.floats(1e-6, 2.0), r=st.floats(1e-3, 1e3))
def test_transmissibility_is_that_of_the_complex_response(form: str, damping: float, r: float) -> None:
    with mpmath.workdps(40):
        loss = 2 * mpmath.mpf(damping) * r
        below = mpmath.mpc(1 - mpmath.mpf(r) ** 2, loss)
        absolute, relative = abs(mpmath.mpc(1, loss) / below), mpmath.mpf(r) ** 2 / abs(below)
    assert abs(in_form(transmissibility, form)(damping, r) / absolute - 1) <= 8 * EPS
    assert abs(in_form(relative_transmissibility, form)(damping, r) / relative - 1) <= 8 * EPS


@both
def test_without_damping_resonance_has_no_bound(form: str) -> None:
    assert in_form(transmissibility, form)(0.0, 1.0) == inf
    assert in_form(relative_transmissibility, form)(0.0, 1.0) == inf
