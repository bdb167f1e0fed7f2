"""Slow and fast parts of the motion in contact: an invariant subspace, and the exponential of the rest."""

import mpmath
import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from tests.worker.forms import EPS, FIXED, both, in_form

from damperlab.worker.solver.motion.slow_subspace import DIM, contact_rates, split
from damperlab.worker.solver.motion.vibration import Vibration, vibration_after


@both
@FIXED
@given(square=st.floats(1e-3, 1e9), damping=st.floats(0, 1e5))
def test_contact_rates_are_the_moduli_of_the_roots(form: str, square: float, damping: float) -> None:
    larger, smaller = in_form(contact_rates, form)(square, damping)
    with mpmath.workdps(60):
        root = mpmath.sqrt(mpmath.mpc(mpmath.mpf(damping) ** 2 / 4 - mpmath.mpf(square)))
        expected = sorted((abs(mpmath.mpf(damping) / 2 + root), abs(mpmath.mpf(damping) / 2 - root)))
    # next to critical damping the difference under the root has lost its digits, and the root halves what is left
    spread = 8 * float(np.sqrt(EPS)) if abs(damping * damping / 4 - square) < 1e-6 * square else 1e-8
    assert abs(larger / expected[1] - 1) <= spread
    assert abs(smaller / expected[0] - 1) <= spread
    assert abs(larger * smaller / square - 1) <= 8 * EPS


@both
@FIXED
@given(
    a=st.floats(-3, -0.1), d=st.floats(-3, -0.1), b=st.floats(-2, 2), c=st.floats(-2, 2), t=st.floats(0, 3)
)
def test_the_fast_motion_later_is_the_matrix_exponential(
    form: str, a: float, b: float, c: float, d: float, t: float
) -> None:
    one, two = in_form(vibration_after, form)(Vibration(0.7, -0.4), np.array([a, b, c, d]), t)
    with mpmath.workdps(40):
        after = mpmath.expm(mpmath.matrix([[a, b], [c, d]]) * t) * mpmath.matrix([0.7, -0.4])
        size = float(mpmath.norm(mpmath.expm(mpmath.matrix([[a, abs(b)], [abs(c), d]]) * t), mpmath.inf))
    # near a double root even and odd parts are a series of relative error (spread t)⁴/120 < 1e-18, else rounding
    # is enlarged by 1/(spread t) < 1e4 where the two exponentials are subtracted
    assert abs(one - float(after[0])) <= 1e4 * 16 * EPS * (1 + size)
    assert abs(two - float(after[1])) <= 1e4 * 16 * EPS * (1 + size)


@FIXED
@given(
    stiffness=st.floats(1e4, 1e8),
    share=st.floats(0.01, 0.7),
    slow=st.lists(st.floats(-1, 1), min_size=16, max_size=16),
)
def test_the_slow_part_is_an_invariant_subspace(stiffness: float, share: float, slow: list[float]) -> None:
    rate = np.sqrt(stiffness)
    a = np.zeros((DIM, DIM))
    a[:4, :4] = np.reshape(slow, (4, 4))
    a[1, 4], a[5, 0], a[4, 5] = -0.1, -1.0, 1.0
    a[5, 4], a[5, 5] = -stiffness, -2 * share * rate
    p, b, rates, inverse, converged = split(a, 2)
    assert converged
    # what moves in the subspace φ = Pσ stays in it: a [I; P] = [I; P] (A + A' P)
    lifted = np.vstack((np.eye(4), p))
    generator = a[:4, :4] + a[:4, 4:] @ p
    size = 64 * EPS * np.abs(a) @ np.abs(lifted)
    assert (np.abs(a @ lifted - lifted @ generator) <= size + 64 * EPS).all()
    # a product of matrices, and an inverse by cofactors: rounding in proportion to what is added up
    crossed = np.abs(rates[0, 0] * rates[1, 1]) + np.abs(rates[0, 1] * rates[1, 0])
    lost = crossed / np.abs(rates[0, 0] * rates[1, 1] - rates[0, 1] * rates[1, 0])
    assert (np.abs(rates @ inverse - np.eye(2)) <= 16 * EPS * lost * (np.abs(rates) @ np.abs(inverse))).all()
    # and f = φ − Pσ moves by F alone
    reader = np.hstack((-p, np.eye(2)))
    left, right = reader @ a, rates @ reader
    assert (
        np.abs(left - right) <= 64 * EPS * (np.abs(reader) @ np.abs(a) + np.abs(rates) @ np.abs(reader))
    ).all()
    assert b.shape == (4, 2)
