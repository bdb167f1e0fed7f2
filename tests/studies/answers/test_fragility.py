"""A fragility curve is the distribution that its data were drawn from, and says what it cannot know."""

import math
from statistics import NormalDist

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import minimize
from scipy.special import chdtri, ndtr

from damperlab.studies.answers.fragility import WIDEST, bounds, fit_lognormal, fragility
from damperlab.studies.kinds import SUITE
from damperlab.studies.questions import Fragile

SCALES = np.array([0.5, 1.0, 2.0, 4.0])


def suite_of(values: np.ndarray, status: np.ndarray | int = 0, scales: np.ndarray = SCALES) -> xr.Dataset:
    """Values (record, scale) of one damper, and how its runs ended."""
    shape = [1] * len(SUITE.dimensions)
    shape[SUITE.dimensions.index("record")], shape[SUITE.dimensions.index("scale")] = values.shape
    axes: dict[str, np.ndarray] = {name: np.ones(1) for name in SUITE.dimensions}
    axes["record"] = np.array([f"record-{i:03}" for i in range(values.shape[0])])
    axes["scale"] = scales
    data = {
        SUITE.metric: (SUITE.dimensions, values.reshape(shape), {"units": "m"}),
        "status": (SUITE.dimensions, np.broadcast_to(status, values.shape).astype(np.int8).reshape(shape)),
    }
    return xr.Dataset(data, axes)


def test_counts_in_four_intervals_have_the_two_parameters_that_give_their_shares() -> None:
    """Three intervals have two free shares, and a lognormal two parameters: the fit gives the shares themselves."""
    low = np.repeat([0.0, 1.0, 2.0], [3, 5, 2])
    high = np.repeat([1.0, 2.0, np.inf], [3, 5, 2])
    fitted = fit_lognormal(low, high)
    a, b = (NormalDist().inv_cdf(share) for share in (0.3, 0.8))
    dispersion = math.log(2.0) / (b - a)
    # where a likelihood is flat its place is known to the root of a rounding
    assert fitted.dispersion == pytest.approx(dispersion, rel=1e-6)
    assert fitted.median == pytest.approx(math.exp(-a * dispersion), rel=1e-6)
    assert fitted.median_interval[0] < fitted.median < fitted.median_interval[1]
    assert fitted.dispersion_interval[0] < fitted.dispersion < fitted.dispersion_interval[1]


def test_known_numbers_have_their_own_mean_and_deviation_and_intervals_of_their_likelihood() -> None:
    numbers = np.array([0.7, 1.1, 1.3, 2.9])
    fitted = fit_lognormal(numbers, numbers)
    mean, deviation, fallen = np.log(numbers).mean(), np.log(numbers).std(), chdtri(1, 0.05) / 2.0
    assert (math.log(fitted.median), fitted.dispersion) == pytest.approx((mean, deviation), rel=1e-6)
    # of a normal distribution both profiles are closed forms
    off = deviation * math.sqrt(math.expm1(2.0 * fallen / numbers.size))
    assert np.log(fitted.median_interval) == pytest.approx([mean - off, mean + off], rel=1e-4)
    for end in fitted.dispersion_interval:
        ratio = deviation / end
        assert numbers.size * (0.5 * ratio**2 - 0.5 - math.log(ratio)) == pytest.approx(fallen, rel=1e-4)


def test_results_that_grow_as_a_power_of_the_scale_reach_the_limit_where_they_do() -> None:
    """Of two suites that exceed a limit between the same scales, the one with the higher results exceeds it earlier."""
    rng = np.random.default_rng(7)
    capacity = np.exp(rng.normal(math.log(1.3), 0.3, 40))
    capacity = capacity[(capacity > SCALES[0]) & (capacity < SCALES[-1])]
    values = 0.02 * (SCALES / capacity[:, None]) ** 1.7
    answer = fragility(suite_of(values), Fragile(0.02))
    assert answer.attrs["median_scale"] == pytest.approx(np.exp(np.log(capacity).mean()), rel=1e-6)
    assert answer.attrs["dispersion"] == pytest.approx(np.log(capacity).std(), rel=1e-6)


def test_a_short_answer_names_the_structure_where_there_are_several() -> None:
    one = suite_of(np.array([[0.01, 0.03, 0.05, 0.06], [0.001, 0.002, 0.021, 0.03]]))
    two = xr.concat(
        [one, one.assign_coords(natural_frequency_hz=[2.0])], "natural_frequency_hz", data_vars="all"
    )
    sentence = fragility(two.transpose(*SUITE.dimensions), Fragile(0.02)).attrs["brief"]["sentences"][0]
    assert "of the structure with natural_frequency_hz = 1 " in sentence  # no units here
    assert "structure" not in fragility(one, Fragile(0.02)).attrs["brief"]["sentences"][0]


def test_the_curve_is_that_of_the_scales_at_which_records_first_exceed() -> None:
    values = np.array([[0.01, 0.03, 0.015, 0.05], [0.001, 0.002, 0.021, 0.03], [0.001, 0.002, 0.003, 0.004]])
    answer = fragility(suite_of(values), Fragile(0.02))
    # the first exceeds at 1 and, though less at 2, counts from there on
    assert answer["exceeded"].values.tolist() == pytest.approx([0, 1 / 3, 2 / 3, 2 / 3])
    assert answer.attrs["never"] == 1
    probability = answer["probability"].values
    assert (np.diff(probability) > 0).all()
    median, dispersion = answer.attrs["median_scale"], answer.attrs["dispersion"]
    expected = [NormalDist().cdf(math.log(scale / median) / dispersion) for scale in SCALES]
    np.testing.assert_allclose(probability, expected, rtol=1e-12)
    np.testing.assert_array_equal(answer["highest"], values.max(axis=0))
    assert "20 mm" in answer.attrs["note"]


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_a_likelihood_that_is_flat_in_the_dispersion_gives_none(share: float) -> None:
    """Of two neighbouring intervals every dispersion below some gives the shares that were counted, with its own median."""
    below = round(40 * share)
    low, high = np.repeat([0.5, 1.0], [below, 40 - below]), np.repeat([1.0, 2.0], [below, 40 - below])
    assert fit_lognormal(low, high) is None


