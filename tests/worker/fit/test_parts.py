"""The parts of a fit, each against what is known exactly of it."""

import numpy as np
import pytest

from damperlab.worker.fit.chain import draw
from damperlab.worker.fit.region import Region
from damperlab.worker.fit.spread import halton
from damperlab.worker.fit.surface import fit_surface, terms


def test_the_first_points_of_haltons_sequence_are_radical_inverses() -> None:
    expected = [[1 / 2, 1 / 3], [1 / 4, 2 / 3], [3 / 4, 1 / 9], [1 / 8, 4 / 9], [5 / 8, 7 / 9]]
    assert np.allclose(halton(5, 2), expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("dimensions", [1, 2, 3, 4, 5])
def test_they_fill_every_half_of_a_box_evenly(dimensions: int) -> None:
    points = halton(480, dimensions)
    assert points.min() > 0
    assert points.max() < 1
    # In base b a half of 480 points holds half of them but for at most log_b(480) + 1 ≤ 10.
    assert np.abs((points < 0.5).sum(axis=0) - 240).max() <= 10


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
    draws = draw(density, walkers, 4000, seed=4)
    assert draws.shape == (48 * 2000, 2)
    # The moves are correlated over some 30 steps: 96,000 draws are worth 3,000, so a mean is known to 0.02 and a
    # variance to 2.6 %; five standard errors of each.
    assert np.abs(draws.mean(axis=0)).max() < 0.1
    assert np.allclose(np.cov(draws.T), covariance, rtol=0, atol=0.13)
    assert np.array_equal(draws, draw(density, walkers, 4000, seed=4))


def test_draws_keep_to_where_there_is_density() -> None:
    def density(places: np.ndarray) -> np.ndarray:
        inside = ((places >= 0) & (places <= 1)).all(axis=1)
        return np.where(inside, 0.0, -np.inf)

    draws = draw(density, np.random.default_rng(5).random((48, 3)), 2000, seed=6)
    assert draws.min() >= 0
    assert draws.max() <= 1
    assert np.allclose(draws.mean(axis=0), 0.5, rtol=0, atol=5 * np.sqrt(1 / 12 / 1600))
