"""Arithmetic that has the same bits on every processor."""

import math
from collections.abc import Callable

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from damperlab.studies import portable

ULP = float(np.finfo(float).eps)

FUNCTIONS: dict[str, tuple[Callable[..., np.ndarray], Callable[..., mpmath.mpf]]] = {
    name: (getattr(portable, name), getattr(mpmath, name))
    for name in ("exp", "expm1", "log", "log1p", "sin", "cos")
}


@pytest.mark.parametrize("name", FUNCTIONS)
@given(st.lists(st.floats(1e-300, 700.0), min_size=1, max_size=5))
def test_a_function_of_each_element_is_that_of_exact_arithmetic(name: str, x: list[float]) -> None:
    ours, exact = FUNCTIONS[name]
    with mpmath.workdps(360):
        expected = [float(exact(each)) for each in x]
    # a C library's last digit may be the next one
    assert ours(x) == pytest.approx(expected, rel=ULP, abs=0.0)


def test_what_a_function_does_where_there_is_no_number() -> None:
    assert portable.log([0.0, -0.0]).tolist() == [-math.inf] * 2
    assert np.isnan(portable.log([-1.0, math.nan])).all()
    assert portable.log([math.inf]).tolist() == [math.inf]
    assert np.isnan(portable.exp([math.nan])).all()
    assert portable.exp([-1e300, -math.inf]).tolist() == [0.0, 0.0]
    with pytest.raises(OverflowError):
        portable.exp([710.0])


def test_shapes_are_kept() -> None:
    for shape in ((), (0,), (2, 0), (3,), (2, 3)):
        x = np.ones(shape)
        assert portable.exp(x).shape == portable.power(x, 0.5).shape == shape
    assert portable.power(2.0, np.array([[0.5], [3.0]])).tolist() == [[math.sqrt(2.0)], [8.0]]
    assert portable.power(np.array([4.0, 9.0]), np.array([0.5, 2.0])).tolist() == [2.0, 81.0]


@given(st.integers(1, 40), st.integers(1, 40), st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_a_product_is_the_sum_of_products(rows: int, inner: int, columns: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = rng.standard_normal((rows, inner)), rng.standard_normal((inner, columns))
    exact = [[math.fsum(a[i] * b[:, j]) for j in range(columns)] for i in range(rows)]
    # each of the products and sums is off by half a unit of what there is to sum at most
    bound = (inner + 1) * ULP * (np.abs(a) @ np.abs(b))
    assert (np.abs(portable.product(a, b) - exact) <= bound).all()
    assert (np.abs(portable.product(a, b[:, 0]) - np.array(exact)[:, 0]) <= bound[:, 0]).all()
    assert (np.abs(portable.product(a[0], b) - exact[0]) <= bound[0]).all()


@given(st.integers(2, 400), st.integers(1, 120), st.booleans(), st.integers(0, 2**32 - 1))
def test_equal_rows_have_equal_sums_wherever_they_stand(
    rows: int, inner: int, by_columns: bool, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    weights = rng.random(inner)
    same = np.tile(rng.random(inner), (rows, 1))
    found = portable.product(np.asfortranarray(same) if by_columns else same, weights)
    assert set(found.tolist()) == {float(found[0])}
