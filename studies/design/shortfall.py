"""By how much another damper may be better than the recommended one, by what was computed of all that were looked at."""

from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.design.contenders import at_least
from damperlab.studies.design.lattice import Candidate
from damperlab.studies.design.score import Score
from damperlab.studies.design.search import Search

SAME = 1e-9
"""Difference of shares that are one place."""


@dataclass(frozen=True)
class Shortfall:
    """By how much the best damper of the ranges may stay below the recommended one, in the unit of the measure.

    Parameters
    ----------
    computed : float
        One of those that were looked at, their errors counted.
    between : float
        One that was not looked at, beside those that were: an estimate by `dip`, no bound.
    assumed : bool
        Whether `computed` rests on what is assumed of one that was not judged with its tolerances.
    """

    computed: float
    between: float
    assumed: bool = False


def shortfall_of(search: Search, best: Candidate) -> Shortfall | None:
    """Hold what the recommended damper does at most against what others may do at least.

    A candidate that was not judged with its tolerances does at least what is known of their corners; beside that it is taken to
    lose the least share by them that a judged one does.
    Between candidates the response may dip beside those that no neighbour along a quantity is better than; what it may
    dip along every quantity alone is added up.

    Parameters
    ----------
    search : Search
        At its end.
    best : Candidate
        What it recommends.

    Returns
    -------
    Shortfall or None
        None where nothing is chosen, and where limits are exceeded: dampers are then compared by how far.
    """
    recommended = search.robust[best]
    least = _least(search, recommended)
    if least is None:
        return None
    computed = between = recommended.value
    assumed = False
    for each in least.values():
        assumed |= each.assumed and each.itself < computed
        computed = min(computed, each.itself)
        between = min(between, each.beside)
    return Shortfall(recommended.most - max(computed, 0.0), recommended.most - max(between, 0.0), assumed)


def promising(search: Search, share: float) -> list[Candidate]:
    """Name the candidates beside which a damper may be better than the best by more than a share of it, the best of them first.

    Where the best exceeds a limit, better is what exceeds its limits less.

    Parameters
    ----------
    search : Search
        With candidates that were judged.
    share : float
        Of what the best is known to do.
    """
    best = search.robust[search.best()]
    if 0.0 < best.violation < inf:
        excess = {each: 1.0 + at_least(search, each).violation for each in search.pool}
        drawn = {each: search.score(search.lattice.build(each)) for each in search.pool}
        judged = {
            each: replace(one, value=1.0 + one.violation, violation=0.0)
            for each, one in drawn.items()
            if isfinite(one.violation)
        }
        dips = dips_of(judged, _listed(search))
        beside = {each: excess[each] - dip for each, dip in dips.items() if dip > 0.0}
        bar = (1.0 - share) * (1.0 + best.violation)
    else:
        least = _least(search, best) or {}
        beside = {each: known.beside for each, known in least.items() if known.beside < known.itself}
        bar = (1.0 - share) * (best.value - best.noise)
    return [each for lowest, each in sorted((one, each) for each, one in beside.items()) if lowest < bar]


def _listed(search: Search) -> tuple[bool, ...]:
    return tuple(map(search.lattice.listed, search.lattice.names))


class _AtLeast(NamedTuple):
    """What a candidate does at least, and dampers beside it; and whether that rests on what is assumed of its tolerances."""

    itself: float
    beside: float
    assumed: bool


def _least(search: Search, recommended: Score) -> dict[Candidate, _AtLeast] | None:
    """Give what every candidate that keeps the limits may do at least; see `shortfall_of`."""
    if recommended.violation > 0.0 or not search.lattice.names or not isfinite(recommended.most):
        return None
    scores = {each: search.score(search.lattice.build(each)) for each in search.pool}
    finite = {each: one for each, one in scores.items() if isfinite(one.value)}
    kept = share_kept(finite, search.robust)
    dips = dips_of(finite, _listed(search))
    found: dict[Candidate, _AtLeast] = {}
    for each, drawn in finite.items():
        judged = search.robust.get(each)
        known = judged or at_least(search, each)
        if known.violation > 0.0:
            continue
        lowest = known.value - known.noise
        assumed = False
        if not judged and known.value < recommended.most:
            lowest = max(lowest, kept * (drawn.value - drawn.noise))
            assumed = bool(search.corners)
        found[each] = _AtLeast(lowest, lowest - kept * dips.get(each, 0.0), assumed)
    return found


def share_kept(drawn: dict[Candidate, Score], judged: dict[Candidate, Score]) -> float:
    """Give the least ratio of a worst case with tolerances to the one as drawn; 1 where none is known."""
    both = [
        (drawn[each].value, one.value)
        for each, one in judged.items()
        if each in drawn and isfinite(one.value) and drawn[each].value > 0.0
    ]
    return max(1.0, min((robust / nominal for nominal, robust in both), default=1.0))


def dips_of(scores: dict[Candidate, Score], listed: tuple[bool, ...]) -> dict[Candidate, float]:
    """Give how far the worst case may fall below each candidate that keeps the limits and has no better neighbour.

    Parameters
    ----------
    scores : dict of Score
        Of all candidates, as drawn; finite.
    listed : tuple of bool
        By quantity: whether its values are a list, with nothing between them.

    Returns
    -------
    dict of float
        In the unit of the measure.
    """
    every = sorted(scores)
    places = np.array(every)
    values = np.array([scores[each].value for each in every])
    good = np.array([scores[each].violation == 0.0 for each in every])
    found: dict[Candidate, float] = {}
    for at, each in enumerate(every):
        if not good[at]:
            continue
        total = 0.0
        for axis in range(places.shape[1]):
            away = np.delete(np.abs(places - places[at]), axis, axis=1)
            line = np.flatnonzero((away <= SAME).all(axis=1))
            line = line[np.argsort(places[line, axis])]
            here = int(np.flatnonzero(line == at)[0])
            beside = [line[k] for k in (here - 1, here + 1) if 0 <= k < line.size]
            if any(good[other] and values[other] < values[at] for other in beside):
                break
            if not listed[axis]:
                total += dip(places[line, axis], values[line], here)
        else:
            found[each] = total
    return found


def dip(x: NDArray[np.float64], values: NDArray[np.float64], place: int) -> float:
    """Estimate how far a function falls below one of its values on the two intervals beside it.

    It is taken to fall into an interval from either end as steeply as it fell towards that end, or as it falls across the
    interval if that is more; where nothing is known beyond an end, as steeply as from the other. For a convex function,
    such as the largest of two responses where they cross, that is a bound: it lies above every chord that is prolonged.

    Parameters
    ----------
    x, values : ndarray, (n,)
        Ascending places, and the function there.
    place : int
        Which of them.

    Returns
    -------
    float
        Not negative.
    """
    falls = np.diff(values) / np.diff(x)
    lowest = float(values[place])
    for left in (place - 1, place):
        if not 0 <= left < x.size - 1:
            continue
        own, width = falls[left], float(x[left + 1] - x[left])
        down = max(-falls[left - 1], -own, 0.0) if left > 0 else inf
        up = max(falls[left + 1], own, 0.0) if left + 2 < x.size else inf
        down, up = (up if down == inf else down), (down if up == inf else up)
        if down == inf:  # two places: nothing is known but what they differ by
            down = up = abs(own)
        if down + up > 0.0:
            at_both = values[left] * up + values[left + 1] * down - down * up * width
            lowest = min(lowest, float(at_both / (down + up)))
    return float(values[place]) - lowest
