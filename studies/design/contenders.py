"""Dampers that may be better than the best by what is known of them: looked at with tolerances until none of them may.

The search judges few of its candidates with their tolerances. Of the others some respond less as drawn than the best does with
its tolerances. One corner of the tolerances, looked at coarsely, shows of most of them that they respond more: a worst case
can only grow as more is known of it.
"""

from damperlab.studies.design.book import BudgetSpent
from damperlab.studies.design.lattice import Candidate
from damperlab.studies.design.score import Score, worst
from damperlab.studies.design.search import CLOSE, Asks, Search

SHARE = 0.75
"""Of the budget, up to which contenders are looked at."""


def contend(search: Search) -> Asks:
    """Look at contenders with their tolerances until none is left, or the budget's share is spent.

    What is asked for depends on the search alone. Where the best changes, the new one is known as closely as the one before.

    Parameters
    ----------
    search : Search
        At its end; those that are judged are added to `Search.robust`.
    """
    search.cap = int(SHARE * search.book.budget)
    try:
        while True:
            while contenders := contenders_of(search):
                yield from _look(search, contenders)
            yield from search.polish()
            if not contenders_of(search):  # which what is now known of the best may have changed
                break
    except BudgetSpent:
        pass  # what is said of how much better others may be counts those that are left
    search.cap = search.book.budget


def at_least(search: Search, candidate: Candidate) -> Score:
    """Give the worst case of a candidate over what is known of it and of the corners of its tolerances."""
    known = [build for build in search.with_corners(candidate) if search.looked_at(build)]
    return worst(search.score(build) for build in known)


def contenders_of(search: Search) -> list[Candidate]:
    """Name the candidates, not judged with tolerances yet, that may be better than the best, the most promising first."""
    bar = search.robust[search.best()].sure
    found: list[tuple[float, float, Candidate]] = []
    for each in search.pool:
        if each not in search.robust:
            known = at_least(search, each)
            rank = known.violation, known.value - known.noise
            if rank < bar:
                found.append((*rank, each))
    return [each for *_, each in sorted(found)]


def _look(search: Search, contenders: list[Candidate]) -> Asks:
    """Look at one corner more of each; where all are known coarsely, judge the most promising as closely as the others."""
    severe = _severe(search)
    next_ones = []
    for each in contenders:
        builds = search.with_corners(each)
        unknown = (builds[place] for place in severe if not search.looked_at(builds[place]))
        corner = next(unknown, None)
        if corner is not None:
            next_ones.append(corner)
    if next_ones:
        yield from search.known(next_ones, 0)
        return
    builds = search.with_corners(contenders[0])
    yield from search.known(builds, CLOSE + 1)
    search.robust[contenders[0]] = worst(search.score(build) for build in builds)


def _severe(search: Search) -> list[int]:
    """Order the corners by how severe they are for the best: the same are likely to be for others."""
    scores = [search.score(build).rank for build in search.with_corners(search.best())]
    return sorted(range(1, len(scores)), key=lambda place: scores[place], reverse=True)