@pytest.mark.parametrize(
    ("below", "above", "fitted"),
    [([0.5, 4.0], [0.5, 1.0], True), ([0.5, 4.0], [0.6, 3.0], False), ([0.5, 3.0], [0.6, 4.0], False)],
)
def test_of_open_intervals_alone_the_likelihood_may_grow_with_the_dispersion_without_end(
    below: list[float], above: list[float], fitted: bool
) -> None:
    """Against a minimiser over 1/β, which is not held above 1/4, the least that is looked at."""
    low, high = np.array([0.0, 0.0, *above]), np.array([*below, np.inf, np.inf])

    def unlikely(x: np.ndarray) -> float:
        with np.errstate(divide="ignore"):
            shares = ndtr(x[0] * np.log(high) - x[1]) - ndtr(x[0] * np.log(low) - x[1])
        return -float(np.log(np.maximum(shares, 1e-300)).sum())

    best = minimize(unlikely, [0.3, 0.0], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-15})
    found = fit_lognormal(low, high)
    assert (found is not None) is fitted is bool(best.x[0] > 1.0 / WIDEST)
    if found is not None:
        assert found.dispersion == pytest.approx(1.0 / best.x[0], rel=1e-4)


def test_a_record_that_fails_as_it_is_scaled_up_exceeds_the_limit() -> None:
    """Capacities are lognormal, and runs far above them fail: the curve is that of all runs, not that of those that lasted."""
    rng = np.random.default_rng(5)
    capacity = np.exp(rng.normal(math.log(1.4), 0.5, 60))[:, None]
    # the response grows as the scale, and a run ends where it is half more than the limit
    values = 0.02 * SCALES / capacity
    failed = values > 0.03
    whole = fragility(suite_of(values), Fragile(0.02))
    broken = fragility(suite_of(np.where(failed, np.nan, values), np.where(failed, 2, 0)), Fragile(0.02))
    fitted = fit_lognormal(*bounds(capacity < SCALES, SCALES, capacity >= SCALES))
    assert (broken.attrs["median_scale"], broken.attrs["dispersion"]) == fitted[:2]
    np.testing.assert_array_equal(broken["exceeded"], whole["exceeded"])
    assert broken.attrs["records"] == 60


def test_a_run_that_is_missing_among_others_widens_what_is_known_of_its_record() -> None:
    """Failed or not computed between known ones, at the end of them not computed, and failed above one that exceeds."""
    values = np.array(
        [
            [0.001, np.nan, 0.03, 0.05],
            [0.001, np.nan, 0.002, 0.03],
            [0.001, 0.002, np.nan, np.nan],
            [0.03, 0.05, 0.05, np.nan],
            [0.001, 0.002, 0.002, np.nan],
            [np.nan] * 4,
        ]
    )
    status = np.where(np.isnan(values), -1, 0)
    status[0, 1], status[1, 1], status[3, 3], status[4, 3] = 4, 4, 2, 3
    answer = fragility(suite_of(values, status), Fragile(0.02))
    assert answer.attrs["records"] == 5
    assert answer.attrs["never"] == 1
    # at the second scale it is not known of the first, at the last two not of the third
    assert answer["exceeded"].values.tolist() == pytest.approx([1 / 5, 1 / 4, 2 / 4, 1.0])
    low, high = np.array([0.5, 2.0, 1.0, 0.0, 2.0]), np.array([2.0, 4.0, np.inf, 0.5, 4.0])
    fitted = fit_lognormal(low, high)
    assert answer.attrs["median_scale"] == fitted.median


def test_a_failed_run_exceeds_only_above_what_is_known_and_below_nothing_that_is_still_to_come() -> None:
    values = np.array([[np.nan] * 4, [0.001, np.nan, np.nan, np.nan], [0.001, np.nan, np.nan, np.nan]])
    status = np.array([[2] * 4, [0, 2, 2, -1], [0, -1, 2, 2]])
    answer = fragility(suite_of(values, status), Fragile(0.02))
    # nothing is known of the first, and the second may not exceed at the last scale
    assert (answer.attrs["records"], answer.attrs["never"]) == (2, 1)
    assert answer["exceeded"].values.tolist()[0] == 0


def test_what_cannot_be_fitted_is_said() -> None:
    same = fragility(suite_of(np.tile([0.01, 0.03, 0.04, 0.05], (4, 1))), Fragile(0.02))
    assert "median_scale" not in same.attrs
    assert np.isnan(same["probability"]).all()
    # the first exceeds it at the least scale, and the second is not known to before: both may there
    touching = fragility(
        suite_of(
            np.array([[0.03, 0.03, 0.04, 0.05], [0.01, np.nan, 0.04, 0.05]]),
            np.array([[0] * 4, [0, 4, 0, 0]]),
        ),
        Fragile(0.02),
    )
    assert "median_scale" not in touching.attrs
    # one of two exceeds at every scale and the other at none: any median fits
    unsettled = fragility(suite_of(np.array([[0.03] * 4, [0.001] * 4])), Fragile(0.02))
    assert "median_scale" not in unsettled.attrs
    assert "inf" not in unsettled.attrs["note"]
    never = fragility(suite_of(np.full((4, 4), 0.001)), Fragile(0.02))
    assert never.attrs["never"] == 4
