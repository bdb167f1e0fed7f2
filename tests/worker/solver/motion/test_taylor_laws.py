"""Taylor polynomials in exact arithmetic, the motion that they expand against the matrix exponential, rules of quadrature."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from tests.worker.forms import EPS, FIXED, both, in_form

from damperlab.worker.solver.excitation.sine import make_sine
from damperlab.worker.solver.linear_motion import make_linear_motion
from damperlab.worker.solver.motion.quadratic_forms import NODES, WEIGHTS
from damperlab.worker.solver.motion.taylor import (
    LARGEST_WINDOW,
    TERMS,
    beyond_tangent,
    change,
    combine,
    curvature,
    curvature_bound,
    slope,
    value,
)
from damperlab.worker.solver.observe.energies import GAUSS_NODES, GAUSS_WEIGHTS

coefficients = st.lists(st.floats(-10.0, 10.0), min_size=TERMS, max_size=TERMS).map(np.array)
times = st.floats(0.0, 1.0)


def exact(p: NDArray[np.float64], t: float, derivative: int = 0, first: int = 0) -> tuple[float, float]:
    """A derivative from the term `first` on, and the sum of its terms' sizes."""
    with mpmath.workdps(60):
        terms = [
            mpmath.ff(n, derivative) * mpmath.mpf(float(p[n])) * mpmath.mpf(t) ** (n - derivative)
            for n in range(max(derivative, first), TERMS)
        ]
        return float(sum(terms)), float(sum(abs(term) for term in terms))


@both
@FIXED
@given(p=coefficients, t=times)
def test_values_and_derivatives_to_rounding(form: str, p: NDArray[np.float64], t: float) -> None:
    for function, derivative, first in (
        (value, 0, 0),
        (change, 0, 1),
        (beyond_tangent, 0, 2),
        (slope, 1, 1),
        (curvature, 2, 2),
    ):
        expected, size = exact(p, t, derivative, first)
        # each term passes through at most eight roundings of the tree, and of the powers of t
        assert abs(in_form(function, form)(p, t) - expected) <= 16 * EPS * size + 1e-300
    most = max(abs(exact(p, t * share, 2)[0]) for share in np.linspace(0, 1, 9))
    assert in_form(curvature_bound, form)(p, t) >= most * (1 - 16 * EPS)


@FIXED
@given(
    damping=st.floats(0.0, 1.0),
    r=st.floats(0.1, 10.0),
    inertia=st.floats(1.0, 2.0),
    x=st.floats(-1, 1),
    w=st.floats(-1, 1),
    phase=st.floats(0, 6.2),
)
def test_the_motion_of_a_panel_is_that_of_the_matrix_exponential(
    damping: float, r: float, inertia: float, x: float, w: float, phase: float
) -> None:
    base = make_sine(damping, r, None)
    motion = make_linear_motion(base, inertia, None)
    assert base.window * (1 + damping) * max(1.0, r) <= LARGEST_WINDOW * (1 + EPS)
    sine, cosine = np.sin(phase), np.cos(phase)
    with mpmath.workdps(40):
        k = 1 / mpmath.mpf(inertia)
        field = mpmath.matrix(
            [[0, 1, 0, 0], [-k, -k * base.two_zeta, mpmath.mpf(r) ** 2, 0], [0, 0, 0, r], [0, 0, -r, 0]]
        )
        after = mpmath.expm(field * base.window) * mpmath.matrix([x, w, sine, cosine])
        expected = [float(after[i]) for i in range(3)]
    # a dozen roundings of terms whose sizes are those of x, w and of what the base adds, at most r² h = 0.4 r
    size = 16 * EPS * (3.0 + r)
    moved_x = motion.xx * x + motion.xw * w + motion.xs * sine + motion.xc * cosine
    moved_w = motion.wx * x + motion.ww * w + motion.ws * sine + motion.wc * cosine
    assert abs(moved_x - expected[0]) <= size
    assert abs(moved_w - expected[1]) <= size
    curve = np.empty(TERMS)
    combine(x, w, sine, cosine, motion.absolute_rows, curve)
    assert abs(value(curve, base.window) - (expected[0] + expected[2])) <= size


@pytest.mark.parametrize(("nodes", "weights"), [(GAUSS_NODES, GAUSS_WEIGHTS), (NODES, WEIGHTS)])
def test_a_rule_is_that_of_exact_arithmetic_rounded_once(nodes: np.ndarray, weights: np.ndarray) -> None:
    with mpmath.workdps(50):

        def polynomial(x: mpmath.mpf) -> mpmath.mpf:
            return mpmath.legendre(nodes.size, x)

        roots = [mpmath.findroot(polynomial, 2 * mpmath.mpf(float(x)) - 1) for x in nodes]
        slopes = [mpmath.diff(polynomial, x) for x in roots]
        assert nodes.tolist() == [float((x + 1) / 2) for x in roots]
        expected = [float(1 / ((1 - x**2) * slope**2)) for x, slope in zip(roots, slopes, strict=True)]
    assert weights.tolist() == expected
