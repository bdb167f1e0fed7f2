"""The first crossing: of polynomials whose roots are known, near grazing, and where there is none."""

from math import inf

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from tests.worker.forms import EPS, FIXED, both, in_form

from damperlab.worker.solver.motion.first_root import first_crossing
from damperlab.worker.solver.motion.taylor import TERMS, curvature_bound, rate_into, value
from damperlab.worker.solver.observe.peaks import raised

gaps = st.lists(st.floats(0.1, 0.4), min_size=1, max_size=3)


def padded(p: np.ndarray) -> np.ndarray:
    return np.concatenate((p, np.zeros(TERMS - p.size)))


def sizes(p: np.ndarray, t: float) -> float:
    return float(np.abs(p) @ t ** np.arange(TERMS))


@both
@FIXED
@given(gaps=gaps, sign=st.sampled_from([1.0, -1.0]))
def test_the_first_root_of_a_polynomial_with_known_roots(form: str, gaps: list[float], sign: float) -> None:
    roots = np.cumsum(gaps)
    p = padded(np.polynomial.polynomial.polyfromroots(roots))
    p *= sign * np.sign(p[0])  # sign · p is positive at 0
    found = in_form(first_crossing, form)(p, sign, 0.0, 1.25, curvature_bound(p, 1.25))
    steepness = abs(np.prod((roots[0] - roots)[1:]))
    # coefficients and value are rounded, which moves the root by their error over the slope; Newton ends at 1e-16 of t
    assert abs(found - roots[0]) <= 32 * EPS * sizes(p, roots[0]) / steepness + 4e-16


@both
@FIXED
@given(at=st.floats(0.05, 0.95), depth=st.floats(1e-12, 1e-2))
def test_a_grazing_touch_is_found_where_it_crosses_and_none_where_it_does_not(
    form: str, at: float, depth: float
) -> None:
    below = padded(np.array([at * at - depth, -2 * at, 1.0]))
    above = padded(np.array([at * at + depth, -2 * at, 1.0]))
    search = in_form(first_crossing, form)
    assert search(above, 1.0, 0.0, 1.0, 2.0) == inf
    found = search(below, 1.0, 0.0, 1.0, 2.0)
    if at * at > depth:
        half = np.sqrt(depth)
        assert abs(found - (at - half)) <= 16 * EPS / half + 4e-16
    else:
        assert found == 0.0  # negative from the start


@both
@FIXED
@given(exponent=st.floats(-14.0, -3.0), share=st.floats(0.01, 1.0))
def test_a_root_is_found_where_the_function_is_small_and_its_curvature_is_not_yet(
    form: str, exponent: float, share: float
) -> None:
    """The velocity of a mass that slips for a moment near the largest force: a t − t³/6, about a time when it is small."""
    a = 10.0**exponent
    root = np.sqrt(6.0 * a)
    t = share * 0.9 * root
    p = padded(np.array([a * t - t**3 / 6.0, a - 0.5 * t * t, -0.5 * t, -1.0 / 6.0]))
    found = in_form(first_crossing, form)(p, 1.0, 0.0, 0.4, 0.4)
    # the coefficients are rounded, of which the largest share is that of a t, over the slope of 2a; Newton ends at 1e-16 of t
    assert abs(found - (root - t)) <= 16 * EPS * root


@both
@FIXED
@given(at=st.floats(0.01, 0.99), start=st.floats(0.0, 0.9), span=st.floats(0.01, 0.1))
def test_a_root_counts_only_between_start_and_end(form: str, at: float, start: float, span: float) -> None:
    end = start + span
    p = padded(np.array([at, -1.0]))
    found = in_form(first_crossing, form)(p, 1.0, start, end, 0.0)
    if start < at < end:
        assert abs(found - at) <= 4 * EPS
    elif at > end:
        assert found == inf
    elif at < start and start == 0.0:
        assert found == 0.0


@both
@FIXED
@given(gaps=gaps)
def test_the_highest_extremum_inside_a_span(form: str, gaps: list[float]) -> None:
    turning = np.cumsum(gaps)
    p = padded(np.polynomial.polynomial.polyint(np.polynomial.polynomial.polyfromroots(turning)))
    rate = np.empty(TERMS)
    rate_into(p, 0, rate)
    inside = turning[turning < 1.0]
    expected = max((abs(value(p, t)) for t in inside), default=0.0)
    found = in_form(raised, form)(0.0, p, 0.0, rate, 1.0, curvature_bound(rate, 1.0))
    assert abs(found - expected) <= 32 * EPS * sizes(p, 1.0)
