"""Between the dampers that were looked at: what may be better there is looked for; brute force holds what is said of it."""

from typing import Any

import numpy as np
import pytest
from tests.benchmarks.design import drawn
from tests.studies.design.test_design import brute, pursued, solved

from damperlab.studies.design.between import AS_MANY, ENOUGH, FEW, NARROWEST, look_between
from damperlab.studies.design.book import Book
from damperlab.studies.design.lattice import Lattice
from damperlab.studies.design.search import Search
from damperlab.studies.design.shortfall import promising, shortfall_of
from damperlab.studies.specification.reading import parse_specification

NARROW_VALLEY = drawn(11)
"""Its least response lies in a valley that neighbours on the lattice hardly show."""


def follow(search: Search, steps: Any) -> None:
    for wanted in steps:
        search.book.add(solved(study) for study in search.book.studies(wanted))


@pytest.fixture(scope="module")
def searched() -> tuple[Search, float, float, int]:
    """A search that has looked between its dampers, with its best and what may be better before that, and the points."""
    asked = parse_specification(NARROW_VALLEY)
    search = Search(asked, Book(asked, 100_000))
    follow(search, search.run())
    best = search.best()
    before = shortfall_of(search, best)
    assert before is not None
    known = search.robust[best].value, before.between, search.book.spent
    follow(search, look_between(search))
    return search, *known


def test_a_better_damper_is_found_and_less_is_left_that_may_be_better(searched) -> None:
    search, value, between, points = searched
    best = search.robust[search.best()]
    after = shortfall_of(search, search.best())
    assert after is not None
    assert between > 0.5 * value
    assert best.value < 0.97 * value
    assert after.between < 0.05 * best.most
    assert search.book.spent <= points + max(FEW, AS_MANY * points)


def test_it_goes_on_until_nothing_promises_more_than_enough(searched) -> None:
    search = searched[0]
    pool = set(search.pool)
    for each in promising(search, ENOUGH):
        # what still promises more has no room beside it
        for d, x in enumerate(each):
            line = [one[d] for one in pool if one[:d] == each[:d] and one[d + 1 :] == each[d + 1 :]]
            for side in (-1.0, 1.0):
                assert min(
                    (side * (other - x) for other in line if side * (other - x) > 0.0), default=0.0
                ) < (2 * NARROWEST)


def test_every_candidate_has_neighbours_of_its_own_along_every_quantity(searched) -> None:
    """So that what may dip beside it is estimated and not taken to be nothing."""
    search = searched[0]
    lattice = Lattice(search.asked)
    for each in promising(search, -1.0)[:20]:
        for d in range(len(lattice.names)):
            assert any(
                one != each and one[:d] == each[:d] and one[d + 1 :] == each[d + 1 :] for one in search.pool
            )


@pytest.mark.night
def test_brute_force_close_to_the_best_finds_nothing_better_than_said() -> None:
    found, _ = pursued(NARROW_VALLEY)
    assert found.shortfall is not None
    build, choose = found.build, NARROW_VALLEY["choose"]
    axes = []
    for name in ("clearance_m", "friction_force_n"):
        low, high = choose[name]["start"], choose[name]["stop"]
        near = getattr(build, name) + (high - low) / 32 * np.linspace(-1.0, 1.0, 9)
        axes.append(np.unique(np.clip(near, low, high)))
    band, own = (
        NARROW_VALLEY["excitation"]["frequency_hz"],
        NARROW_VALLEY["structure"]["natural_frequency_hz"],
    )
    truth = brute(NARROW_VALLEY, *axes, (band["start"] / own, band["stop"] / own, 241)).min().item()
    # 241 frequencies miss the top of a peak by less than this
    assert truth >= 0.98 * (found.compared.most - found.shortfall.between)
