"""The design of a damper: the search, random builds, the margin of each quantity, and the alternatives."""

from collections.abc import Generator, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from damperlab.studies.design.absorber import tuned_beside
from damperlab.studies.design.alternatives import LACKS
from damperlab.studies.design.book import Book
from damperlab.studies.design.build import Build
from damperlab.studies.design.builds import counted_builds, drawn
from damperlab.studies.design.found import Found
from damperlab.studies.design.score import Score, binding, over_bands, score, worst
from damperlab.studies.design.search import CLOSE, FEW, SURE, Search
from damperlab.studies.design.space import FACTORIAL, amplitudes_of, every_corner
from damperlab.studies.design.starts import started, starts_of
from damperlab.studies.design.steps import Step, Studies, in_studies, within
from damperlab.studies.design.surroundings import Surroundings
from damperlab.studies.faults import Fault, StudyFaults, counted
from damperlab.studies.specification.excitation import Amplitude, Excitation
from damperlab.studies.specification.specification import STARTS, Specification

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Ask", "Found", "Rounds", "designing"]

AMPLITUDES = 7
"""Number of base amplitudes under which the recommended damper is judged."""
SHOWN = 7
"""Number of base amplitudes in the figure that shows where the damper stops working."""


@dataclass(frozen=True)
class Ask:
    """The next step of a search.

    Parameters
    ----------
    studies : tuple of Study or Suite
        Studies to compute; studies that are stored already need not be computed again.
    stage : str
        Purpose of the studies, in words.
    spent, budget : int
        Number of known points, and largest number of points.
    ahead : (Build, Score) or None
        The best damper so far, and its known worst case without tolerances; None before the first dampers are computed.
    """

    studies: Studies
    stage: str
    spent: int
    budget: int
    ahead: tuple[Build, Score] | None


Rounds = Generator[Ask, "Iterable[xr.Dataset]", Found]
"""A generator that requests studies, receives the cubes of the studies, and returns the findings."""


def designing(asked: Specification, budget: int) -> Rounds:
    """Search for a damper: request the studies that are needed next, receive their cubes, and return the findings.

    The requests depend only on the specification, the budget and the values of the cubes. So an interrupted search can
    be restarted, and reads the results of completed studies from the store.

    Parameters
    ----------
    asked : Specification
        The specification.
    budget : int
        Largest number of points. The search leaves at least a quarter of the budget for the later steps.

    Raises
    ------
    StudyFaults
        If half of the budget does not cover the coarse computation of the first candidates.
    """
    book = Book(asked, budget)
    rounds = in_studies(book, _steps(asked, book))
    try:
        while True:
            studies = next(rounds)
            book.add((yield Ask(studies, book.stage, book.spent, budget, _ahead(book))))
    except StopIteration as end:
        found: Found = end.value
        return found


def _ahead(book: Book) -> tuple[Build, Score] | None:
    best = book.ahead
    return None if best is None else (best, score(book, best, amplitudes_of(book.asked, FEW)))


def _steps(asked: Specification, book: Book) -> Step[Found]:
    search = Search(asked, book)
    _require(search)
    best = yield from search.run()
    left: list[str] = []
    scan = amplitudes_of(asked, AMPLITUDES)
    amplitudes = over_bands(scan)
    looks = [(len(amplitudes), "amplitude"), (len(asked.cases), "case")]
    of_what = " and ".join(counted(count, what) for count, what in looks if count)
    while True:
        build = book.ahead = search.space.build(best)
        compared = search.robust[best]
        book.stage = f"the damper as drawn, under {of_what}"
        yield from within(search.known([build], CLOSE + 1, scan), left, "further amplitudes of the range")
        nominal = score(book, build, (*scan, *search.amplitudes))
        judged = [compared, nominal]
        if nominal.violation <= compared.violation:
            break
        # a damper that exceeds a limit only under further amplitudes is replaced by a damper that keeps this limit
        search.robust[best] = worst(judged)
        yield from within(search.assured(), left, "dampers that keep the limits")
        previous, best = best, search.best()
        if best == previous:
            break
    over: Score | None = None
    shown: tuple[Amplitude, ...] = ()
    if amplitudes:
        over = score(book, build, (*amplitudes, *over_bands(search.amplitudes)))
        excitation = binding(asked, over)
        book.stage = f"the damper as drawn, from {STARTS} starts"
        yield from within(started(search, build, over), left, "other starts than rest")
        levels = np.geomspace(*beyond_of(excitation), SHOWN)
        shown = tuple(Amplitude(excitation, float(each)) for each in levels)
    corners: list[Build] = []
    if len(asked.toleranced) > FACTORIAL:
        book.stage = "the corners of the tolerances that the search left out"
        corners = [build.moved(asked, each) for each in every_corner(asked)]
        yield from within(_look_at(search, corners), left, "every corner of the tolerances")
    builds: list[Build] = []
    if asked.tolerances and asked.builds:
        book.stage = "builds drawn within the tolerances"
        builds = (yield from within(drawn(search, build), left, "builds within the tolerances")) or []
    beside = Surroundings(search, best, worst(judged), shown)
    left += yield from beside.look()
    scores = [search.score(each) for each in builds]
    stated = worst([*judged, *map(search.score, filter(search.looked_at, corners)), *scores])
    return Found(
        asked=asked,
        book=book,
        build=build,
        nominal=nominal,
        over=over,
        under=tuple(
            score(book, build, (*each.amplitudes(AMPLITUDES), *each.amplitudes(FEW)))
            for each in asked.excitations
        ),
        compared=compared,
        stated=stated,
        builds=counted_builds(asked, scores, worst(judged).most) if scores else None,
        margins=beside.margins or {},
        alternatives={name: beside.alternatives[name] for name in LACKS if name in beside.alternatives},
        absorber=tuned_beside(asked, build.particle_mass_kg / asked.structure.mass_kg),
        front=beside.front,
        shown=tuple(each for each in shown if book.curve(build, each).r.size),
        starts=starts_of(asked, book, build, binding(asked, over).largest, stated.most) if over else None,
        stopped=search.stopped or "complete",
        ended=search.ended,
        looked_at=len(search.examined),
        left_out=tuple(left),
    )


def _look_at(search: Search, corners: list[Build]) -> Step[None]:
    """Compute every corner of the tolerances, and the corner with the largest response as accurately as the damper."""
    yield from search.known(corners, CLOSE)
    yield from search.known([max(corners, key=lambda each: search.score(each).value)], SURE)


def beyond_of(excitation: Excitation) -> tuple[float, float]:
    """Return the ends of the shown range of base amplitudes: half the smallest and twice the largest amplitude."""
    return excitation.lowest_m / 2.0, excitation.highest_m * 2.0


def _require(search: Search) -> None:
    """Refuse a budget unless half of it covers the coarse computation of the first candidates."""
    first = search.book.lacking(search.first_look())
    if first <= search.book.budget / 2:
        return
    found, dampers = f"{search.book.budget:,} points", counted(len(search.first()), "damper")
    told = (
        f"{{field}} allows {found}. The first look at {dampers} takes {first:,}, and may take at most half of the budget; "
        "the later steps need the rest."
    )
    key = search.asked.budget_key
    more = key.removeprefix("budget_")
    advice = f"give more {more}, choose fewer quantities, or give one amplitude in place of a range"
    raise StudyFaults([Fault(key, found, f"at least {2 * first:,} points", advice, told)])
