"""A specification that is there, corrected: its structure, given values and tolerances become what was measured."""

import copy
from collections.abc import Iterator
from math import isinf
from typing import Any

from damperlab.studies.faults import NOTHING, Fault, StudyFaults
from damperlab.studies.fit.fitted import Estimate
from damperlab.studies.fit.history.question import HistoryQuestion
from damperlab.studies.fit.prototype import OF_CAVITY, Prototype, Question, prototype_of, short
from damperlab.studies.fit.specified import Specified
from damperlab.studies.fit.tolerance import MEANINGS, say_tolerances, spoken, tolerances_of
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.specification.reading import parse_specification
from damperlab.studies.specification.specification import CHOSEN, OF_STRUCTURE, RATIO_OF, Specification
from damperlab.studies.spelling import quantity

OVER_BASE = ("clearance_m", "friction_force_n")
"""What is over the amplitude of the base in ratios."""


def corrected(
    asked: Specification, question: Question, estimates: list[Estimate], shelf: Shelf | None = None
) -> Specified:
    """Put what was measured into a specification, and keep all else of it.

    Parameters
    ----------
    asked : Specification
        The one that is there.
    question : FitQuestion or HistoryQuestion
        What was asked of the measurement.
    estimates : list of Estimate
        What came out.
    shelf : Shelf, optional
        Where its ground-motion records are.

    Returns
    -------
    Specified
        With the structure, what is given outside `choose`, and their tolerances as measured. What is chosen keeps its range;
        its tolerance becomes that of the measurement where this is the wider one. What the measurement says nothing
        about stays as it was, with its tolerance.

    Raises
    ------
    StudyFaults
        Where the measurement has no units and the specification has, or where what comes out is no specification.
    """
    found = check_correction(asked, question, estimates)
    parse_specification(found.document, shelf)
    return found


def check_correction(asked: Specification, question: Question, estimates: list[Estimate]) -> Specified:
    """Write a corrected specification whose numbers may not be those that were measured yet; as of `corrected`.

    Raises
    ------
    StudyFaults
        Where no numbers would make it one: the measurement has no units and the specification has.
    """
    structure = asked.structure
    otherwise = {"natural_frequency_hz": structure.natural_frequency_hz, "mass_kg": structure.mass_kg}
    prototype = prototype_of(question, estimates, otherwise if asked.in_units else {})
    if isinstance(question, HistoryQuestion) and not asked.in_units:
        told = "A time history is in units, and the specification is in ratios to an amplitude that it says nothing of."
        advice = "write the specification in units"
        raise StudyFaults([Fault("specification", "ratios", "a specification in units", advice, told)])
    correction = _Correction(asked, prototype)
    document = correction.document()
    return Specified(document, tuple(correction.words()), {})


