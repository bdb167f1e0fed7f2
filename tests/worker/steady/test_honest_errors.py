"""Stated standard errors of responses that do not repeat."""

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.benchmarks.coverage import compared

from damperlab.worker.steady.response.standard_errors import estimate, mean_and_error

POINTS, SEED, CYCLES = 40, 3, 60_000


@pytest.mark.night
def test_stated_intervals_hold_the_long_run_mean_about_as_often_as_they_say() -> None:
    """A short form of the benchmark `coverage`, of runs that stop where the default tolerance lets them.

    With nine of ten held, fewer than 31 of 40 come once in a hundred draws.
    """
    points = [one for one in compared(POINTS, SEED, CYCLES) if not one.repeats]
    assert len(points) >= 36
    assert sum(one.covered for one in points) >= 0.775 * len(points)
    # Nor are the errors inflated: of honest ones 32 % of the truths lie beyond one error.
    assert sum(abs(one.deviation) > 1.0 for one in points) >= 3


@pytest.mark.parametrize("correlation", [0.0, 0.8, 0.97])
def test_the_error_of_a_correlated_series_is_its_known_one(correlation: float) -> None:
    """First-order autoregression: variance of the mean (1 + ρ)/(1 − ρ)/N of the variance."""
    count, runs = 6600, 200  # at least the hundred correlation times that a run measures
    found = [mean_and_error(noise(count, correlation, seed), 0, count) for seed in range(runs)]
    held = sum(abs(mean - 1.0) <= 1.96 * error for mean, error in found)
    errors = [error for _, error in found]
    known = np.sqrt((1.0 + correlation) / (1.0 - correlation) / count)
    # 1.03 by Student's t and the larger of two; batches of 1.6 correlation times see 0.85 of the variance, those of 5 most
    assert 0.9 * known <= np.mean(errors) <= 1.1 * known
    assert 0.92 * runs <= held <= 0.995 * runs


def test_a_period_that_divides_the_run_has_no_hidden_error() -> None:
    """Batches of whole periods would see none of the spread of a series that the run cuts off in a period."""
    series = np.where(np.arange(2048) % 34 == 0, 1.0, 0.0)
    mean, error = mean_and_error(series, 0, 2048)
    assert abs(mean - 1.0 / 34.0) <= 1.96 * error


def noise(count: int, correlation: float, seed: int) -> np.ndarray:
    """First-order autoregression about 1 with unit variance."""
    random = np.random.default_rng(seed)
    steps = random.standard_normal(count) * np.sqrt(1.0 - correlation**2)
    steps[0] = random.standard_normal()
    series: np.ndarray = lfilter([1.0], [1.0, -correlation], steps)
    return 1.0 + series


def test_the_correlation_time_of_an_autoregression_is_its_known_one() -> None:
    """(1 + ρ)/(1 − ρ) samples, by the square of the stated error."""
    found = [estimate(noise(6400, 0.8, seed), 0, 6400).correlation for seed in range(20)]
    assert np.mean(found) == pytest.approx(9.0, rel=0.15)


def test_a_transient_that_the_data_show_is_left_out_and_none_where_they_show_none() -> None:
    quiet = sum(estimate(noise(2048, 0.5, seed), 0, 2048).first > 0 for seed in range(50))
    assert quiet <= 5
    for seed in range(10):
        series = noise(2048, 0.5, seed)
        series[:320] += 4.0 * np.exp(-np.arange(320) / 100.0)
        found = estimate(series, 0, 2048)
        assert 64 <= found.first <= 640
        assert abs(found.mean - 1.0) <= 4.0 * found.error


def test_a_trend_is_no_noise_and_its_end_lies_within_the_stated_error() -> None:
    """A response that settles by e-fold in 3,000 samples, looked at over 2,048 of them."""
    series = 1.0 + 0.1 * np.exp(-np.arange(2048) / 3000.0) + 1e-4 * (noise(2048, 0.0, 1) - 1.0)
    found = estimate(series, 0, 2048)
    assert not found.stationary
    assert abs(found.mean - 1.0) <= 1.96 * found.error
    trends = sum(not estimate(noise(2048, 0.9, seed), 0, 2048).stationary for seed in range(100))
    assert trends <= 3  # three in a thousand by chance
