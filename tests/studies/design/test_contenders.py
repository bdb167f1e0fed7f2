"""Dampers that may be better with their tolerances than the best that was judged with them: brute force at their corners."""

from collections.abc import Generator
from typing import Any

import numpy as np
import pytest
from tests.studies.design.test_design import BUDGET, DAMPED, brute, solved

from damperlab.studies.design.book import Book, Wanted
from damperlab.studies.design.contenders import at_least, contend, contenders_of
from damperlab.studies.design.search import Search
from damperlab.studies.design.shortfall import shortfall_of
from damperlab.studies.specification.reading import parse_specification


def driven(steps: Generator[list[Wanted], None, Any], book: Book) -> None:
    """Give a part of a search what it asks for, to its end."""
    for wanted in steps:
        book.add([solved(study) for study in book.studies(wanted)])


@pytest.fixture(scope="module")
def searched() -> tuple[Search, int, int, float]:
    """A search with its contenders looked at; how many there were, what was spent before, and what the best did then."""
    asked = parse_specification(DAMPED)
    search = Search(asked, Book(asked, BUDGET))
    driven(search.run(), search.book)
    before = len(contenders_of(search)), search.book.spent, search.robust[search.best()].most
    driven(contend(search), search.book)
    return search, *before


def test_nothing_that_was_looked_at_may_be_better_than_the_best(searched) -> None:
    search, contenders, spent, most = searched
    assert contenders > 3
    assert not contenders_of(search)
    best = search.robust[search.best()]
    assert best.violation == 0.0
    # the best may have changed, for one that is sure to do less
    assert best.most <= most
    # most of them are seen to do more at one corner: to judge all of them takes several times as much
    corners = len(search.corners) + 1
    assert search.book.spent - spent < 60 * corners * contenders / 2


def test_what_is_refuted_does_more_by_brute_force(searched) -> None:
    search, *_ = searched
    best = search.robust[search.best()]
    drawn = {each: search.score(search.lattice.build(each)).value for each in search.pool}
    refuted = sorted(
        (each for each in search.pool if each not in search.robust), key=lambda each: drawn[each]
    )
    assert drawn[refuted[0]] < best.value
    for each in refuted[:4]:
        known = at_least(search, each)
        assert known.value - known.noise >= best.most
        build = search.lattice.build(each)
        corners = brute(
            DAMPED,
            build.clearance_m * np.array([0.95, 1.05]),
            build.friction_force_n * np.array([0.9, 1.1]),
        )
        # at 101 frequencies, of which some lie beside the peak
        assert float(corners.max()) >= 0.98 * known.value
        assert float(corners.max()) > 0.98 * best.value


def test_what_is_assumed_of_others_is_said_where_they_were_not_looked_at(searched) -> None:
    search, *_ = searched
    after = shortfall_of(search, search.best())
    asked = parse_specification(DAMPED)
    alone = Search(asked, Book(asked, BUDGET))
    driven(alone.run(), alone.book)
    before = shortfall_of(alone, alone.best())
    assert after is not None
    assert before is not None
    assert (before.assumed, after.assumed) == (True, False)
    assert after.computed < 0.5 * before.computed


def test_contenders_leave_the_rest_of_the_budget_to_what_follows() -> None:
    asked = parse_specification(DAMPED)
    search = Search(asked, Book(asked, BUDGET))
    driven(search.run(), search.book)
    search.book.budget = int((search.book.spent + 100) / 0.75)
    driven(contend(search), search.book)
    assert search.book.spent <= 0.75 * search.book.budget
    assert contenders_of(search)
    assert search.cap == search.book.budget
