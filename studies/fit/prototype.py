"""The prototype that a fit found, in the names of a specification: values, and how far each may be off."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import inf, pi
from typing import Any

from damperlab.studies.choices import Contact, InstantContact
from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.fit.fitted import Estimate
from damperlab.studies.fit.history.harmonic import band_hz, base_amplitude_m, peak_m_s2
from damperlab.studies.fit.history.question import HistoryQuestion
from damperlab.studies.fit.question import FitQuestion
from damperlab.studies.specification.specification import CHOSEN, OF_STRUCTURE, RATIO_OF, Structure
from damperlab.studies.variables import BEFORE, MADE_BY

Given = Mapping[str, float]
Question = FitQuestion | HistoryQuestion

NAME_OF = {ratio: name for name, ratio in RATIO_OF.items()} | {"damping_n_s_per_m": "damping_ratio"}
"""What a specification calls a parameter that a study spells otherwise."""
SCALES = ("mass_kg", "natural_frequency_hz", "base_amplitude_m")
"""What ratios are over."""
OF_PARTICLE = ("clearance_m", "particle_mass_kg", "restitution")
OF_CAVITY = tuple(MADE_BY.values())
EQUAL = 1e-9
"""Share below which two numbers differ by rounding."""


@dataclass(frozen=True)
class Prototype:
    """What was built, as far as a measurement says it.

    Parameters
    ----------
    name : str
        Of the measurement.
    confidence : float
        Of the intervals.
    values : mapping of tuple of float
        By the names of a specification, in SI units over mass, natural frequency and base amplitude, which are 1 kg,
        1/2π Hz and 1 m where they are not known; several, ascending, where rows were measured with several. A prototype
        without a particle has none of its quantities.
    off : mapping of float
        How far the interval of what was estimated reaches to its farther side: a share of the value, of a restitution
        the difference. Infinite where the value is 0.
    undetermined : tuple of str
        What was estimated, and of which the measurement says nothing.
    known : frozenset of str
        Which of `SCALES` are known.
    measured : frozenset of str
        Which of them come with the measurement, and not from a specification that is there.
    base_m : tuple of float
        Amplitudes of the base, ascending.
    excitation : mapping
        What shakes it, as a specification has it; empty where one is there and the measurement knows none.
    guessed : str
        How the excitation was guessed; empty where it was measured.
    contact : Contact
        What an impact is.
    """

    name: str
    confidence: float
    values: Mapping[str, tuple[float, ...]]
    off: Mapping[str, float]
    undetermined: tuple[str, ...]
    known: frozenset[str]
    measured: frozenset[str]
    base_m: tuple[float, ...]
    excitation: Mapping[str, Any]
    guessed: str = ""
    contact: Contact = field(default_factory=InstantContact)

    @property
    def particle(self) -> bool:
        """Whether it has one."""
        return "particle_mass_kg" in self.values

    @property
    def structure(self) -> Structure:
        """The structure, in units or with a stiffness of 1 N/m."""
        mass, frequency, damping = (self.values[name][0] for name in OF_STRUCTURE)
        return Structure(mass, frequency, damping)

    @property
    def in_units(self) -> bool:
        """Whether lengths, forces and masses mean anything."""
        return self.known.issuperset(SCALES)


def prototype_of(
    question: Question, estimates: Sequence[Estimate], otherwise: Given | None = None
) -> Prototype:
    """Put what is known and what was estimated into the names of a specification.

    Parameters
    ----------
    question : FitQuestion or HistoryQuestion
        What was asked.
    estimates : sequence of Estimate
        What came out.
    otherwise : mapping of float, optional
        Mass and natural frequency of a specification that is there, where the question knows none; None where a
        specification is to be made anew.

    Raises
    ------
    StudyFaults
        Where the measurement is not that of one structure on a base that moves.
    """
    if isinstance(question, HistoryQuestion):
        return _of_history(question, estimates, otherwise)
    return _of_response(question, estimates, otherwise or {})


def as_asked(question: Question) -> list[Estimate]:
    """Give the parameters at the middle of their ranges: what is made of them is checked before anything is computed."""
    middles = [(each, 0.5 * (each.low + each.high)) for each in question.free]
    return [
        Estimate(each.name, middle, middle, middle, 0.0, each.low, each.high, 0.0, 0.0)
        for each, middle in middles
    ]


def _of_response(question: FitQuestion, estimates: Sequence[Estimate], otherwise: Given) -> Prototype:
    if question.settings.get("excitation") == "force":
        told = "A response to a force on the structure makes no specification here: it knows no amplitude of the force."
        advice = "write it by hand, with `force_n` as its excitation"
        raise StudyFaults([Fault("excitation", "force", "a base that moves", advice, told)])
    if of_cavity := sorted({*question.known, *(each.name for each in estimates)} & set(BEFORE)):
        told = "{field} is over the amplitude of the base; a specification needs the coefficient, or the tilt, that makes it."
        advice = f"give `{MADE_BY[of_cavity[0]]}` in its place"
        raise StudyFaults([Fault(of_cavity[0], "a ratio", "a quantity in units", advice, told)])
    rows = [conditions for conditions, _ in question.configurations]

    def given(values: Given) -> list[dict[str, float]]:
        return [{**otherwise, **question.given(values, conditions)} for conditions in rows]

    values = {each.name: each.value for each in estimates}
    best = given(values)
    built, off = _gathered(estimates, given, question.settings.get("particle", True) is not False)
    for name in OF_STRUCTURE:
        if len(built[name]) > 1:
            told = f"The rows have several values of {name}; a specification is of one structure."
            raise StudyFaults([Fault(name, "several", "one value", "fit the rows of one structure", told)])
    measured = question.measured
    frequency = "frequency_hz" if measured.in_hertz else "frequency_ratio"
    known = frozenset(name for name in SCALES if all(name in one for one in best))
    own = [question.given(values, conditions) for conditions in rows]
    base_m = _distinct(one.get("base_amplitude_m", 1.0) for one in best)
    excitation = {"base_amplitude_m": span(base_m)} if "base_amplitude_m" in known else {}
    band = (float(measured.frequency.min()), float(measured.frequency.max()))
    return Prototype(
        name=measured.name,
        confidence=question.confidence,
        values=built,
        off=off,
        undetermined=_undetermined(estimates),
        known=known,
        measured=frozenset(name for name in SCALES if all(name in one for one in own)),
        base_m=base_m,
        excitation=excitation | {frequency: span(band)},
        contact=question.study(question.given(values, rows[0]), [1.0]).contact,
    )


def _of_history(
    question: HistoryQuestion, estimates: Sequence[Estimate], otherwise: Given | None
) -> Prototype:
    def given(values: Given) -> list[dict[str, float]]:
        return [{**(otherwise or {}), **question.given(values)}]

    values = {each.name: each.value for each in estimates}
    (best,) = given(values)
    built, off = _gathered(estimates, given, question.particle)
    base_m, guessed = 1.0, ""
    excitation: dict[str, Any] = {}
    if otherwise is None:
        base_m = base_amplitude_m(question.measured, best)
        excitation, guessed = _guessed(question, best, base_m)
    own = set(SCALES) & set(question.given(values))
    return Prototype(
        name=question.measured.name,
        confidence=question.confidence,
        values=built,
        off=off,
        undetermined=_undetermined(estimates),
        known=frozenset({"base_amplitude_m"} | (set(SCALES) & set(best))),
        measured=frozenset(own),
        base_m=(base_m,),
        excitation=excitation,
        guessed=guessed,
        contact=question.contact,
    )


def _guessed(question: HistoryQuestion, given: Given, base_m: float) -> tuple[dict[str, Any], str]:
    """Give what may shake a prototype that was identified from a time history, and how that was guessed."""
    band = {"frequency_hz": span(band_hz(given))}
    peak = peak_m_s2(question.measured)
    if peak is not None:
        how = "the largest measured acceleration of the base, as that of a sine over a band around the natural frequency"
        return {"base_acceleration_m_per_s2": short(peak), **band}, how
    how = (
        "the base that, by the balance of energy at resonance, keeps the structure without its particle at the largest "
        "measured displacement, over a band around the natural frequency"
    )
    return {"base_amplitude_m": short(base_m), **band}, how


def _undetermined(estimates: Iterable[Estimate]) -> tuple[str, ...]:
    names = (NAME_OF.get(each.name, each.name) for each in estimates if not each.determined)
    return tuple(name for name in names if name in (*OF_STRUCTURE, *CHOSEN))


def _gathered(
    estimates: Sequence[Estimate], given: Callable[[Given], list[dict[str, float]]], particle: bool
) -> tuple[dict[str, tuple[float, ...]], dict[str, float]]:
    """Give the values of all rows, and how far they may be off: over every corner of the intervals."""
    best = [_specified(one, particle) for one in given({each.name: each.value for each in estimates})]
    ends = product(*((each.low, each.high) for each in estimates))
    names = [each.name for each in estimates]
    corners = [
        [_specified(one, particle) for one in given(dict(zip(names, corner, strict=True)))] for corner in ends
    ]
    values: dict[str, tuple[float, ...]] = {}
    off: dict[str, float] = {}
    for name in (*OF_STRUCTURE, *CHOSEN, *OF_CAVITY):
        rows = [row for row, one in enumerate(best) if name in one]
        if not rows:
            continue
        found = _distinct(best[row][name] for row in rows)
        # rows without friction, or without the particle, are those of another damper
        values[name] = tuple(value for value in found if value > 0.0) or found
        sides = [
            _off(name, best[row][name], corner[row][name])
            for row in rows
            for corner in corners
            if best[row][name] > 0.0 or values[name] == (0.0,)
        ]
        if (farthest := max(sides, default=0.0)) > EQUAL:
            off[name] = farthest
    return values, off


def _off(name: str, value: float, end: float) -> float:
    difference = abs(end - value)
    if name == "restitution" or difference == 0.0:
        return difference
    return difference / value if value > 0.0 else inf


def _specified(given: Given, particle: bool) -> dict[str, float]:
    """Turn numbers in the names of a study into those of a specification, over what is not known as 1."""
    mass, frequency = given.get("mass_kg", 1.0), given.get("natural_frequency_hz", 0.5 / pi)
    structure = Structure(mass, frequency, given.get("damping_ratio", 0.0))
    damping = structure.damping_ratio
    if "damping_n_s_per_m" in given:
        damping = given["damping_n_s_per_m"] / (2.0 * mass * structure.angular_frequency)
    found = {"mass_kg": mass, "natural_frequency_hz": frequency, "damping_ratio": damping}
    base_m = given.get("base_amplitude_m", 1.0)
    over = {
        "clearance_m": base_m,
        "friction_force_n": structure.stiffness_n_per_m * base_m,
        "particle_mass_kg": mass,
        "restitution": 1.0,
    }
    for name, scale in over.items():
        ratio = given.get(RATIO_OF[name], 0.0)
        found[name] = given[name] if name in given else ratio * scale
    if not particle or found["particle_mass_kg"] == 0.0:
        for name in OF_PARTICLE:
            del found[name]
        return found
    return found | {name: given[name] for name in OF_CAVITY if given.get(name)}


def _distinct(values: Iterable[float]) -> tuple[float, ...]:
    found: list[float] = []
    for value in sorted(values):
        if not found or value - found[-1] > EQUAL * value:
            found.append(value)
    return tuple(found)


def span(values: Sequence[float]) -> Any:
    """Write values as a number, or as the range that holds them all."""
    least, largest = short(min(values)), short(max(values))
    return {"start": least, "stop": largest} if least < largest else least


def short(value: float) -> float:
    """Round to six digits: the rest is below every tolerance."""
    return float(f"{value:.6g}")
