"""Results for comparison with the recommended damper: margins, other amplitudes, other masses, and other kinds of
damper.
"""

from dataclasses import dataclass, field

from damperlab.studies.design.alternatives import CALLED, LACKS, Alternative, alternative
from damperlab.studies.design.build import Build
from damperlab.studies.design.front import OfMass, beside_particle_alone, follow, masses_of
from damperlab.studies.design.margins import MOVED, Margin, margins_of
from damperlab.studies.design.score import Score
from damperlab.studies.design.search import CLOSE, Search
from damperlab.studies.design.space import Candidate
from damperlab.studies.design.steps import Part, Step, share_out
from damperlab.studies.specification.excitation import Amplitude

OF_MASS = "response against mass"
HEAVIER, LIGHTER = f"{OF_MASS}, heavier", f"{OF_MASS}, lighter"


@dataclass
class Surroundings:
    """Results for comparison with the recommended damper.

    Parameters
    ----------
    search : Search
        The completed search.
    best : tuple of float
        The recommended candidate.
    stated : Score
        Worst case of the recommended damper.
    shown : tuple of Amplitude
        Amplitudes under which the response is shown.
    """

    search: Search
    best: Candidate
    stated: Score
    shown: tuple[Amplitude, ...] = ()
    alternatives: dict[str, Alternative] = field(default_factory=dict)
    margins: dict[str, Margin] | None = None
    front: tuple[OfMass, ...] = ()

    @property
    def build(self) -> Build:
        """The recommended damper."""
        return self.search.space.build(self.best)

    def look(self) -> Step[list[str]]:
        """Compute the results as far as the budget allows, and return the names of the results that are incomplete."""
        parts: dict[str, Part] = {f"the best of {CALLED[name]}": self._alternative(name) for name in LACKS}
        parts[MOVED] = self._margins
        masses = masses_of(self.search.asked, self.build) if self._has_mass else []
        of_mass: dict[float, tuple[OfMass, Candidate]] = {}
        if masses:
            own = masses.index(self.build.particle_mass_kg)
            parts[HEAVIER] = self._path(masses[own:], of_mass)
            parts[LIGHTER] = self._path(masses[:own][::-1], of_mass)
        if self.shown:
            parts["amplitudes beyond the range"] = self._shown
        self.search.room = self.search.book.left
        left_out = yield from share_out(self.search.book, parts)
        self.search.room = self.search.book.left
        front = tuple(of_mass[mass][0] for mass in sorted(of_mass))
        self.front = beside_particle_alone(front, self.search, self.alternatives.get("particle_alone"))
        left_out = [each for each in left_out if each not in (HEAVIER, LIGHTER)]
        if len(front) < len(masses):
            missing = f" for {len(masses) - len(front)} of {len(masses)} masses" if front else ""
            left_out.append(OF_MASS + missing)
        found = {f"the best of {CALLED[name]}" for name in self.alternatives}
        return [f"the rest of the search for {each}" if each in found else each for each in left_out]

    @property
    def _has_mass(self) -> bool:
        """Whether the damper has a particle, or the specification allows more than one mass of the particle."""
        return self.build.particle_mass_kg > 0.0 or self.search.asked.choices["particle_mass_kg"].free

    def _alternative(self, name: str) -> Part:
        def part(most: int) -> Step[bool]:
            found = yield from alternative(name, self.search.asked, self.search.book, most)
            self.alternatives[name] = found
            return found.complete

        return part

    def _margins(self, _: int) -> Step[bool]:
        self.margins = yield from margins_of(self.search, self.build, self.stated)
        return True

    def _path(self, masses: list[float], found: dict[float, tuple[OfMass, Candidate]]) -> Part:
        return lambda _: follow(self.search, self.best, masses, found)

    def _shown(self, _: int) -> Step[bool]:
        yield from self.search.known([self.build], CLOSE, self.shown)
        return True
