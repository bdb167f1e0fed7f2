"""Response over the mass of the particle: the best damper found for each of several masses, with all other quantities
chosen again.

The search for a mass starts from the best damper of the neighbouring mass, and moves one step of one quantity as
long as this is better. So each is only the best of the dampers examined, as drawn. The tuned mass damper of the same
mass is tuned under the same conditions.
"""

from dataclasses import dataclass, replace
from itertools import product

from damperlab.studies.design.absorber import tuned_beside
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
"""Number of masses over a range; one more if the recommended mass lies between them."""
MOST_LISTED = 7
"""Largest number of masses of a list."""
SHARES = (0.25, 0.5, 1.0, 1.5, 2.0)
"""Masses around a given one, as factors."""
WIDEST, FINEST = 1 / 8, 1 / 16
"""Steps of the other quantities, as fractions of their ranges."""
FULL = 2
"""Largest number of quantities for which every neighbour is examined."""
POOL = 4
"""Number of dampers of the main search from which the search for a known mass starts."""
SAME = 1e-9
"""Relative difference within which two masses are equal."""


@dataclass(frozen=True)
class OfMass:
    """The best damper found for one mass, as drawn.

    Parameters
    ----------
    build : Build
        The damper.
    score : Score
        Its worst case.
    looked_at : int
        Number of dampers of this mass that were examined.
    absorber : float or None
        Worst case of the tuned mass damper of this mass on the nominal structure; None without mass.
    particle_alone : float or None
        Worst case of the particle alone of this mass; None if it was not searched.
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
    """Choose the masses: over their range or, if the mass is given, around it and within its limit. The recommended mass
    is one of them.
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


def front_of(search: Search, best: Candidate, most: int) -> Step[tuple[OfMass, ...]]:
    """Find the best damper of every mass, from the recommended one towards lighter and heavier ones.

    Parameters
    ----------
    search : Search
        At its end.
    best : tuple of float
        Its recommendation.
    most : int
        Largest number of known points afterwards.

    Returns
    -------
    tuple of OfMass
        In the order of their masses; as many as the allowed points cover.
    """
    recommended = search.space.build(best)
    masses = masses_of(search.asked, recommended)
    place = masses.index(recommended.particle_mass_kg)
    found: dict[float, OfMass] = {}
    for path in (masses[place:], masses[:place][::-1]):
        start = _others(search, best)
        for mass in path:
            try:
                found[mass], start = yield from _best_of(search, mass, start, most)
            except BudgetSpent:
                break
    return tuple(found[mass] for mass in sorted(found))


def beside_particle_alone(
    front: tuple[OfMass, ...], search: Search, alone: Alternative | None
) -> tuple[OfMass, ...]:
    """Add the particle alone if it was searched for one of the masses."""
    if alone is None:
        return front
    value = search.score(alone.build).value
    return tuple(
        replace(each, particle_alone=value) if each.mass_kg == alone.build.particle_mass_kg else each
        for each in front
    )


def undominated(front: tuple[OfMass, ...]) -> tuple[OfMass, ...]:
    """Choose the masses that do better than every lighter one."""
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


def _best_of(search: Search, mass: float, start: Candidate, cap: int) -> Step[tuple[OfMass, Candidate]]:
    """Find the best damper of a mass, starting from that of a neighbour and from the search's own dampers of this
    mass.
    """
    asked = _with_mass(search.asked, mass)
    looking = _Looking(_looker(search, asked), Space(asked), set())
    looking.search.cap = cap
    try:
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
    finally:
        looking.search.cap = search.book.budget
    build = looking.space.build(looking.best())
    as_drawn = replace(search.asked, tolerances={})
    tuned = tuned_beside(as_drawn, mass / search.asked.structure.mass_kg)
    nominal = None if tuned is None else tuned.nominal
    return OfMass(build, looking.search.score(build), len(looking.known), nominal, None), looking.best()


def _looker(search: Search, asked: Specification) -> Search:
    """Give the search that examines dampers of a mass: the main one, or another if a lighter mass needs other
    frequencies.
    """
    heavier = asked.choices[MASS].stop > search.asked.choices[MASS].stop
    return Search(asked, search.book, told=False) if heavier else search


def _others(search: Search, candidate: Candidate) -> Candidate:
    """Give the fractions of the chosen quantities apart from the mass."""
    return tuple(share for name, share in zip(search.space.names, candidate, strict=True) if name != MASS)


def _around(space: Space, centre: Candidate, step: float) -> set[Candidate]:
    """Give the neighbours of a candidate, one step away: along all quantities together if there are at most `FULL`,
    else along one at a time.
    """
    steps = [max(step, 1.0 / (count - 1)) if count else step for count in space.counts]
    moves = product((-1.0, 0.0, 1.0), repeat=len(steps))
    kept = (move for move in moves if len(steps) <= FULL or sum(map(abs, move)) <= 1.0)
    return {
        space.candidate([x + size * m for x, size, m in zip(centre, steps, move, strict=True)])
        for move in kept
    }


def _pool(search: Search, mass: float) -> set[Candidate]:
    """Give the `POOL` best of the computed dampers of this mass, judged as drawn; without their mass."""
    same = (each for each in search.values if search.space.build(each).particle_mass_kg == mass)
    ranked = sorted(same, key=lambda each: (*search.score(search.space.build(each)).rank, each))
    return {_others(search, each) for each in ranked[:POOL]}


def _with_mass(asked: Specification, mass: float) -> Specification:
    return replace(asked, choices={**asked.choices, MASS: Choice(mass, mass)}, tolerances={})


def _limit(asked: Specification) -> float:
    """Give the heaviest mass that keeps its limit, including its tolerance."""
    limit = asked.damper_limits.get(MASS, float("inf"))
    return asked.tolerances[MASS].most(limit) if MASS in asked.tolerances else limit
