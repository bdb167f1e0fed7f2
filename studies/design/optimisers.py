"""scipy's optimisers as generators, which request values instead of computing them.

Each generator yields the candidates whose values it needs next, and continues once these values are known. A function
of scipy calls its objective and waits for the value. So an optimiser is restarted with the known values, and is stopped
when it asks for an unknown value. The requests depend only on the values. Restarting costs little compared with computing
values.
"""

from collections.abc import Generator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.design.space import Candidate, Space

Wants = Generator[list[Candidate], None, None]
Values = Mapping[Candidate, float]

STRETCH = 1.5
"""Size of the box that DIRECT divides, relative to the ranges. DIRECT samples only midpoints of boxes; if the first box
is larger than the ranges, some midpoints lie on the ends of the ranges.
"""
SIZES = (1 / 12, 1 / 48)
"""Sizes of simplices, as fractions of the ranges; a simplex of the smaller size starts at the best candidate so far."""
FAR = 1 / 8
"""Distance between the starts of the first simplices, as a fraction of the ranges."""
SHRUNK = 1 / 4
"""A simplex ends when it has shrunk to this fraction of its first size. The values at the corners
of the simplex do not decide when it ends, because these values never agree at a jump of the response.
"""
MOST_STEPS = 30
"""Largest number of evaluations of a simplex for each quantity."""


@dataclass(frozen=True)
class Effort:
    """Effort of a search.

    Parameters
    ----------
    divided : int
        Number of candidates, per chosen quantity, when the ranges are divided.
    starts : int
        Number of simplices of the first size.
    sizes : int
        Number of `SIZES` that are used.
    reserve : float
        Share of the points that is reserved for refining the best damper and, in the first search, for the later steps.
    left : float
        Share of the reserve that remains for the later steps.
    """

    divided: int = 25
    starts: int = 2
    sizes: int = 2
    reserve: float = 1 / 3
    left: float = 3 / 4


class _Ended(Exception):
    """Stops an optimiser that needs further values, or has enough candidates."""


def spread(space: Space, values: Values, effort: Effort) -> Wants:
    """Find candidates all over the ranges, more of them where the least value may lie.

    If there are few candidates, all of them are requested.

    Parameters
    ----------
    space : Space
        The candidates.
    values : mapping
        Values of known candidates; the caller adds the requested values.
    effort : Effort
        Effort of the search.
    """
    every = space.every()
    if every:
        yield every
    else:
        yield from _divided(space, values, effort.divided * len(space.names))


def _divided(space: Space, values: Values, count: int) -> Wants:
    """Divide the ranges where the least value may lie, until `count` candidates are known.

    D. R. Jones, C. D. Perttunen, B. E. Stuckman, J. Optim. Theory Appl. 79 (1993) 157, in the locally biased form of
    J. M. Gablonsky, C. T. Kelley, J. Glob. Optim. 21 (2001) 27. All candidates of an iteration are requested
    together.
    """
    from scipy.optimize import direct  # the light client imports this module, and has no scipy

    known: set[Candidate] = set()
    wanted: dict[Candidate, None] = {}

    def value(at: NDArray[np.float64]) -> float:
        candidate = space.candidate((0.5 + STRETCH * (at - 0.5)).tolist())
        if candidate in values:
            known.add(candidate)
            return values[candidate]
        wanted[candidate] = None
        return 0.0  # a placeholder: after this iteration the optimiser is restarted with the true value

    def ended(_: object) -> None:
        if wanted or len(known) >= count:
            raise _Ended

    box = [(0.0, 1.0)] * len(space.names)
    most = {"maxfun": 100 * count, "maxiter": 10 * count, "vol_tol": 0.0, "len_tol": 0.0}
    while True:
        known.clear()
        wanted.clear()
        with suppress(_Ended):
            direct(value, box, callback=ended, **most)
        if not wanted:
            return
        yield list(wanted)


def best_apart(values: Values, count: int) -> list[Candidate]:
    """Return at most `count` candidates, the best first, whose distances from each other exceed `FAR`."""
    chosen: list[Candidate] = []
    for each in sorted(values, key=lambda each: (values[each], each)):
        if all(max(abs(a - b) for a, b in zip(each, other, strict=True)) > FAR for other in chosen):
            chosen.append(each)
        if len(chosen) == count:
            break
    return chosen


def descended(space: Space, values: Values, starts: Sequence[Candidate], size: float) -> Wants:
    """Run the simplex method from several candidates in parallel. Quantities with listed values stay fixed.

    Parameters
    ----------
    space, values
        As in `spread`. The candidates in `starts` must be known.
    starts : sequence of tuple
        The candidates from which a simplex starts.
    size : float
        Size of each simplex, as a fraction of the ranges.
    """
    moved = [place for place, count in enumerate(space.counts) if not count]
    while moved:
        wanted = dict.fromkeys(
            each for start in starts for each in _next_of(space, values, start, moved, size)
        )
        if not wanted:
            return
        yield list(wanted)


def _next_of(
    space: Space, values: Values, start: Candidate, moved: list[int], size: float
) -> list[Candidate]:
    """Return the candidates whose values a simplex needs next; empty if the simplex has ended.

    J. A. Nelder, R. Mead, Comput. J. 7 (1965) 308.
    """
    from scipy.optimize import minimize

    wanted: list[Candidate] = []

    def candidate(at: NDArray[np.float64]) -> Candidate:
        shares = np.array(start)
        shares[moved] = at
        return space.candidate(shares.tolist())

    def value(at: NDArray[np.float64]) -> float:
        here = candidate(at)
        if here not in values:
            wanted.append(here)
            raise _Ended
        return values[here]

    corner = np.array(start)[moved]
    simplex = np.vstack([corner, corner + size * np.diag(np.where(corner + size > 1.0, -1.0, 1.0))])
    first = [each for each in map(candidate, simplex) if each not in values]
    if first:
        return first
    options: dict[str, Any] = {"initial_simplex": simplex, "xatol": SHRUNK * size, "fatol": np.inf}
    options |= {"maxfev": MOST_STEPS * len(moved), "adaptive": len(moved) > 2}
    with suppress(_Ended):
        minimize(value, corner, method="Nelder-Mead", bounds=[(0.0, 1.0)] * len(moved), options=options)
    return wanted
