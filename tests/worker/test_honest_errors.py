"""Stated standard errors of responses that do not repeat."""

import numpy as np
import pytest
from tests.benchmarks.coverage import compared

from damperlab.worker.steady.statistics import mean_and_error

POINTS, SEED, TIMES = 40, 3, 15


def test_stated_intervals_hold_the_long_run_mean_about_as_often_as_they_say() -> None:
    """A short form of the benchmark `coverage`: with nine of ten held, fewer than 31 of 40 come once in a hundred draws."""
    points = list(compared(POINTS, SEED, TIMES))
    assert sum(one.covered for one in points) >= 31
    # Nor are the errors inflated: of honest ones 32 % of the truths lie beyond one error.
    assert sum(abs(one.deviation) > 1.0 for one in points) >= 3


@pytest.mark.parametrize("correlation", [0.0, 0.8, 0.97])
def test_the_error_of_a_correlated_series_is_its_known_one(correlation: float) -> None:
    """First-order autoregression: variance of the mean (1 + ρ)/(1 − ρ)/N of the variance."""
    random = np.random.default_rng(11)
    count, runs = 3200, 200
    held = 0
    errors = []
    for _ in range(runs):
        noise = random.standard_normal(count) * np.sqrt(1.0 - correlation**2)
        series = np.empty(count)
        series[0] = random.standard_normal()
        for i in range(1, count):
            series[i] = correlation * series[i - 1] + noise[i]
        mean, error = mean_and_error(series, 0, count)
        held += abs(mean) <= 1.96 * error
        errors.append(error)
    known = np.sqrt((1.0 + correlation) / (1.0 - correlation) / count)
    assert np.mean(errors) == pytest.approx(1.15 * known, rel=0.2)  # the largest of three, with Student's t
    assert 0.92 * runs <= held <= 0.995 * runs


def test_a_period_that_divides_the_run_has_no_hidden_error() -> None:
    """Batches of whole periods would see none of the spread of a series that the run cuts off in a period."""
    series = np.where(np.arange(2048) % 34 == 0, 1.0, 0.0)
    mean, error = mean_and_error(series, 0, 2048)
    assert abs(mean - 1.0 / 34.0) <= 1.96 * error
