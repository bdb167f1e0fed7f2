"""Read the ranges of a damper from a document."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from math import tau
from typing import Any

from damperlab.studies.definition import MAX_NAME
from damperlab.studies.faults import NOTHING, describe, join, listing
from damperlab.studies.physical import CLEARANCE, FRICTION_FORCE, PARTICLE_MASS
from damperlab.studies.quantity import (
    CLEARANCE_RATIO,
    FRICTION_RATIO,
    MASS_RATIO,
    OF_CAVITY,
    RESTITUTION,
    Quantity,
)
from damperlab.studies.specification.scene import SceneFields
from damperlab.studies.specification.specification import (
    CHOSEN,
    OF_DAMPER,
    RATIO_OF,
    Choice,
    Structure,
)
from damperlab.studies.spelling import unit_of

MOST_VALUES = 20
"""Largest number of values in a list of one quantity."""

CONTACT_TIME = Quantity(
    "contact_time_s", "time for which particle and wall touch [s]", 0.0, 1e3, "give it in s"
)
LONGEST = tau
"""Longest allowed contact time in units of 1/ω_n: one natural period."""
NAME_OF = {ratio: name for name, ratio in RATIO_OF.items()}
QUANTITIES = {
    "clearance_m": CLEARANCE,
    "friction_force_n": FRICTION_FORCE,
    "particle_mass_kg": PARTICLE_MASS,
    "restitution": RESTITUTION,
    "clearance_ratio": CLEARANCE_RATIO,
    "friction_ratio": FRICTION_RATIO,
    "mass_ratio": MASS_RATIO,
    **{each.name: each for each in OF_CAVITY},
}


class DamperFields(SceneFields):
    """Reads the ranges of a damper."""

    def _choices(self, amplitude_m: float, structure: Structure | None) -> dict[str, Choice]:
        choose = self.document.get("choose", {})
        if not isinstance(choose, Mapping):
            self._fault(
                "choose", describe(choose), f"a mapping of {listing(OF_DAMPER)}", "write keys and ranges"
            )
            choose = {}
        known = (*OF_DAMPER, *(ratio for ratio in RATIO_OF.values() if ratio not in CHOSEN))
        self._unknown("choose", choose, known)
        found: dict[str, Choice] = {}
        missing = False
        for name in CHOSEN:
            spellings = dict.fromkeys((name, RATIO_OF[name]))
            place = self._place(spellings, choose)
            if place is None:
                missing = True
                allowed = f"a number, or a range under `choose`: {' or '.join(spellings)}"
                self._fault(
                    name,
                    NOTHING,
                    allowed,
                    f"give {allowed}",
                    "{field} is missing.",
                )
                continue
            field, key, value = place
            scale = 1.0
            if key != name and structure is not None:
                scale = structure.reference(unit_of(name), amplitude_m)
            elif key == name and name != "restitution" and structure is not None and not self._in_units:
                told = (
                    "{field} is in units, but the specification lacks mass_kg, natural_frequency_hz or the "
                    "amplitude of the base, which convert {field} to a ratio."
                )
                self._fault(
                    field,
                    describe(value),
                    f"{RATIO_OF[name]}, because the specification is in ratios",
                    f"give `{RATIO_OF[name]}`, or add them",
                    told,
                )
            choice = self._choice(field, value, QUANTITIES[key], field.startswith("choose"))
            if choice is not None:
                values = tuple(each * scale for each in choice.values)
                start, stop = choice.start * scale, choice.stop * scale
                found[name] = replace(choice, start=start, stop=stop, values=values)
        if missing and "choose" not in self.document:
            told = "{field} is missing; it must give a range for each missing quantity of the damper."
            advice = "write `choose: {clearance_m: {start: …, stop: …}}`, or give all quantities"
            self._fault("choose", NOTHING, f"at least one of {listing(OF_DAMPER)}", advice, told)
        for quantity in OF_CAVITY:
            found[quantity.name] = Choice(0.0, 0.0)
            if (place := self._place((quantity.name,), choose)) is not None:
                field, _, value = place
                choice = self._choice(field, value, quantity, field.startswith("choose"))
                found[quantity.name] = choice or found[quantity.name]
        return found

    def _place(self, spellings: Iterable[str], choose: Mapping[str, Any]) -> tuple[str, str, Any] | None:
        """Return field, key and value of a quantity in the document. Return None if the quantity is not given."""
        places = [
            (join(place, key), key, held[key])
            for place, held in (("choose", choose), ("", self.document))
            for key in spellings
            if key in held
        ]
        for field, _, value in places[1:]:
            told = f"{{field}} and `{places[0][0]}` give the same quantity twice."
            self._fault(field, describe(value), "each quantity once", "keep one of the two", told)
        return places[0] if places else None

    def _choice(self, field: str, raw: object, quantity: Quantity, chosen: bool) -> Choice | None:
        if not chosen:
            value = self._read(field, raw, quantity)
            return None if value is None else Choice(value, value)
        if isinstance(raw, list | tuple):
            return self._list(field, raw, quantity)
        if isinstance(raw, Mapping):
            span = self._span(field, raw, quantity)
            return None if span is None else Choice(*span)
        allowed = "a range {start, stop} or a list of values"
        self._fault(field, describe(raw), allowed, "write a range, or give the number outside `choose`")
        return None

    def _list(self, field: str, raw: Iterable[Any], quantity: Quantity) -> Choice | None:
        entries = list(raw)
        if not 1 < len(entries) <= MOST_VALUES:
            few = "give another value, a range, or the number outside `choose`"
            advice = few if len(entries) < 2 else "give a range, or fewer values"
            self._fault(field, describe(raw), f"a list of 2 to {MOST_VALUES} values", advice)
            return None
        found: dict[tuple[float, float], str] = {}
        more = (CONTACT_TIME.name,) if quantity is RESTITUTION else ()
        for index, entry in enumerate(entries):
            place, name, time_s = f"{field}[{index}]", "", 0.0
            if isinstance(entry, Mapping):
                self._unknown(place, entry, ("name", quantity.name, *more))
                name = str(entry.get("name", ""))
                if more and CONTACT_TIME.name in entry:
                    time_s = self._contact_time(f"{place}.{CONTACT_TIME.name}", entry[CONTACT_TIME.name])
                if quantity.name not in entry:
                    told = f"{{field}} names no {quantity.name}."
                    self._fault(place, describe(entry), f"a mapping with {quantity.name}", "add it", told)
                    continue
                entry, place = entry[quantity.name], f"{place}.{quantity.name}"
            value = self._read(place, entry, quantity)
            if value is None:
                continue
            # two materials may have equal restitutions, but different contact times
            if (value, time_s) in found:
                told = f"{{field}} repeats the value {value!r}."
                self._fault(
                    place, f"{value!r} a second time", "each value once", "remove one of the two", told
                )
            found[value, time_s] = name[:MAX_NAME]
        if len(found) < len(entries):
            return None
        kept = sorted(found)
        values, touching = tuple(value for value, _ in kept), tuple(time_s for _, time_s in kept)
        names = tuple(found[each] for each in kept) if any(found.values()) else ()
        return Choice(values[0], values[-1], values, names, touching if any(touching) else ())

    def _contact_time(self, field: str, raw: object) -> float:
        """Read a contact time [s]. Return 0 if the value is faulty."""
        if not self._in_units:
            told = "{field} is in seconds, but the specification is in ratios."
            advice = "add mass_kg, natural_frequency_hz and the amplitude of the base"
            self._fault(field, describe(raw), "a contact time with a structure in units", advice, told)
            return 0.0
        return self._read(field, raw, CONTACT_TIME) or 0.0

    def _touching(self, choices: dict[str, Choice], structure: Structure | None) -> None:
        """Read the common contact time of all restitutions.

        Check that no contact time exceeds the natural period.
        """
        choice, name = choices.get("restitution"), CONTACT_TIME.name
        if choice is None:
            return
        if name in self.document:
            if choice.contact_times_s:
                told = "{field} and a material of `choose.restitution` give a contact time."
                self._fault(
                    name, describe(self.document[name]), "one of the two", "keep one of the two", told
                )
            time_s = self._contact_time(name, self.document[name])
            choice = choices["restitution"] = replace(choice, contact_times_s=(time_s,) if time_s else ())
        if structure is None:
            return
        most = LONGEST / structure.angular_frequency
        longest = max(choice.contact_times_s, default=0.0)
        if self._in_units and longest > most:
            told = (
                f"{{field}} of {longest:g} s is longer than a natural period of the structure, {most:.3g} s."
            )
            advice = "give it in seconds; a contact takes milliseconds"
            self._fault(name, f"{longest:g}", f"at most {most:.3g}", advice, told)
