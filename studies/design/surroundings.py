"""Results for comparison with the recommended damper: margins, other amplitudes, other masses, and other kinds of
damper.
"""

from dataclasses import dataclass, field

from damperlab.studies.design.alternatives import CALLED, LACKS, Alternative, alternative
from damperlab.studies.design.build import Build
from damperlab.studies.design.front import OfMass, beside_particle_alone, front_of, masses_of
from damperlab.studies.design.margins import MOVED, Margin, margins_of
from damperlab.studies.design.score import Score
from damperlab.studies.design.search import CLOSE, Search
from damperlab.studies.design.space import Candidate
from damperlab.studies.design.steps import Part, Step, share_out
from damperlab.studies.specification.excitation import Amplitude

OF_MASS = "response against mass"


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
        if masses:
            parts[OF_MASS] = self._front
        if self.shown:
            parts["amplitudes beyond the range"] = self._shown
        left_out = yield from share_out(self.search.book, parts)
        self.search.cap = self.search.book.budget
        self.front = beside_particle_alone(self.front, self.search, self.alternatives.get("particle_alone"))
        if OF_MASS in left_out and self.front:
            missing = len(masses) - len(self.front)
            left_out[left_out.index(OF_MASS)] = f"{OF_MASS} for {missing} of {len(masses)} masses"
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

    def _margins(self, most: int) -> Step[bool]:
        self.search.cap = most
        self.margins = yield from margins_of(self.search, self.build, self.stated)
        return True

    def _front(self, most: int) -> Step[bool]:
        self.front = yield from front_of(self.search, self.best, most)
        return len(self.front) == len(masses_of(self.search.asked, self.build))

    def _shown(self, most: int) -> Step[bool]:
        self.search.cap = most
        yield from self.search.known([self.build], CLOSE, self.shown)
        return True
