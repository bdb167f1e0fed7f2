"""Response as a function of the particle's mass: the best damper found for each mass, with all other quantities chosen
again.

The search at each mass starts from the best damper of the neighbouring mass. It changes the other quantities step by
step as long as the response improves. Each result is the best of the examined dampers, judged without tolerances. A
tuned mass damper of the same mass is tuned under the same conditions.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

from damperlab.studies.design.absorber import least_beside
from damperlab.studies.design.alternatives import Alternative
from damperlab.studies.design.book import BudgetSpent
from damperlab.studies.design.build import Build
from damperlab.studies.design.score import Score
from damperlab.studies.design.search import CLOSE, CLOSEST, Asks, Search
from damperlab.studies.design.space import Candidate, Space
from damperlab.studies.design.steps import Step
from damperlab.studies.specification.specification import Choice, Specification

MASS = "particle_mass_kg"
MASSES = 5
"""Number of masses tried over a range. The recommended mass is added if it is not among these masses."""
MOST_LISTED = 7
"""Largest number of masses taken from a list of allowed masses."""
SHARES = (0.25, 0.5, 1.0, 1.5, 2.0)
"""Masses around a given mass, as multiples of the given mass."""
WIDEST, FINEST = 1 / 8, 1 / 16
"""Largest and smallest step of the other quantities, as fractions of their ranges."""
FULL = 2
"""Largest number of quantities that are changed together. With more quantities, each step changes one."""
POOL = 4
"""Number of dampers from the main search with which the search at one mass starts."""
SAME = 1e-9
"""Relative difference within which two masses are equal."""


@dataclass(frozen=True)
class OfMass:
    """The best damper found for one mass, judged without tolerances.

    Parameters
    ----------
    build : Build
        The damper.
    score : Score
        Worst case of the damper without tolerances.
    looked_at : int
        Number of dampers of this mass that were examined.
    absorber : float or None
        Worst case of the tuned mass damper of this mass on the nominal structure; None if there is no such damper.
    particle_alone : float or None
        Worst case of a particle of this mass without friction; None if there was no search.
    """

    build: Build
    score: Score
    looked_at: int
    absorber: float | None
    particle_alone: float | None

    @property
    def mass_kg(self) -> float:
        """The mass of the particle."""
        return self.build.particle_mass_kg


def masses_of(asked: Specification, recommended: Build) -> list[float]:
    """Return the masses for which the best damper is searched, including the recommended mass.

    The masses cover the specified range. If the specification gives a single mass, the masses surround this mass.
    """
    choice, own = asked.choices[MASS], recommended.particle_mass_kg
    if choice.values:
        count = min(len(choice.values), MOST_LISTED)
        every = [choice.at(k / max(count - 1, 1)) for k in range(count)]
    elif choice.free:
        every = [choice.at(k / (MASSES - 1)) for k in range(MASSES)]
    else:
        most = _limit(asked)
        every = [share * own for share in SHARES if share * own <= most]
        every += [most] if own < most < SHARES[-1] * own else []
    kept = [mass for mass in every if abs(mass - own) > SAME * own]
    return sorted({*kept, own})


def follow(
    search: Search, best: Candidate, masses: Sequence[float], found: dict[float, tuple[OfMass, Candidate]]
) -> Step[bool]:
    """Find the best damper for each mass, one mass after the other.

    Parameters
    ----------
    search : Search
        The completed search.
    best : tuple of float
        The recommended candidate, from which the search for the first mass starts.
    masses : sequence of float
        Masses on one side of the recommended mass, the nearest first.
    found : dict
        For each mass, the best damper and its candidate without the mass. The masses found are added.

    Returns
    -------
    bool
        Whether the points sufficed for every mass.
    """
    start = _others(search, best)
    for mass in masses:
        if mass not in found:
            try:
                found[mass] = yield from _best_of(search, mass, start)
            except BudgetSpent:
                return False
        start = found[mass][1]
    return True


def beside_particle_alone(
    front: tuple[OfMass, ...], search: Search, alone: Alternative | None
) -> tuple[OfMass, ...]:
    """Add the worst case of the particle alone to the entry of the same mass, if this entry exists."""
    if alone is None:
        return front
    value = search.score(alone.build).value
    return tuple(
        replace(each, particle_alone=value) if each.mass_kg == alone.build.particle_mass_kg else each
        for each in front
    )


def undominated(front: tuple[OfMass, ...]) -> tuple[OfMass, ...]:
    """Return the entries whose damper is better than the best damper of every lighter mass."""
    kept: list[OfMass] = []
    for each in front:
        if all(each.score.rank < other.score.rank for other in kept):
            kept.append(each)
    return tuple(kept)


@dataclass
class _Looking:
    """The examined dampers of one mass."""

    search: Search
    space: Space
    known: set[Candidate]

    def best(self) -> Candidate:
        return min(self.known, key=lambda each: (*self.search.score(self.space.build(each)).rank, each))

    def closer(self, level: int) -> Asks:
        """Refine the best candidate until its value is known closely enough."""
        while True:
            best = self.best()
            yield from self.search.known([self.space.build(best)], level)
            if self.best() == best:
                return


def _best_of(search: Search, mass: float, start: Candidate) -> Step[tuple[OfMass, Candidate]]:
    """Find the best damper with a particle of one mass.

    The search starts from the best damper of a neighbouring mass, and from dampers of this mass that the main search
    examined.
    """
    asked = _with_mass(search.asked, mass)
    looking = _Looking(_looker(search, asked), Space(asked), set())
    yield from looking.search.known([looking.space.build(start)], CLOSE)
    looking.known = {start, *_pool(search, mass)}
    yield from looking.closer(CLOSE)
    step = WIDEST
    while step >= FINEST and looking.space.names:
        best = looking.best()
        around = set(_around(looking.space, best, step))
        yield from looking.search.known(map(looking.space.build, sorted(around)), 0)
        looking.known |= around
        yield from looking.closer(CLOSE)
        step = step / 2 if looking.best() == best else step
    yield from looking.closer(CLOSEST)
    build = looking.space.build(looking.best())
    absorber = least_beside(search.asked, mass / search.asked.structure.mass_kg)
    return OfMass(build, looking.search.score(build), len(looking.known), absorber, None), looking.best()


def _looker(search: Search, asked: Specification) -> Search:
    """Return the search that examines dampers with a particle of one mass.

    The main search is used if the mass is within the specified range. A heavier particle needs other frequencies, so a
    new search is made.
    """
    heavier = asked.choices[MASS].stop > search.asked.choices[MASS].stop
    return Search(asked, search.book, told=False) if heavier else search


def _others(search: Search, candidate: Candidate) -> Candidate:
    """Return a candidate without the entry of the mass."""
    return tuple(share for name, share in zip(search.space.names, candidate, strict=True) if name != MASS)


def _around(space: Space, centre: Candidate, step: float) -> set[Candidate]:
    """Return the neighbours of a candidate, one step away.

    With at most `FULL` quantities, a step may change several at once; otherwise it changes only one.
    """
    steps = [max(step, 1.0 / (count - 1)) if count else step for count in space.counts]
    moves = product((-1.0, 0.0, 1.0), repeat=len(steps))
    kept = (move for move in moves if len(steps) <= FULL or sum(map(abs, move)) <= 1.0)
    return {
        space.candidate([x + size * m for x, size, m in zip(centre, steps, move, strict=True)])
        for move in kept
    }


def _pool(search: Search, mass: float) -> set[Candidate]:
    """Return, as candidates without the mass, the `POOL` best nominal dampers of one mass among the examined dampers."""
    same = (each for each in search.examined if search.space.build(each).particle_mass_kg == mass)
    ranked = sorted(same, key=lambda each: (*search.score(search.space.build(each)).rank, each))
    return {_others(search, each) for each in ranked[:POOL]}


def _with_mass(asked: Specification, mass: float) -> Specification:
    return replace(asked, choices={**asked.choices, MASS: Choice(mass, mass)}, tolerances={})


def _limit(asked: Specification) -> float:
    """Return the largest mass that keeps the limit on the mass even at the upper end of its tolerance."""
    limit = asked.damper_limits.get(MASS, float("inf"))
    return asked.tolerances[MASS].most(limit) if MASS in asked.tolerances else limit
