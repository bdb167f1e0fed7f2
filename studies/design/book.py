"""The book of a search: the results of all known points, and the studies that compute missing points."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.amplitudes import AMPLITUDE, RATIOS_OF
from damperlab.studies.answers.design_question import DESIGN
from damperlab.studies.answers.excited import definition_of, excitation_of
from damperlab.studies.answers.follow_up import cover
from damperlab.studies.cavity import cavity_of
from damperlab.studies.definition import Study, parse_harmonic
from damperlab.studies.design.build import FORCE, NOTHING_INSIDE, Build, Inside, Law, Place, Spot
from damperlab.studies.design.curve import Curve
from damperlab.studies.design.suites import RECORD_VARIABLES, contact_time_of, known_of, suites_of
from damperlab.studies.ground.suite import Suite
from damperlab.studies.ground.variables import RECORD
from damperlab.studies.specification.excitation import ONCE, Amplitude, Case, Under
from damperlab.studies.specification.measure import LIMITS, MEASURES
from damperlab.studies.specification.specification import STARTS, Specification
from damperlab.studies.variables import BEFORE, MADE_BY, Status

if TYPE_CHECKING:
    import xarray as xr

VARIABLES = (
    "amplitude_ratio",
    "relative_amplitude_ratio",
    "amplitude_error",
    "impact_speed_max",
    "impacts_per_cycle",
    "response_class",
)
"""Variables stored for every point, in addition to the variables of the measure and of the limits."""
BESIDE = {ratio: name for name, ratio in RATIOS_OF.items()}
"""For each ratio, the dimension that replaces this ratio in studies over base amplitudes."""
WORST = "amplitude_ratio_worst"
"""Variable of the largest amplitude over all starts."""
OF_STARTS = (
    WORST,
    "attractors",
    "attractor_share",
    "attractor_share_second",
    "amplitude_ratio_second",
    "attractor_share_third",
    "amplitude_ratio_third",
)
"""Variables stored for a study from several starts."""
SEED = 20
"""Seed for random starts, and for random builds within the tolerances."""
ENSEMBLE = {"kind": "ensemble", "n": STARTS, "seed": SEED}
"""The value of `start` in a study from several starts."""
ABOUT_THE_RUN = ("cycles", "run_time", "status")
"""Additional variables that describe the computation of a point."""
STUDY_COST = 40
"""Overhead of a study, expressed as a number of points."""
MOST_MERGED = 40
"""Largest number of groups of designs for which every pair of groups is examined for joining."""


class BudgetSpent(Exception):
    """The next step would exceed the budget. All computed points stay known."""


@dataclass(frozen=True)
class Wanted:
    """Points to compute for a build, under an amplitude at several frequencies or under a record.

    Frequencies are relative to the natural frequency of the build.
    """

    build: Build
    amplitude: Under
    frequencies: tuple[float, ...]


class _Kind(NamedTuple):
    """Values that all designs of a study share. `particle` says whether the designs have a particle."""

    amplitude_m: float
    particle: bool
    law: Law
    inside: Inside


@dataclass
class _Group:
    """Designs to compute at the same frequencies."""

    designs: set[Place]
    frequencies: frozenset[float]
    grids: list[list[NDArray[np.float64]]] = field(default_factory=list)

    def cut(self) -> "_Group":
        """Find grids that together contain all designs. Each grid becomes a study."""
        rows = np.array(sorted(self.designs))
        self.grids = cover(rows, most=max(8, len(rows)))
        return self

    @property
    def cost(self) -> int:
        """Number of points of the studies, plus `STUDY_COST` for each study."""
        cells = sum(int(np.prod([axis.size for axis in grid])) for grid in self.grids)
        return cells * len(self.frequencies) + STUDY_COST * len(self.grids)


class Book:
    """All known points of a search, by the parameters of the damper and the frequency.

    Parameters
    ----------
    asked : Specification
        The specification.
    budget : int
        Largest number of points.
    """

    def __init__(self, asked: Specification, budget: int) -> None:
        self.asked = asked
        self.budget = budget
        limited = [name for limit in asked.limits for name in LIMITS[limit].over_band]
        measured = [MEASURES[asked.measure.name].variable] if asked.excitations else []
        self.variables = tuple(dict.fromkeys((*VARIABLES, *measured, *limited)))
        """Variables stored for a point."""
        self.spent = 0
        self.stage = ""
        """The current activity, for display only."""
        self.ahead: Build | None = None
        """The best damper so far, for display only."""
        self.from_many_starts: list[xr.Dataset] = []
        """Cubes of the recommended damper from several starts; empty before the computation."""
        self._known: dict[tuple[Spot, float], tuple[float, ...]] = {}
        self._frequencies: dict[Spot, set[float]] = {}
        """Frequencies that were requested or computed, for each damper and amplitude."""
        self._curves: dict[tuple[Build, Under], Curve] = {}

    @property
    def left(self) -> int:
        """Number of points that the budget still allows."""
        return self.budget - self.spent

    def lacking(self, wanted: Iterable[Wanted]) -> int:
        """Count the wanted points that are unknown."""
        asked = ((each.build.spot(self.asked.structure, each.amplitude), each.frequencies) for each in wanted)
        return len({(spot, r) for spot, frequencies in asked for r in frequencies} - self._known.keys())

    def studies(self, wanted: Iterable[Wanted]) -> tuple[Study | Suite, ...]:
        """Return studies that compute the unknown points among `wanted`, in a deterministic order."""
        under_records: set[Spot] = set()
        lacking: dict[tuple[float, Spot], set[float]] = {}
        for each in wanted:
            spot = each.build.spot(self.asked.structure, each.amplitude)
            if isinstance(each.amplitude, Case):
                if (spot, ONCE[0]) not in self._known:
                    under_records.add(spot)
                continue
            self._frequencies.setdefault(spot, set()).update(each.frequencies)
            for r in each.frequencies:
                if (spot, r) not in self._known:
                    lacking.setdefault((each.amplitude.reference_m, spot), set()).add(r)
        groups: dict[tuple[_Kind, frozenset[float]], set[Place]] = {}
        for (amplitude, (law, place, contact)), frequencies in lacking.items():
            kind = _Kind(amplitude, place[2] > 0.0, law, contact)
            groups.setdefault((kind, frozenset(frequencies)), set()).add(place)
        made: list[Study | Suite] = [*suites_of(self.asked, under_records)]
        for kind in sorted({kind for kind, _ in groups}):
            sets = [
                _Group(designs, frequencies)
                for (other, frequencies), designs in sorted(groups.items(), key=lambda one: sorted(one[0][1]))
                if other == kind
            ]
            for group in _merged(sets):
                made += [self._study(kind, grid, group.frequencies) for grid in group.grids]
        return tuple({study.digest: study for study in made}.values())

    def _study(
        self,
        kind: "_Kind",
        grid: list[NDArray[np.float64]],
        frequencies: Iterable[float],
        **more: object,
    ) -> Study:
        """Make the study of a grid of dampers at some frequencies; `more` replaces settings of the study."""
        damping, restitution, mass, clearance, friction = (axis.tolist() for axis in grid)
        axes: dict[str, object] = {"frequency_ratio": sorted(set(frequencies))}
        particle = kind.particle
        if particle:
            axes |= {"restitution": restitution, "mass_ratio": mass}
        document = {
            "name": f"{self.asked.name}, design" if self.asked.name else "design",
            "damping_ratio": damping,
            "particle": particle,
            "metrics": [*self.variables, *ABOUT_THE_RUN],
        }
        if self.asked.judge != "rest":
            document["start"] = ENSEMBLE
        if self.asked.judge == "worst":
            document["metrics"] = [*self.variables, *ABOUT_THE_RUN, WORST]
        contact_time, *beside = kind.inside
        if contact_time:
            document["contact"] = {"model": "dwell", "contact_time": contact_time}
        if kind.law == FORCE:
            document["excitation"] = "force"
        elif len(kind.law) == 4:
            constant, amplitude, structure_kg, natural_hz = kind.law
            physical = {
                "mass_kg": structure_kg,
                "natural_frequency_hz": natural_hz,
                AMPLITUDE: [amplitude],
                "friction_force_n": friction,
                "constant": constant,
            }
            physical |= {"clearance_m": clearance} if particle else {}
            physical |= {name: value for name, value in zip(MADE_BY.values(), beside, strict=True) if value}
            return parse_harmonic(document | {"axes": axes, "physical": physical} | more)
        document |= {name: value for name, value in zip(BEFORE, beside, strict=True) if value}
        axes |= {"friction_ratio": friction} | ({"clearance_ratio": clearance} if particle else {})
        return parse_harmonic(document | {"axes": axes} | self._physical(kind.amplitude_m) | more)

    def from_starts(self, wanted: Wanted) -> tuple[Study, ...]:
        """Make the study that computes a build from several starts."""
        assert isinstance(wanted.amplitude, Amplitude)  # a response to a record starts at rest
        law, place, contact = wanted.build.spot(self.asked.structure, wanted.amplitude)
        more = {
            "name": f"{self.asked.name}, starts" if self.asked.name else "starts",
            "metrics": [*self.variables, *ABOUT_THE_RUN, *OF_STARTS],
            "start": ENSEMBLE,
        }
        grid = [np.array([value]) for value in place]
        kind = _Kind(wanted.amplitude.reference_m, place[2] > 0.0, law, contact)
        return (self._study(kind, grid, wanted.frequencies, **more),)

    def _physical(self, amplitude_m: float) -> dict[str, object]:
        """Return the `physical` block of a study; empty for a specification in ratios."""
        if not self.asked.in_units:
            return {}
        structure = self.asked.structure
        return {
            "physical": {
                "mass_kg": structure.mass_kg,
                "natural_frequency_hz": structure.natural_frequency_hz,
                "base_amplitude_m": amplitude_m,
            }
        }

    def add(self, cubes: "Iterable[xr.Dataset]") -> None:
        """Add the points of completed studies to the book."""
        self._curves.clear()
        for cube in cubes:
            if RECORD in cube.sizes:
                self._add_suite(cube)
                continue
            if "attractors" in cube:
                self.from_many_starts.append(cube)
                self.spent += cube["status"].size
                continue
            law = _law_of(cube)
            inside: Inside = contact_time_of(cube), *_beside(cube)
            names = [BESIDE.get(name, name) if AMPLITUDE in cube.sizes else name for name in DESIGN]
            axes = [cube[name].values.tolist() for name in names]
            frequencies = cube["frequency_ratio"].values.tolist()
            stored = {"amplitude_ratio": WORST} if WORST in cube else {}
            columns = np.stack(
                [cube[stored.get(name, name)].values.astype(np.float64) for name in self.variables], axis=-1
            )
            status = cube["status"].values
            columns[..., 0][status > Status.MAX_CYCLES] = np.inf
            # a dimension of base amplitudes has one value here
            columns = columns.reshape(*(len(axis) for axis in axes), len(frequencies), len(self.variables))
            for index in np.ndindex(*columns.shape[:-2]):
                place: Place = tuple(axis[i] for axis, i in zip(axes, index, strict=True))
                spot: Spot = (law, place, inside if place[2] else NOTHING_INSIDE)
                self._frequencies.setdefault(spot, set()).update(frequencies)
                for at, row in zip(frequencies, columns[index].tolist(), strict=True):
                    if (spot, at) not in self._known:
                        self._known[spot, at] = tuple(row)
                        self.spent += 1

    def _add_suite(self, cube: "xr.Dataset") -> None:
        for spot, row in known_of(cube):
            if (spot, ONCE[0]) not in self._known:
                self._known[spot, ONCE[0]] = row
                self.spent += 1

    def under_record(self, build: Build, case: Case) -> Curve:
        """Return the known results of a build under a record: a single point, with results in units."""
        row = self._known.get((build.spot(self.asked.structure, case), ONCE[0]))
        at = np.array(ONCE if row else ())
        rows = np.array(row or ()).reshape(at.size, len(RECORD_VARIABLES))
        columns = dict(zip(RECORD_VARIABLES, rows.T, strict=True))
        return Curve(at, np.ones(at.size), columns, self.asked.measured(case))

    def curve(self, build: Build, amplitude: Under) -> Curve:
        """Return the known results of a build for a record, or for an amplitude over its band."""
        if isinstance(amplitude, Case):
            return self.under_record(build, amplitude)
        if (build, amplitude) not in self._curves:
            spot = build.spot(self.asked.structure, amplitude)
            low, high = build.own(amplitude.excitation.low), build.own(amplitude.excitation.high)
            asked = sorted(r for r in self._frequencies.get(spot, ()) if low <= r <= high)
            known = [r for r in asked if (spot, r) in self._known]
            rows = np.array([self._known[spot, r] for r in known]).reshape(len(known), len(self.variables))
            self._curves[build, amplitude] = Curve(
                np.array(known),
                np.array([build.base_m(amplitude, r) for r in known]),
                dict(zip(self.variables, rows.T, strict=True)),
                self.asked.measured(amplitude),
                build.rate(self.asked),
            )
        return self._curves[build, amplitude]


def _beside(cube: "xr.Dataset") -> Iterator[float]:
    """Yield the value of each ratio in `BEFORE`, or 0 for a ratio that the study lacks.

    For a study over base amplitudes, yield friction coefficient and tilt of the cavity instead of the ratios.
    """
    if AMPLITUDE in cube.sizes:
        yield from cavity_of(definition_of(cube)["physical"]).numbers.values()
    else:
        yield from (float(cube[name].values[0]) if name in cube.sizes else 0.0 for name in BEFORE)


def _law_of(cube: "xr.Dataset") -> Law:
    """Return the `Law` of a study: the constant quantity of its excitation, with parameters."""
    if AMPLITUDE not in cube.sizes:
        return FORCE if excitation_of(cube) == "force" else ()
    physical = definition_of(cube)["physical"]
    amplitude = float(cube[AMPLITUDE].values[0])
    return physical["constant"], amplitude, physical["mass_kg"], physical["natural_frequency_hz"]


def _merged(groups: list[_Group]) -> list[_Group]:
    """Join two groups of designs wherever a joint computation costs no more than two separate ones."""
    found = [group.cut() for group in groups]
    if len(found) > MOST_MERGED:
        return found
    place = 0
    while place < len(found):
        for other in range(place + 1, len(found)):
            one, two = found[place], found[other]
            both = _Group(one.designs | two.designs, one.frequencies | two.frequencies).cut()
            if both.cost <= one.cost + two.cost:
                found[place] = both
                del found[other]
                break
        else:
            place += 1
    return found
