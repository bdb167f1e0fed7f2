"""Between the dampers that were looked at: the lattice is halved where the response may dip below the best.

The search halves it around the best few alone. What another damper may do better is estimated by how steeply the response falls
beside every candidate that none of its neighbours is better than; where that is much, neighbours at half the way tell.
"""

from itertools import product

from damperlab.studies.design.book import BudgetSpent
from damperlab.studies.design.lattice import FINEST, Candidate, Lattice
from damperlab.studies.design.search import CLOSE, Asks, Search
from damperlab.studies.design.shortfall import promising

ENOUGH = 0.02
"""Share of the recommended damper's response, by which another may be better, that is not looked for."""
AT_ONCE = 4
"""Candidates that are looked beside at once: where the best changes, others may no longer promise anything."""
NARROWEST = FINEST / 4
"""Least share of a range between two candidates."""
FULL = 3
"""Quantities up to which every neighbour is looked at: so that each has neighbours of its own along every quantity."""
SHARE = 0.5
"""Of the budget, up to which this is done."""
AS_MANY, FEW = 1.0, 4000
"""How many times the points of the search it may take, and how many points in any case: seconds."""


def look_between(search: Search) -> Asks:
    """Halve the lattice beside candidates that promise a better damper, until none does or the points for it are spent.

    What is asked for depends on the search alone.

    Parameters
    ----------
    search : Search
        At its end; candidates are added to its pool, and the best of them are judged.
    """
    book = search.book
    if len(search.lattice.names) > FULL:
        return
    search.cap = min(int(SHARE * book.budget), book.spent + max(FEW, int(AS_MANY * book.spent)))
    try:
        while True:
            while new := _beside(search):
                yield from search.add(new)
                yield from search.settle(CLOSE)
                yield from search.judge([each for each in search.leaders() if each not in search.robust])
            yield from search.polish()
            if not _beside(search):  # which what is now known of the best may have changed
                break
    except BudgetSpent:
        pass  # what is said of how much better others may be counts what is left
    search.cap = book.budget


def _beside(search: Search) -> list[Candidate]:
    """Give new neighbours of the most promising candidates that have any; empty where none promises enough."""
    pool = set(search.pool)
    found: set[Candidate] = set()
    looked_beside = 0
    for each in promising(search, ENOUGH):
        new = {one for one in _halfway(search.lattice, search.pool, each) if one not in pool}
        if new:
            found |= new
            looked_beside += 1
        if looked_beside == AT_ONCE:
            break
    return sorted(found)


def _halfway(lattice: Lattice, pool: list[Candidate], centre: Candidate) -> list[Candidate]:
    """Give the places half the way from a candidate to those beside it along each quantity, in every combination."""
    axes: list[list[float]] = []
    for d, name in enumerate(lattice.names):
        if lattice.listed(name):
            axes.append([centre[d]])
            continue
        line = [one[d] for one in pool if one[:d] == centre[:d] and one[d + 1 :] == centre[d + 1 :]]
        below = max((x for x in line if x < centre[d]), default=None)
        above = min((x for x in line if x > centre[d]), default=None)
        beside = [0.5 * (x + centre[d]) for x in (below, above) if x is not None]
        axes.append([centre[d], *(x for x in beside if abs(x - centre[d]) >= NARROWEST)])
    return list(product(*axes))