class _Correction:
    """Writes a corrected specification, and keeps what it did."""

    def __init__(self, asked: Specification, prototype: Prototype) -> None:
        self.asked = asked
        self.prototype = prototype
        self.replaced: list[str] = []
        self.chosen: list[str] = []
        self.kept: list[str] = []

    def document(self) -> dict[str, Any]:
        """Write the whole of it."""
        document = copy.deepcopy(self.asked.document)
        self._correct_structure(document["structure"])
        for name in CHOSEN:
            self._correct_value(document, name)
        # what acts on the particle was part of the model that was fitted
        document |= {
            name: short(self.prototype.values[name][0]) for name in OF_CAVITY if name in self.prototype.values
        }
        tolerances = self._tolerances(document.get("tolerances", {}))
        if tolerances:
            document["tolerances"] = tolerances
        return document

    def _correct_structure(self, structure: dict[str, Any]) -> None:
        for name, other in (
            ("mass_kg", None),
            ("natural_frequency_hz", "stiffness_n_per_m"),
            ("damping_ratio", "damping_n_s_per_m"),
        ):
            there = name in structure or other in structure
            if name in self.prototype.undetermined:
                self.kept.append(name)
            elif there and (name == "damping_ratio" or name in self.prototype.measured):
                _replace(structure, (name, other), name, short(self.prototype.values[name][0]))
                self.replaced.append(name)

    def _correct_value(self, document: dict[str, Any], name: str) -> None:
        """Correct what is given outside `choose`."""
        if self.asked.choices[name].free:
            if name in self.prototype.off:
                self.chosen.append(name)
            return
        values = self.prototype.values.get(name, ())
        if len(values) != 1 or name in self.prototype.undetermined:
            self.kept.append(name)
            return
        in_units = self.asked.in_units
        if in_units and name in OVER_BASE and values[0] > 0.0 and not self.prototype.in_units:
            told = (
                f"{{field}} is missing: the specification is in units, and {MEANINGS[name]} was measured as a ratio to the "
                "amplitude of the base."
            )
            advice = "give the amplitude of the base that it was measured with"
            raise StudyFaults([Fault("base_amplitude_m", NOTHING, "the amplitude in m", advice, told)])
        spelled = name if in_units else RATIO_OF[name]
        _replace(document, (name, RATIO_OF[name]), spelled, short(values[0] / self._scale(name)))
        self.replaced.append(name)

    def _scale(self, name: str) -> float:
        """Give what a quantity is over where the specification is in ratios."""
        if self.asked.in_units:
            return 1.0
        structure, largest = self.prototype.structure, max(self.prototype.base_m)
        return {
            "clearance_m": largest,
            "friction_force_n": structure.stiffness_n_per_m * largest,
            "particle_mass_kg": structure.mass_kg,
        }.get(name, 1.0)

    def _tolerances(self, there: dict[str, Any]) -> dict[str, Any]:
        found = dict(there)
        measured = tolerances_of(self.prototype, (*self.replaced, *self.chosen))
        for name in (*OF_STRUCTURE, *CHOSEN):
            if name not in self.prototype.off or name not in measured:
                continue
            if name in self.chosen and not self._wider(name):
                self.chosen.remove(name)
                continue
            _replace(found, (name, RATIO_OF.get(name, name)), name, measured[name])
        return found

    def _wider(self, name: str) -> bool:
        """Whether the measurement leaves more open than the tolerance to which the quantity is built."""
        built = self.asked.tolerances.get(name)
        if built is None:
            return True
        value = self.prototype.values[name][0]
        off = self.prototype.off[name] * (1.0 if name == "restitution" else value)
        return not isinf(off) and off > built.of(value)

    def words(self) -> Iterator[str]:
        """Say what was replaced and what was kept."""
        if self.replaced:
            yield f"Replaced by what was measured, or is known with it: {spoken(self.replaced)}."
        yield from say_tolerances(self.prototype, (*self.replaced, *self.chosen))
        kept = [name for name in self.kept if name in self.prototype.values or name in CHOSEN]
        if kept:
            yield f"Kept as before, since the measurement does not say it: {spoken(kept)}."
        yield from self._outside()

    def _outside(self) -> Iterator[str]:
        """Name what was built outside the range from which it may be chosen now."""
        for name in CHOSEN:
            choice, built = self.asked.choices[name], self.prototype.values.get(name, ())
            if not (choice.free and built and self.asked.in_units and self.prototype.in_units):
                continue
            if built[-1] < choice.start or built[0] > choice.stop:
                yield (
                    f"{MEANINGS[name].capitalize()} that was measured, {quantity(name, built[0])}, lies outside the range from "
                    f"{quantity(name, choice.start)} to {quantity(name, choice.stop)} that may be chosen."
                )


def _replace(document: dict[str, Any], old: tuple[str | None, ...], new: str, value: Any) -> None:
    """Put a value in the place of what says the same, or at the end."""
    entries = list(document.items())
    document.clear()
    for key, each in entries:
        if key not in old:
            document[key] = each
        else:
            document[new] = value
    document[new] = value
