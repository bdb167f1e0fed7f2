"""The best damper without a particle, or without friction, for the same specification."""

from dataclasses import dataclass, replace

from damperlab.studies.design.book import Book, BudgetSpent
from damperlab.studies.design.build import Build
from damperlab.studies.design.optimisers import Effort
from damperlab.studies.design.score import Score
from damperlab.studies.design.search import Search
from damperlab.studies.design.steps import Step
from damperlab.studies.specification.specification import Choice, Specification
from damperlab.studies.variables import MADE_BY

SMALL = Effort(divided=10, starts=1, sizes=1, reserve=0.4, left=0.0)
"""Effort of the search for each alternative."""
LACKS = {
    "friction_alone": ("clearance_m", "particle_mass_kg", "restitution", *MADE_BY.values()),
    "particle_alone": ("friction_force_n",),
}
"""Quantities that each alternative lacks."""
CALLED = {"friction_alone": "friction alone", "particle_alone": "the particle alone"}


@dataclass(frozen=True)
class Alternative:
    """The best damper with friction alone or with a particle alone, for comparison with the designed damper.

    Parameters
    ----------
    build : Build
        The best damper found.
    score : Score
        Worst case of this damper over bands, amplitudes and the corners of the tolerances.
    complete : bool
        Whether the budget allowed the complete search.
    """

    build: Build
    score: Score
    complete: bool = True


def without(asked: Specification, parts: tuple[str, ...]) -> Specification:
    """Return the specification of a damper that lacks the quantities `parts`."""
    gone = {name: Choice(0.0, 0.0) if name != "clearance_m" else Choice(1.0, 1.0) for name in parts}
    kept = {name: each for name, each in asked.tolerances.items() if name not in parts}
    return replace(asked, choices={**asked.choices, **gone}, tolerances=kept)


def alternative(name: str, asked: Specification, book: Book, most: int) -> Step[Alternative]:
    """Search for the best damper of the kind `name` in `LACKS`, with at most `most` points.

    Raises
    ------
    BudgetSpent
        If the points do not suffice to judge a damper with its tolerances.
    """
    search = Search(without(asked, LACKS[name]), book, SMALL, told=False)
    best = yield from search.run(most)
    if not all(map(search.looked_at, search.with_corners(best))):
        raise BudgetSpent
    return Alternative(search.space.build(best), search.robust[best], not search.stopped)
