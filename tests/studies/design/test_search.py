"""The search on functions whose least value is known, and with the real solver beside frequencies that it did not choose."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.studies.design.test_design import DAMPED
from tests.studies.solving import solved

from damperlab.studies.design.book import Book
from damperlab.studies.design.build import Build
from damperlab.studies.design.frequencies import onsets, rise
from damperlab.studies.design.optimisers import SIZES, Effort, best_apart, descended, spread
from damperlab.studies.design.score import Score
from damperlab.studies.design.search import Search
from damperlab.studies.design.space import Candidate, Space
from damperlab.studies.design.steps import in_studies
from damperlab.studies.specification.reading import parse_specification

FREE = {
    "clearance_m": {"start": 0.002, "stop": 0.012},
    "friction_force_n": {"start": 0.0, "stop": 60.0},
    "particle_mass_kg": {"start": 1.0, "stop": 6.0},
    "restitution": {"start": 0.2, "stop": 0.8},
}
GIVEN = {"clearance_m": 0.006, "friction_force_n": 20.0}
SCORE = Score(1.0, 0.0, 0.0, 0.0, {}, 1.0, 0.001, Build(0.001, 1.0, 1.0, 0.5), None)


def chosen(**choose: Any) -> dict[str, Any]:
    """Give a specification of which so much is chosen."""
    given = {key: value for key, value in (GIVEN | DAMPED).items() if key not in choose}
    return given | {"choose": choose, "tolerances": {}}


def space(count: int) -> Space:
    """Give candidates of the first so many quantities."""
    return Space(parse_specification(chosen(**dict(list(FREE.items())[:count]))))


def least(over: Space, response: Callable[[np.ndarray], float]) -> tuple[float, list[list[Candidate]]]:
    """Search for the least of a function, and give it with all that was asked for."""
    values: dict[Candidate, float] = {}
    asked = []

    def requested() -> Iterator[list[Candidate]]:
        yield from spread(over, values, Effort())
        for size in SIZES:
            yield from descended(over, values, best_apart(values, Effort().starts), size)

    for candidates in requested():
        asked.append(candidates)
        values |= {each: round(math.log(response(np.array(each))), 9) for each in candidates}
    return math.exp(min(values.values())), asked


def crossing(x: np.ndarray) -> float:
    """Two peaks that are equal in a valley: the larger rises to either side, as at most optima of a damper. Least 1."""
    ridge = x[0] - 0.37 + 0.4 * float((x[1:] - 0.6).sum())
    return 1.0 + 2.0 * abs(ridge) + float(((x - np.r_[0.37, np.full(x.size - 1, 0.6)]) ** 2).sum())


def cliff(x: np.ndarray) -> float:
    """Falls up to a line beyond which the response jumps to three times as much. Least 1, at the line and an end of a range."""
    beyond = x[0] > 0.613
    return (3.0 if beyond else 1.0) * (1.0 + abs(x[0] - 0.613) + float((1.0 - x[1:]).sum()))


def two_basins(x: np.ndarray) -> float:
    """A wide basin of 1.2, and one of 1 that is two sevenths of the ranges wide."""
    wide = 1.2 + float(((x - 0.75) ** 2).sum())
    narrow = 1.0 + 1.4 * float(np.abs(x - 0.22).max())
    return min(wide, narrow)


@pytest.mark.parametrize("response", [crossing, cliff, two_basins])
@pytest.mark.parametrize("count", [1, 3])
def test_the_least_value_is_found_within_a_percent(count: int, response: Callable[..., float]) -> None:
    found, asked = least(space(count), response)
    assert 1.0 <= found <= 1.01
    assert sum(map(len, asked)) < 120 * count


def test_the_last_digits_of_another_processor_change_nothing() -> None:
    rng = np.random.default_rng(1)
    _, here = least(space(2), crossing)
    _, there = least(space(2), lambda x: crossing(x) * (1.0 + 1e-15 * rng.uniform(-1.0, 1.0)))
    assert here == there


def test_nothing_is_asked_for_twice_and_all_of_it_lies_in_the_ranges() -> None:
    _, asked = least(space(3), cliff)
    every = [each for candidates in asked for each in candidates]
    assert len(set(every)) == len(every)
    assert all(0.0 <= share <= 1.0 for each in every for share in each)
    assert {0.0, 1.0} < {share for each in every for share in each}


def test_all_of_a_few_listed_values_are_looked_at() -> None:
    lists = {"clearance_m": [0.002, 0.004, 0.008], "restitution": [0.2, 0.5]}
    over = Space(parse_specification(chosen(**lists)))
    _, asked = least(over, crossing)
    assert len(asked) == 1
    builds = [over.build(each) for each in asked[0]]
    assert sorted((one.clearance_m, one.restitution) for one in builds) == [
        (d, e) for d in lists["clearance_m"] for e in lists["restitution"]
    ]


def test_beside_a_range_listed_values_stay_on_the_list() -> None:
    over = Space(parse_specification(chosen(clearance_m=FREE["clearance_m"], restitution=[0.2, 0.5, 0.8])))
    found, asked = least(over, lambda x: 1.0 + abs(x[0] - 0.37) + (x[1] - 0.5) ** 2)
    assert found <= 1.01
    assert {over.build(each).restitution for candidates in asked for each in candidates} == {0.2, 0.5, 0.8}


@given(st.floats(-0.5, 0.5), st.floats(0.1, 3.0), st.floats(0.1, 3.0))
def test_the_rise_beside_the_largest_sample_holds_a_smooth_peak(at: float, left: float, right: float) -> None:
    """Concave functions, as steep on either side as drawn."""
    r = np.arange(-3.0, 4.0)

    def response(x: np.ndarray) -> np.ndarray:
        return 5.0 - np.where(x < at, left, right) * (x - at) ** 2

    values = response(r)
    truth = response(np.array([at])).item()
    assert truth <= values.max() + rise(r, values) + 1e-12
    assert rise(r, values) <= 2.0 * max(left, right)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_no_curve_is_laid_across_a_jump(side: float) -> None:
    """A response that rises by 0.01 a step up to a fold and falls to a third there."""
    r = np.arange(0.0, 10.0)
    values = np.where(r < 6.5, 3.5 + 0.01 * r, 1.2 - 0.01 * r)
    if side < 0.0:
        values = values[::-1]
    # up to the jump it rises as before it, by a step at most
    assert rise(r, values) == pytest.approx(0.01, rel=1e-9)
    between_two_jumps = np.where(np.abs(r - 4.5) < 2.0, values, 1.0)
    assert rise(r, between_two_jumps) == pytest.approx(0.01, rel=1e-9)


def test_the_rise_is_told_of_few_samples_too() -> None:
    r = np.arange(4.0)
    assert rise(r, np.array([1.0, 2.0, 0.0, 0.0])) == 1.0
    assert rise(r[:2], np.array([1.0, 2.0])) == rise(r[:1], np.array([1.0])) == 0.0


def test_what_exceeds_a_limit_comes_after_all_that_keep_it() -> None:
    search = Search(parse_specification(DAMPED), Book(parse_specification(DAMPED), 10))
    ranked = [
        replace(SCORE, value=0.0),
        SCORE,
        replace(SCORE, value=1.0, noise=0.1),
        replace(SCORE, value=1e9),
        replace(SCORE, value=0.1, violation=1e-6),
        replace(SCORE, value=0.1, violation=5.0),
        replace(SCORE, value=math.inf),
    ]
    values = [search.worth(each) for each in ranked]
    assert values == sorted(values)
    assert len(set(values)) == len(values)


def test_every_damper_that_may_be_better_than_the_best_was_examined_closely() -> None:
    """A coarse look gives a lower bound, so the best is the best of all only if no bound is below its value."""
    asked = parse_specification(chosen(clearance_m=FREE["clearance_m"]))
    search = Search(asked, Book(asked, 20_000))
    for studies in in_studies(search.book, search.run()):
        search.book.add(map(solved, studies))
    assert search.ended == "converged"
    bar = search.worth(search.robust[search.best()])
    bounds = [value for each, value in search.examined.items() if each not in search.robust]
    assert bounds
    assert min(bounds) >= bar


def test_a_search_keeps_to_its_points_and_asks_for_the_same_again() -> None:
    asked = parse_specification(DAMPED)
    cubes: dict[str, Any] = {}
    best = []
    for _ in range(2):
        search = Search(asked, Book(asked, 3000))
        for studies in in_studies(search.book, search.run()):
            assert not best or all(study.digest in cubes for study in studies)
            cubes |= {study.digest: solved(study) for study in studies if study.digest not in cubes}
            search.book.add(cubes[study.digest] for study in studies)
            assert search.book.spent <= 3000
        assert search.stopped == search.ended == "budget"
        best.append((search.best(), search.robust[search.best()]))
    assert best[0] == best[1]


def test_a_narrow_peak_where_impacts_set_in_is_found() -> None:
    """Over 0.4 ‰ of frequency the response from rest is 1.5 times as large as at any sampled frequency."""
    r = np.array([1.0, 1.8, 2.6, 2.600001, 3.4])
    np.testing.assert_allclose(
        onsets(r, np.array([0.0, 0.0, 2.0, 0.0, 0.0])), np.arange(1.9, 2.55, 0.1), rtol=1e-8
    )
    asked = parse_specification(
        {
            "name": "narrow",
            "structure": {"mass_kg": 3.0184, "natural_frequency_hz": 2.423656, "damping_ratio": 0.0049238},
            "excitation": {"base_amplitude_m": 0.0029701, "frequency_hz": {"start": 2.04, "stop": 2.86}},
            "clearance_m": 0.02758076,
            "friction_force_n": 0.7045384,
            "particle_mass_kg": 0.3108972,
            "restitution": 0.6408387,
            "builds": 0,
        }
    )
    search = Search(asked, Book(asked, 20_000))
    for studies in in_studies(search.book, search.run()):
        search.book.add(map(solved, studies))
    assert search.robust[search.best()].value == pytest.approx(0.0373, rel=0.01)
