"""How results scatter over draws: errors of known distributions, and intervals that hold as often as they say."""

import math

import numpy as np
import pytest
from scipy.special import bdtr
from tests.studies.answers.test_fragility import suite_of

from damperlab.studies.answers.fragility import fragility
from damperlab.studies.answers.over_records import enough_records, over_records
from damperlab.studies.questions import Fragile


def test_means_have_the_errors_of_many_repetitions() -> None:
    """Of 400 draws of 40 results each; a standard deviation of 400 is known to 1/√800, 3.5 %, and four of these are allowed."""
    draws = np.random.default_rng(2).gamma(9.0, 0.1, (400, 40))
    found = [over_records(each, 0.9) for each in draws]
    for name in ("mean", "rms"):
        values, errors = ([getattr(each, kind) for each in found] for kind in (name, f"{name}_error"))
        assert np.std(values, ddof=1) == pytest.approx(
            np.sqrt(np.mean(np.square(errors))), rel=4 / math.sqrt(800)
        )
    assert np.mean([each.mean for each in found]) == pytest.approx(0.9, abs=4 * 0.3 / math.sqrt(16_000))
    assert found[0].rms == pytest.approx(math.sqrt(np.mean(draws[0] ** 2)), rel=1e-14)


@pytest.mark.parametrize(("share", "records"), [(0.5, 9), (0.9, 40), (0.75, 120), (0.1, 36)])
def test_an_interval_of_a_quantile_holds_it_as_often_as_it_says(share: float, records: int) -> None:
    """The chance is the binomial's own, at least 95 %, and no narrower pair of results has one."""
    truth = math.sqrt(-2.0 * math.log1p(-share))
    draws = np.random.default_rng(5).rayleigh(size=(2000, records))
    found = [over_records(each, share) for each in draws]
    held = np.mean([each.quantile_low <= truth <= each.quantile_high for each in found])
    low, high = (int(np.flatnonzero(np.sort(draws[0]) == end)[0]) for end in found[0][-2:])
    chance = bdtr(high, records, share) - bdtr(low, records, share)
    assert chance >= 0.95
    assert held == pytest.approx(chance, abs=4 * math.sqrt(chance * (1 - chance) / 2000))
    for narrower in ((low + 1, high), (low, high - 1)):
        ends = bdtr(narrower[0], records, share), 1 - bdtr(narrower[1], records, share)
        assert max(ends) > 0.025
    assert all(each.quantile_low <= each.quantile <= each.quantile_high for each in found)


@pytest.mark.parametrize("share", [0.5, 0.9, 0.05, 0.99])
def test_so_many_records_bound_a_quantile_and_one_fewer_do_not(share: float) -> None:
    enough = enough_records(share)
    values = np.random.default_rng(3).normal(10.0, size=enough)
    assert np.isfinite(over_records(values, share)).all()
    assert not np.isfinite(over_records(values[1:], share)).all()


def test_what_is_unknown_is_left_out_and_nothing_is_nothing() -> None:
    values = np.array([1.0, np.nan, 3.0])
    np.testing.assert_equal(over_records(values, 0.5), over_records(np.array([3.0, 1.0]), 0.5))
    assert np.isnan(over_records(np.full(3, np.nan), 0.5)).all()
    assert over_records(np.zeros(3), 0.5).rms_error == 0.0


def test_a_suite_of_seeds_at_one_scale_says_rms_quantile_and_how_many_seeds_bound_it() -> None:
    values = np.linspace(0.01, 0.03, 16)
    answer = fragility(suite_of(values[:, None], scales=np.ones(1)), Fragile(0.025))
    known = over_records(values, 0.9)
    assert answer["rms"].item() == known.rms
    assert answer["quantile_low"].item() == known.quantile_low
    assert answer["quantile"].attrs == {"units": "m", "long_name": "quantile over the records"}
    brief = answer.attrs["brief"]
    assert f"rms over 16 records is 20.9 mm ± {1e3 * known.rms_error:.2g} mm" in " ".join(brief["sentences"])
    assert brief["next"].startswith("36 records or seeds")
