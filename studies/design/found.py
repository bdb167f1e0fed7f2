"""Findings of a search."""

from dataclasses import dataclass
from functools import cached_property

from damperlab.studies.brief import Damper
from damperlab.studies.design.absorber import Beside, tuned_beside
from damperlab.studies.design.alternatives import Alternative
from damperlab.studies.design.book import Book
from damperlab.studies.design.build import Build
from damperlab.studies.design.builds import Builds
from damperlab.studies.design.front import OfMass
from damperlab.studies.design.margins import Margin
from damperlab.studies.design.score import Score, binding, score
from damperlab.studies.design.starts import Starts
from damperlab.studies.ground.brief import HELD
from damperlab.studies.specification.damper import QUANTITIES
from damperlab.studies.specification.excitation import Amplitude, Excitation
from damperlab.studies.specification.specification import OF_DAMPER, Specification
from damperlab.studies.variables import ResponseClass


@dataclass(frozen=True)
class Found:
    """All findings of a search.

    Parameters
    ----------
    asked, book : Specification, Book
        The specification, and the results of all known points.
    build : Build
        The best damper found, or the given damper. This damper is recommended unless another kind does better.
    nominal, compared, stated : Score
        Worst cases of `build`. `nominal` is the worst case without tolerances. `compared` includes the corners of the
        tolerances, and is comparable with the alternatives. `stated` includes all results computed for the damper.
    builds : Builds or None
        Results of builds within the tolerances; None without tolerances, or if the budget covers no build.
    margins : dict of Margin
        The margin of each quantity.
    alternatives : dict of Alternative
        The best damper with friction alone, and the best damper with a particle alone.
    absorber : Beside or None
        The tuned mass damper of the same mass.
    front : tuple of OfMass
        The best damper found for each of several masses, the lightest first; empty without a particle.
    over : Score or None
        Worst case of the nominal damper over the bands alone; None if there is no band.
    under : tuple of Score
        Worst case of the nominal damper under each excitation over a band.
    shown : tuple of Amplitude
        Amplitudes of the binding excitation at which the response of the nominal damper is known at every frequency
        of the survey. Some of these amplitudes lie beyond the range of the excitation.
    starts : Starts or None
        Responses after starts other than rest; None if the budget did not cover these responses.
    stopped : str
        "complete", or "budget" if the budget stopped the search.
    ended : str
        Reason for the end of the search: "converged", "lists" (every combination of the listed values was examined),
        "budget", or "nothing" (nothing was to be chosen).
    looked_at : int
        Number of dampers that the search examined.
    left_out : tuple of str
        Steps that the budget did not cover.
    """

    asked: Specification
    book: Book
    build: Build
    nominal: Score
    compared: Score
    stated: Score
    builds: Builds | None
    margins: dict[str, Margin]
    alternatives: dict[str, Alternative]
    absorber: Beside | None
    front: tuple[OfMass, ...]
    over: Score | None
    under: tuple[Score, ...]
    shown: tuple[Amplitude, ...]
    starts: Starts | None
    stopped: str
    ended: str
    looked_at: int
    left_out: tuple[str, ...]

    @property
    def others(self) -> dict[Damper, Alternative]:
        """The alternatives whose kind differs from the kind of the damper found."""
        return {kind: self.alternatives[kind] for kind in self._other_kinds if kind in self.alternatives}

    @property
    def not_compared(self) -> list[Damper]:
        """The other kinds of damper that the budget did not cover."""
        return [kind for kind in self._other_kinds if kind not in self.alternatives]

    @property
    def _other_kinds(self) -> list[Damper]:
        parts: dict[Damper, float] = {
            "friction_alone": self.build.particle_mass_kg,
            "particle_alone": self.build.friction_force_n,
        }
        return [kind for kind, part in parts.items() if part]

    @property
    def largest(self) -> float:
        """The largest computed worst case of the damper."""
        return max(self.compared.value, self.stated.value)

    def otherwise(self, limit: str) -> str:
        """Return a change of the specification, in words, that may help to keep a limit without relaxing the limit."""
        if self.nominal.reached[limit] <= self.asked.limits[limit]:
            return "narrow the tolerances"
        return "widen the ranges to choose from" if self.asked.free else "let a quantity be chosen"

    @cached_property
    def heaviest(self) -> Beside | None:
        """The most effective tuned mass damper, which has the largest allowed mass; None if no mass is allowed."""
        most = self.asked.choices["particle_mass_kg"].stop
        if most == self.build.particle_mass_kg:
            return self.absorber
        return tuned_beside(self.asked, most / self.asked.structure.mass_kg)

    @property
    def under_records(self) -> tuple[Score, ...]:
        """Worst case of the nominal damper under each excitation that consists of records or a sweep."""
        return tuple(score(self.book, self.build, each.cases) for each in self.asked.records)

    @property
    def binding(self) -> Excitation:
        """The excitation with the stated worst case.

        If that worst case is under a record, this is the excitation with the worst case over the bands.
        """
        assert self.over is not None  # callers make sure that there is a band
        return binding(self.asked, self.stated, self.over)


def at_ends(found: Found) -> dict[str, str]:
    """Return "lower" or "upper" for each chosen quantity whose value is at an end of the range."""
    ends: dict[str, str] = {}
    asked = found.asked
    for name in (each for each in OF_DAMPER if each in asked.free or each in asked.bounds):
        choice, value = asked.choices[name], found.build.value(name)
        if not (name == "friction_force_n" or found.build.particle_mass_kg > 0.0):
            continue
        if value in (QUANTITIES[name].lowest, QUANTITIES[name].highest):
            continue  # no value beyond the end of the range is possible
        if value in (choice.start, choice.stop) and not (choice.values and choice.start == choice.stop):
            # if a limit leaves only one value of a range, that value is the upper end
            ends[name] = "upper" if value == choice.stop else "lower"
    return ends


def locked(found: Found, build: Build | None = None) -> bool:
    """Whether friction locks the nominal structure to its base under every excitation.

    The structure must be locked at every computed frequency under the largest amplitude, and under every record.

    Parameters
    ----------
    found : Found
        The findings of the search.
    build : Build, optional
        The damper; by default the damper found.
    """
    build = build or found.build
    curves = (found.book.curve(build, case) for case in found.asked.cases)
    if not all(bool((curve["stick_fraction"] >= HELD).all()) for curve in curves):
        return False
    if not found.asked.excitations:
        return True
    curve = found.book.curve(build, found.binding.largest)
    return bool((curve["response_class"] == ResponseClass.LOCKED).all())
