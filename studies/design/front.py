"""The best response of every mass that none lighter reaches."""

from damperlab.studies.design.score import Score
from damperlab.studies.design.search import CLOSEST, Search
from damperlab.studies.design.steps import Step


def front_of(search: Search) -> Step[tuple[tuple[float, Score], ...]]:
    """Know the best candidate of every mass that was looked at closely, and keep those that no lighter one reaches."""
    place = search.lattice.names.index("particle_mass_kg")
    found: list[tuple[float, Score]] = []
    for mass in sorted({each[place] for each in search.lattice.first()}):
        same = [each for each in search.pool if each[place] == mass]
        while True:
            build = search.lattice.build(
                min(same, key=lambda each: (*search.score(search.lattice.build(each)).rank, each))
            )
            if search.close(build):
                break
            yield from search.known([build], CLOSEST)
        found.append((build.particle_mass_kg, search.score(build)))
    kept: list[tuple[float, Score]] = []
    for weight, each in found:
        if all(each.rank < other.rank for _, other in kept):
            kept.append((weight, each))
    return tuple(kept)
