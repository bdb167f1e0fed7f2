"""What may be chosen of a damper, its limits and tolerances, read from a document."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from math import tau
from typing import Any

from damperlab.studies.definition import MAX_NAME
from damperlab.studies.faults import NOTHING, describe, join, listing
from damperlab.studies.physical import CLEARANCE, FRICTION_FORCE, PARTICLE_MASS
from damperlab.studies.quantity import CLEARANCE_RATIO, FRICTION_RATIO, MASS_RATIO, RESTITUTION, Quantity
from damperlab.studies.specification.measure import LIMITS
from damperlab.studies.specification.scene import SceneFields
from damperlab.studies.specification.specification import (
    CHOSEN,
    OF_STRUCTURE,
    RATIO_OF,
    Choice,
    Structure,
    Tolerance,
)

LIMIT_KEYS = (*LIMITS, "cavity_length_m", "friction_force_n", "particle_mass_kg")
MOST_VALUES = 20
"""Values in a list of one quantity."""

LENGTH = Quantity("length", "length [m]", 1e-12, 1e12, "give it in m")
SPEED = Quantity("speed", "speed [m/s]", 1e-12, 1e12, "give it in m/s")
ACCELERATION = Quantity("acceleration", "acceleration [m/s²]", 1e-12, 1e12, "give it in m/s²")
STICK = Quantity(
    "stick_fraction", "share of time", 1e-3, 1.0, "give a share, such as 0.5 for half of the time"
)
CONTACT_TIME = Quantity(
    "contact_time_s", "time for which particle and wall touch [s]", 0.0, 1e3, "give it in s"
)
LONGEST = tau
"""Longest contact time over 1/ω_n: a natural period."""
SHARE = Quantity("share", "share of the value", 0.0, 0.5, "write 10% for a tenth, or a number in the unit")
ANYTHING = Quantity("size", "tolerance", 0.0, 1e12, "write 10% for a tenth, or a number in the unit")

QUANTITY_IN = {"m": LENGTH, "m/s": SPEED, "m/s²": ACCELERATION, "1": STICK}
LIMIT_QUANTITIES = {
    **{each.name: QUANTITY_IN[each.unit] for each in LIMITS.values()},
    "friction_force_n": FRICTION_FORCE,
    "particle_mass_kg": PARTICLE_MASS,
}
"""What limits are, but for the length of the cavity."""
NAME_OF = {ratio: name for name, ratio in RATIO_OF.items()}
QUANTITIES = {
    "clearance_m": CLEARANCE,
    "friction_force_n": FRICTION_FORCE,
    "particle_mass_kg": PARTICLE_MASS,
    "restitution": RESTITUTION,
    "clearance_ratio": CLEARANCE_RATIO,
    "friction_ratio": FRICTION_RATIO,
    "mass_ratio": MASS_RATIO,
}


class DamperFields(SceneFields):
    """Reads what a damper may be."""

    def _choices(self, amplitude_m: float, structure: Structure | None) -> dict[str, Choice]:
        choose = self.document.get("choose", {})
        if not isinstance(choose, Mapping):
            self._fault(
                "choose", describe(choose), f"a mapping of {listing(CHOSEN)}", "write keys and ranges"
            )
            choose = {}
        known = (*CHOSEN, *(ratio for ratio in RATIO_OF.values() if ratio not in CHOSEN))
        self._unknown("choose", choose, known)
        found: dict[str, Choice] = {}
        for name in CHOSEN:
            spellings = dict.fromkeys((name, RATIO_OF[name]))
            places = [
                (join(place, key), key, held[key])
                for place, held in (("choose", choose), ("", self.document))
                for key in spellings
                if key in held
            ]
            if not places:
                allowed = f"a number, or a range under `choose`: {' or '.join(spellings)}"
                self._fault(
                    name,
                    NOTHING,
                    allowed,
                    "give it, or let it be chosen",
                    f"{{field}} is missing: give {allowed}.",
                )
                continue
            for field, _, value in places[1:]:
                told = f"{{field}} and `{places[0][0]}` give the same quantity twice."
                self._fault(field, describe(value), "each quantity once", "keep one of the two", told)
            field, key, value = places[0]
            scale = 1.0
            if key != name and structure is not None:
                scale = _scale(name, amplitude_m, structure)
            elif key == name and name != "restitution" and structure is not None and not self._in_units:
                told = (
                    "{field} is in units, and the specification lacks mass_kg, natural_frequency_hz or the amplitude of its "
                    "base, which make a ratio of it."
                )
                self._fault(
                    field,
                    describe(value),
                    f"{RATIO_OF[name]}, as the rest is in ratios",
                    f"give `{RATIO_OF[name]}`, or add them",
                    told,
                )
            choice = self._choice(field, value, QUANTITIES[key], field.startswith("choose"))
            if choice is not None:
                found[name] = Choice(
                    choice.start * scale,
                    choice.stop * scale,
                    tuple(each * scale for each in choice.values),
                    choice.names,
                    choice.contact_times_s,
                )
        if choose == {} and "choose" not in self.document:
            told = "{field} is missing: there is nothing to choose."
            advice = "write `choose: {clearance_m: {start: …, stop: …}}`"
            self._fault("choose", NOTHING, f"at least one of {listing(CHOSEN)}", advice, told)
        return found

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
            self._fault(
                field, describe(raw), f"a list of 2 to {MOST_VALUES} values", "give a range, or fewer values"
            )
            return None
        found: dict[float, str] = {}
        touching: dict[float, float] = {}
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
            if value in found:
                self._fault(place, f"{value!r} a second time", "each value once", "remove one of the two")
            found[value], touching[value] = name[:MAX_NAME], time_s
        if len(found) < len(entries):
            return None
        values = tuple(sorted(found))
        names = tuple(found[value] for value in values) if any(found.values()) else ()
        times = tuple(touching[value] for value in values) if any(touching.values()) else ()
        return Choice(values[0], values[-1], values, names, times)

    def _contact_time(self, field: str, raw: object) -> float:
        """Read how long particle and wall touch [s]; 0 where that is at fault."""
        if not self._in_units:
            told = "{field} is in seconds, and the specification is in ratios."
            advice = "add mass_kg, natural_frequency_hz and the amplitude of the base"
            self._fault(field, describe(raw), "a contact time beside a structure in units", advice, told)
            return 0.0
        return self._read(field, raw, CONTACT_TIME) or 0.0

    def _touching(self, choices: dict[str, Choice], structure: Structure) -> None:
        """Read one contact time for all that a restitution may be, and hold contact times against the natural period."""
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
        most = LONGEST / structure.angular_frequency
        longest = max(choice.contact_times_s, default=0.0)
        if self._in_units and longest > most:
            told = (
                f"{{field}} of {longest:g} s is longer than a natural period of the structure, {most:.3g} s."
            )
            advice = "give it in seconds; a contact takes milliseconds"
            self._fault(name, f"{longest:g}", f"at most {most:.3g}", advice, told)

    def _limit_values(self) -> dict[str, float]:
        """Read what `limits` says, as far as it can be read alone."""
        raw = self._mapping("limits", LIMIT_KEYS, self.document.get("limits", {})) or {}
        found: dict[str, float] = {}
        for key in LIMIT_KEYS:
            if key in raw:
                limit = self._read(f"limits.{key}", raw[key], LIMIT_QUANTITIES.get(key, LENGTH))
                if limit is not None:
                    found[key] = limit
                if key in LIMITS and not LIMITS[key].under_record and not self._shaken_over_bands:
                    self._without_period(key)
        return found

    def _without_period(self, key: str) -> None:
        """Refuse a limit that a response to a record has no result for."""
        told = (
            "{field} holds over bands of frequencies alone: it is a mean over the cycles of a steady response, and a response "
            "to a ground-motion record has none."
        )
        advice = "limit `impact_speed_m_per_s`, or add a band of frequencies to what shakes it"
        self._fault(
            f"limits.{key}", "records alone", "a band of frequencies among the excitations", advice, told
        )

    def _limits(self, choices: dict[str, Choice]) -> tuple[dict[str, float], dict[str, str]]:
        values = self._limit_values()
        bounds: dict[str, str] = {}
        in_units = any(key not in LIMITS or LIMITS[key].unit != "1" for key in values)
        if in_units and not self._in_units:
            told = "{field} are in units, and the specification is in ratios."
            self._fault(
                "limits",
                describe(self.document["limits"]),
                "limits beside a structure and a base motion in units",
                "add mass_kg, natural_frequency_hz and base_amplitude_m",
                told,
            )
            return {}, bounds
        for key, limit in values.items():
            if key not in LIMITS:
                name = "clearance_m" if key == "cavity_length_m" else key
                most = limit / 2 if key == "cavity_length_m" else limit
                self._cut(choices, name, most, f"limits.{key}", bounds)
        return {key: limit for key, limit in values.items() if key in LIMITS}, bounds

    def _cut(
        self, choices: dict[str, Choice], name: str, most: float, field: str, bounds: dict[str, str]
    ) -> None:
        """Cut a range short at a limit; contradictory where nothing is left of it."""
        choice = choices.get(name)
        if choice is None or choice.stop <= most:
            return
        if choice.start > most:
            factor = 2.0 if name == "clearance_m" else 1.0
            told = (
                f"{{field}} = {factor * most:g} excludes every {name} asked for, which begins at {choice.start:g}"
                f"{' (the cavity is twice as long)' if factor == 2.0 else ''}."
            )
            advice = f"relax it to at least {factor * choice.start:g}, or let `{name}` begin lower"
            self._fault(field, f"{factor * most:g}", f"at least {factor * choice.start:g}", advice, told)
            return
        values = tuple(value for value in choice.values if value <= most)
        choices[name] = replace(
            choice, stop=values[-1] if values else most, values=values, names=choice.names[: len(values)]
        )
        bounds[name] = field

    def _tolerance_values(self) -> dict[str, Tolerance]:
        """Read what `tolerances` says, as far as it can be read alone; each quantity once, as it is spelled."""
        ratios = [ratio for ratio in RATIO_OF.values() if ratio not in CHOSEN]
        known = (*CHOSEN, *ratios, *OF_STRUCTURE)
        raw = self._mapping("tolerances", known, self.document.get("tolerances", {})) or {}
        found: dict[str, Tolerance] = {}
        seen: set[str] = set()
        for key in raw:
            if key not in known:
                continue
            field, name = f"tolerances.{key}", NAME_OF.get(key, key)
            if name in seen:
                told = f"{{field}} gives the tolerance of {name} a second time."
                self._fault(field, describe(raw[key]), "each tolerance once", "keep one of the two", told)
                continue
            tolerance = self._tolerance(field, raw[key])
            if tolerance is not None:
                found[key] = tolerance
                seen.add(name)
        return found

    def _tolerances(
        self, choices: dict[str, Choice], amplitude_m: float, structure: Structure
    ) -> dict[str, Tolerance]:
        found: dict[str, Tolerance] = {}
        for key, tolerance in self._tolerance_values().items():
            name = NAME_OF.get(key, key)
            if not tolerance.relative:
                if key in OF_STRUCTURE:
                    size = getattr(structure, key)
                    tolerance = Tolerance(tolerance.size / size if size else 0.0, True)
                elif key != name:
                    tolerance = Tolerance(tolerance.size * _scale(name, amplitude_m, structure), False)
            self._check_size(f"tolerances.{key}", name, tolerance, choices)
            found[name] = tolerance
        return {name: each for name, each in found.items() if each.size > 0}

    def _check_size(self, field: str, name: str, tolerance: Tolerance, choices: dict[str, Choice]) -> None:
        """Refuse a tolerance that takes what is built beyond sense."""
        if name in OF_STRUCTURE:
            if tolerance.size > SHARE.highest:
                self._fault(field, f"{100 * tolerance.size:g} %", "at most 50 %", "check its unit")
        elif (
            name == "clearance_m"
            and name in choices
            and not tolerance.of(choices[name].start) < choices[name].start
        ):
            told = f"{{field}} = {tolerance.size:g} closes the smallest clearance asked for, {choices[name].start:g}."
            self._fault(
                field,
                f"{tolerance.size:g}",
                f"below {choices[name].start:g}",
                "begin the range higher, or work closer",
                told,
            )

    def _tolerance(self, field: str, raw: object) -> Tolerance | None:
        if isinstance(raw, str) and raw.strip().endswith("%"):
            try:
                share: object = float(raw.strip()[:-1]) / 100.0
            except ValueError:
                share = raw
            size = self._read(field, share, SHARE)
            return None if size is None else Tolerance(size, True)
        size = self._read(field, raw, ANYTHING)
        return None if size is None else Tolerance(size, False)


def _scale(name: str, amplitude_m: float, structure: Structure) -> float:
    """Give what a ratio is multiplied with to make the quantity; d/Z and γ_F are those of the largest amplitude."""
    return {
        "clearance_m": amplitude_m,
        "friction_force_n": structure.stiffness_n_per_m * amplitude_m,
        "particle_mass_kg": structure.mass_kg,
        "restitution": 1.0,
    }[name]
