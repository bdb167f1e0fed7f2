"""The parts of a fit, each against what is known exactly of it."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from damperlab.worker.fit.chain import draw
from damperlab.worker.fit.region import Region
from damperlab.worker.fit.singular_values import (
    covariance_of,
    inverse,
    length_of,
    principal,
    singular_values,
)
from damperlab.worker.fit.surface import fit_surface, terms


def test_a_polynomial_of_second_degree_is_found_exactly_wherever_its_frame_lies() -> None:
    rng = np.random.default_rng(1)
    places = rng.random((40, 3))
    x, y, z = places.T
    truth = np.stack([1 + 2 * x - y * z, 3 * z**2 + x * y], axis=1)
    frame = np.linalg.cholesky(np.array([[0.04, 0.01, 0], [0.01, 0.02, 0.005], [0, 0.005, 0.01]]))
    surface = fit_surface(Region(np.array([0.3, 0.6, 0.4]), frame), places, truth)
    elsewhere = rng.random((10, 3))
    x, y, z = elsewhere.T
    expected = np.stack([1 + 2 * x - y * z, 3 * z**2 + x * y], axis=1)
    assert np.allclose(surface.at(elsewhere), expected, rtol=0, atol=1e-10)
    assert surface.scatter.max() < 1e-10
    assert terms(3) == 10


def test_scatter_is_the_standard_deviation_of_what_jumps_and_failures_are_left_out() -> None:
    rng = np.random.default_rng(2)
    places = rng.random((2000, 1))
    smooth = places[:, 0] ** 2
    noisy = smooth + 0.1 * rng.standard_normal(2000)
    failing = np.where(places[:, 0] > 0.9, np.nan, smooth)
    lost = np.where(places[:, 0] > 0.2, np.nan, smooth)
    surface = fit_surface(Region(np.array([0.5]), np.eye(1)), places, np.stack([noisy, failing, lost], 1))
    # The standard error of a standard deviation from 2000 values is 1/√4000 of it; five of them.
    assert surface.scatter[0] == pytest.approx(0.1, rel=5 / np.sqrt(4000))
    assert surface.scatter[1] < 1e-12
    assert surface.at(np.array([[0.95]]))[0, 1] == pytest.approx(0.95**2, rel=1e-9)
    assert np.isinf(surface.scatter[2])


def test_draws_have_the_mean_and_covariance_of_their_density_however_correlated() -> None:
    covariance = np.array([[1.0, 0.99], [0.99, 1.0]])
    inverse = np.linalg.inv(covariance)

    def density(places: np.ndarray) -> np.ndarray:
        return np.asarray(-0.5 * np.einsum("ni,ij,nj->n", places, inverse, places))

    walkers = np.random.default_rng(3).standard_normal((48, 2))
    draws = draw(density, walkers, 2000, seed=4)
    assert draws.shape == (48 * 1000, 2)
    # The moves are correlated over some 30 steps: 48,000 draws are worth 1,600, so a mean is known to 0.025 and a
    # variance to 3.5 %; five standard errors of each.
    assert np.abs(draws.mean(axis=0)).max() < 0.125
    assert np.allclose(np.cov(draws.T), covariance, rtol=0, atol=0.175)
    assert np.array_equal(draw(density, walkers, 20, seed=4), draw(density, walkers, 20, seed=4))


def test_draws_keep_to_where_there_is_density() -> None:
    def density(places: np.ndarray) -> np.ndarray:
        inside = ((places >= 0) & (places <= 1)).all(axis=1)
        return np.where(inside, 0.0, -np.inf)

    draws = draw(density, np.random.default_rng(5).random((48, 3)), 1000, seed=6)
    assert draws.min() >= 0
    assert draws.max() <= 1
    assert np.allclose(draws.mean(axis=0), 0.5, rtol=0, atol=5 * np.sqrt(1 / 12 / 800))


ULP = float(np.finfo(float).eps)


@st.composite
def matrices(draw: st.DrawFn) -> np.ndarray:
    """Tall and wide ones, of columns that are longer or shorter by far, equal or 0."""
    rows, columns = draw(st.integers(1, 60)), draw(st.integers(1, 9))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    matrix = rng.standard_normal((rows, columns)) * 10.0 ** rng.uniform(-8.0, 8.0, columns)
    if draw(st.booleans()):
        matrix[:, -1] = matrix[:, 0]
    if draw(st.booleans()):
        matrix[:, columns // 2] = 0.0
    if draw(st.booleans()):
        matrix = matrix @ rng.standard_normal((columns, columns))
    return matrix


def rounding(matrix: np.ndarray) -> float:
    """Two roundings of each element of a row or column in each of some ten sweeps, over the largest singular value."""
    return float(20.0 * max(matrix.shape) * ULP * np.sqrt((matrix**2).sum()))


@given(matrices())
def test_the_parts_make_the_matrix_and_are_orthogonal(matrix: np.ndarray) -> None:
    found = singular_values(matrix)
    assert (np.diff(found.values) <= 0.0).all()
    assert (found.values >= 0.0).all()
    assert np.abs(found.left * found.values @ found.right.T - matrix).max() <= rounding(matrix)
    count = matrix.shape[1]
    assert np.abs(found.right.T @ found.right - np.eye(count)).max() <= 40.0 * count * ULP
    kept = found.left[:, : found.rank(1e-12)]
    assert np.abs(kept.T @ kept - np.eye(kept.shape[1])).max(initial=0.0) <= 20.0 * max(matrix.shape) * ULP


def test_small_values_are_found_as_far_as_the_condition_lets() -> None:
    size = 4
    hilbert = np.array([[1.0 / (i + j + 1) for j in range(size)] for i in range(size)])
    with mpmath.workdps(60):
        exact = mpmath.svd_r(mpmath.matrix(hilbert.tolist()), compute_uv=False)
        expected = [float(each) for each in exact]
    assert singular_values(hilbert).values == pytest.approx(expected, rel=1.6e4 * ULP)  # its condition


@given(matrices(), st.integers(0, 2**32 - 1))
def test_what_is_left_by_a_least_square_is_orthogonal_to_every_column(matrix: np.ndarray, seed: int) -> None:
    known = np.random.default_rng(seed).standard_normal((len(matrix), 2))
    found = singular_values(matrix)
    x = found.solve(known, 1e-10)
    across = np.abs(found.left[:, : found.rank(1e-10)].T @ (known - matrix @ x))
    # in exact arithmetic 0; x is as long as the matrix is close to a lower rank
    longest = float(np.sqrt((x**2).sum()))
    assert across.max(initial=0.0) <= rounding(matrix) * longest + rounding(known)
    alone = found.solve(np.ascontiguousarray(known[:, 0]), 1e-10)
    assert np.abs(alone - x[:, 0]).max(initial=0.0) <= 1e10 * rounding(np.atleast_2d(x))


def test_of_many_solutions_the_shortest_is_given() -> None:
    matrix = np.array([[1.0, 1.0], [1.0, 1.0]])
    assert singular_values(matrix).rank(1e-10) == 1
    assert singular_values(matrix).solve(np.array([2.0, 2.0]), 1e-10) == pytest.approx([1.0, 1.0])
    nothing = singular_values(np.zeros((3, 2)))
    assert nothing.rank(1e-10) == 0
    assert nothing.solve(np.ones(3)).tolist() == [0.0, 0.0]


def test_an_inverse_and_principal_directions() -> None:
    turned = np.array([[0.8, -0.6], [0.6, 0.8]])
    covariance = turned @ np.diag([4.0, 0.25]) @ turned.T
    assert inverse(covariance) @ covariance == pytest.approx(np.eye(2), abs=1e-14)
    variances, directions = principal(covariance)
    assert variances == pytest.approx([0.25, 4.0])
    assert np.abs(directions.T @ turned[:, ::-1]) == pytest.approx(np.eye(2), abs=1e-14)


def test_a_covariance_is_that_of_numpy_and_a_length_that_of_pythagoras() -> None:
    places = np.random.default_rng(3).standard_normal((50, 3))
    assert covariance_of(places) == pytest.approx(np.cov(places.T), rel=1e-13)
    assert covariance_of(places[:, :1]) == pytest.approx(np.cov(places[:, :1].T).reshape(1, 1), rel=1e-13)
    assert length_of(np.array([[3.0, 4.0], [0.0, 0.0]])).tolist() == [5.0, 0.0]
    assert float(length_of(np.array([5.0, 12.0]))) == 13.0


@pytest.mark.parametrize("matrix", [[[np.nan]], [[np.inf], [1.0]], [[np.nan, 1.0], [1.0, 2.0]]])
def test_a_matrix_that_is_not_finite_has_none(matrix: list[list[float]]) -> None:
    with pytest.raises(ArithmeticError, match="not finite"):
        singular_values(np.array(matrix))
