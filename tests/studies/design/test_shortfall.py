"""By how much another damper may be better: closed forms, convex functions drawn, brute force between the candidates."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from tests.studies.design.test_design import DAMPED, brute, pursued

from damperlab.studies.design.build import Build
from damperlab.studies.design.known import words_of_shortfall
from damperlab.studies.design.score import Score
from damperlab.studies.design.shortfall import Shortfall, dip, dips_of, share_kept

SCORE = Score(1.0, 0.0, 0.0, 0.0, {}, 1.0, 0.001, Build(0.001, 1.0, 1.0, 0.5), None)


def test_the_valley_of_two_lines_is_found_between_the_places() -> None:
    # |x − 0.3| at the integers: the valley is 0.3 below the value at 0
    x = np.arange(-2.0, 4.0)
    values = np.abs(x - 0.3)
    assert dip(x, values, 2) == pytest.approx(0.3, abs=1e-12)
    assert dip(x, values, 3) == pytest.approx(0.7, abs=1e-12)


def test_a_straight_line_dips_nowhere_but_to_its_lower_end() -> None:
    x = np.arange(5.0)
    assert dip(x, 2.0 * x, 0) == 0.0
    assert dip(x, 2.0 * x, 2) == pytest.approx(2.0, abs=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_no_convex_function_falls_further_inside_its_range(seed: int) -> None:
    """The largest of lines drawn, at places drawn: nowhere beside a place is it lower than said."""
    rng = np.random.default_rng(seed)
    slopes, heights = rng.uniform(-3, 3, 6), rng.uniform(-1, 1, 6)
    x = np.sort(rng.uniform(-2, 2, 9))

    def largest(at: np.ndarray) -> np.ndarray:
        return (slopes[:, None] * at + heights[:, None]).max(axis=0)

    values = largest(x)
    for place in range(2, x.size - 2):
        fine = largest(np.linspace(x[place - 1], x[place + 1], 2001))
        assert fine.min() >= values[place] - dip(x, values, place) - 1e-12


def test_beyond_the_end_of_a_range_it_falls_as_steeply_as_before_it() -> None:
    # 4, 2, 1 at 0, 1, 2: slopes −2 and −1; on the last interval lines of slope ∓2 from its ends meet at 0.5
    assert dip(np.arange(3.0), np.array([4.0, 2.0, 1.0]), 2) == pytest.approx(0.5, abs=1e-12)
    # nothing is known beyond two places but what they differ by
    assert dip(np.arange(2.0), np.array([1.0, 3.0]), 0) == 0.0


def test_dips_of_the_quantities_add_up_and_lists_have_nothing_between_them() -> None:
    bowl = {
        (x, y): replace(SCORE, value=abs(x - 0.3) + abs(y - 1.6)) for x in range(-2, 4) for y in range(-1, 5)
    }
    both = dips_of(bowl, (False, False))
    assert both.keys() == {(0, 2)}
    assert both[0, 2] == pytest.approx(0.3 + 0.4, abs=1e-12)
    assert dips_of(bowl, (False, True))[0, 2] == pytest.approx(0.3, abs=1e-12)


def test_a_neighbour_that_exceeds_a_limit_is_no_better_but_shows_how_low_it_may_be_beside_it() -> None:
    row = {(float(x),): replace(SCORE, value=value) for x, value in enumerate([5.0, 4.0, 3.0, 2.0])}
    row[3.0,] = replace(row[3.0,], violation=0.1)
    assert dips_of(row, (False,)) == {(2.0,): pytest.approx(1.0)}


def test_the_least_share_lost_by_tolerances_is_that_of_those_judged() -> None:
    drawn = {(k,): replace(SCORE, value=float(k)) for k in (1.0, 2.0, 3.0)}
    judged = {(1.0,): replace(SCORE, value=1.5), (2.0,): replace(SCORE, value=2.4)}
    assert share_kept(drawn, judged) == pytest.approx(1.2)
    assert share_kept(drawn, judged | {(3.0,): replace(SCORE, value=inf)}) == pytest.approx(1.2)
    assert share_kept(drawn, {}) == 1.0


def test_brute_force_between_the_candidates_finds_nothing_better_than_said() -> None:
    document = DAMPED | {"tolerances": {}, "clearance_m": 0.006}
    document["choose"] = {"friction_force_n": {"start": 0.0, "stop": 60.0}}
    found, _ = pursued(document)
    assert found.shortfall is not None
    assert 0.0 <= found.shortfall.computed <= found.shortfall.between
    truth = brute(document, np.array([0.006]), np.linspace(0.0, 60.0, 129)).min().item()
    # a grid of 101 frequencies does not see the whole peak; what it misses makes brute force look better
    assert truth >= 0.99 * (found.compared.most - found.shortfall.between)
    # and it says something: this response is no noise between its candidates
    assert found.shortfall.between < 0.1 * found.compared.most


def test_where_limits_are_exceeded_nothing_is_said_of_the_measure() -> None:
    document = DAMPED | {"tolerances": {}, "clearance_m": 0.006, "limits": {"displacement_m": 1e-4}}
    document["choose"] = {"friction_force_n": {"start": 0.0, "stop": 60.0}}
    found, _ = pursued(document)
    assert found.shortfall is None


@pytest.mark.parametrize(
    ("share", "told"),
    [(1.0, "100 %"), (1.234, "123 %"), (0.1234, "12 %"), (0.05678, "5.7 %"), (9.99e-4, "0.1 %")],
)
def test_shares_are_told_without_powers_of_ten(share: float, told: str) -> None:
    sentence = words_of_shortfall(Shortfall(share, share), 1.0)
    assert f"by more than {told}" in sentence
    # an estimate of a hundred per cent tells nothing
    assert (f"up to {told} " in sentence) is (share < 0.5)
