"""Read the structure and the excitation of a specification from a document."""

import math
from collections.abc import Mapping
from dataclasses import replace

from damperlab.studies.faults import NOTHING, describe, listing
from damperlab.studies.ground.sweep import AMPLITUDES
from damperlab.studies.physical import (
    DAMPING,
    EXCITATION_FREQUENCY,
    MASS,
    NATURAL_FREQUENCY,
)
from damperlab.studies.quantity import DAMPING_RATIO, FREQUENCY_RATIO, Quantity
from damperlab.studies.specification.excitation import MOTIONS, Excitation
from damperlab.studies.specification.record_fields import OF_RECORDS, RecordFields
from damperlab.studies.specification.specification import Structure
from damperlab.studies.unit_names import ALIASES

STRUCTURE_KEYS = (
    "mass_kg",
    "natural_frequency_hz",
    "stiffness_n_per_m",
    "damping_ratio",
    "damping_n_s_per_m",
)
EXCITATION_KEYS = (*MOTIONS, "frequency_hz", "frequency_ratio")
MOST_EXCITATIONS = 8
MOST_LETTERS = 60
"""Largest number of characters of an excitation's name."""
STIFFNESS = Quantity("stiffness_n_per_m", "stiffness k [N/m]", 1e-12, 1e12, "give it in N/m")
BASE = AMPLITUDES | {
    "force_n": Quantity(
        "force_n", "amplitude F₀ of a force on the structure [N]", 1e-12, 1e12, "give it in N"
    ),
}


class SceneFields(RecordFields):
    """Reads the structure and the excitation."""

    @property
    def _in_units(self) -> bool:
        structure, excitation = (self.document.get(key) for key in ("structure", "excitation"))
        every = excitation if isinstance(excitation, list) else [excitation]
        return (
            isinstance(structure, Mapping)
            and "mass_kg" in structure
            and ("natural_frequency_hz" in structure or "stiffness_n_per_m" in structure)
            and all(map(_has_amplitude, every))
        )

    def _structure(self) -> Structure | None:
        raw = self._mapping("structure", STRUCTURE_KEYS)
        if raw is None:
            return None
        read = {
            key: self._read(f"structure.{key}", raw[key], quantity)
            for key, quantity in zip(
                STRUCTURE_KEYS, (MASS, NATURAL_FREQUENCY, STIFFNESS, DAMPING_RATIO, DAMPING), strict=True
            )
            if key in raw
        }
        for one, other in (
            ("natural_frequency_hz", "stiffness_n_per_m"),
            ("damping_ratio", "damping_n_s_per_m"),
        ):
            if one in raw and other in raw:
                told = f"{{field}} and `structure.{one}` state the same quantity."
                self._fault(
                    f"structure.{other}",
                    describe(raw[other]),
                    f"one of {one} and {other}",
                    "keep one of the two",
                    told,
                )
        for key in ("stiffness_n_per_m", "damping_n_s_per_m"):
            if key in raw and "mass_kg" not in raw:
                told = f"{{field}} is missing: {key} needs it."
                self._fault("structure.mass_kg", NOTHING, "the mass of the structure", "add `mass_kg`", told)
        if "mass_kg" in raw and not {"natural_frequency_hz", "stiffness_n_per_m"} & set(raw):
            allowed = "natural_frequency_hz or stiffness_n_per_m with the mass"
            told = "{field} has a mass, but neither natural_frequency_hz nor stiffness_n_per_m."
            self._fault("structure", "a mass alone", allowed, "add one of the two", told)
        if "damping_ratio" not in raw and "damping_n_s_per_m" not in raw:
            self._fault("structure.damping_ratio", NOTHING, DAMPING_RATIO.allowed, "add the damping ratio")
        if self.faults and any(fault.field.startswith("structure") for fault in self.faults):
            return None
        mass = read.get("mass_kg") or 1.0
        frequency = read.get("natural_frequency_hz") or 0.5 / math.pi
        if stiffness := read.get("stiffness_n_per_m"):
            frequency = math.sqrt(stiffness / mass) / (2.0 * math.pi)
        damping = read.get("damping_ratio")
        if damping is None:
            damping = (read["damping_n_s_per_m"] or 0.0) / (2.0 * mass * 2.0 * math.pi * frequency)
            if not DAMPING_RATIO.admits(damping):
                told = f"{{field}} gives a damping ratio of {damping:.6g}, which must be {DAMPING_RATIO.allowed}."
                self._fault(
                    "structure.damping_n_s_per_m",
                    f"{damping:.6g}",
                    DAMPING_RATIO.allowed,
                    "check the units",
                    told,
                )
                return None
        return Structure(mass, frequency, damping, "stiffness_n_per_m" in raw, "damping_n_s_per_m" in raw)

    def _excitations(self, structure: Structure | None) -> tuple[Excitation, ...] | None:
        """Read one excitation over a band, or a list of excitations. Return None if an excitation cannot be read."""
        raw = self.document.get("excitation")
        if not isinstance(raw, list):
            one = self._excitation("excitation", raw, EXCITATION_KEYS, structure)
            return None if one is None else (one,)
        if not 1 <= len(raw) <= MOST_EXCITATIONS:
            allowed = f"one excitation, or a list of 1 to {MOST_EXCITATIONS}"
            self._fault("excitation", describe(raw), allowed, "give the excitations that may be the worst")
            return None
        by_records = {field for field, _ in self._by_records}
        found = {
            place: self._excitation(field, each, ("name", *EXCITATION_KEYS), structure)
            for place, (field, each) in enumerate(self._shakers)
            if field not in by_records
        }
        # a missing part of the structure is reported once, not for every excitation
        self.faults[:] = dict.fromkeys(self.faults)
        names = [self._name_of(place, each) for place, (_, each) in enumerate(self._shakers)]
        for place, name in enumerate(names):
            if name in names[:place]:
                told = f"{{field}} is the name of another excitation too: {name}."
                self._fault(f"excitation[{place}].name", describe(name), "each name once", "change it", told)
        have = list(map(_has_amplitude, raw))
        if any(have) and not all(have):
            place = have.index(False)
            told = "{field} has no amplitude, but other excitations have one, so they cannot be compared."
            advice = "give every excitation an amplitude, or none of them"
            self._fault(f"excitation[{place}]", NOTHING, f"one of {listing(MOTIONS)}", advice, told)
        if not all(found.values()):
            return None
        return tuple(replace(each, name=names[place]) for place, each in found.items() if each is not None)

    def _name_of(self, place: int, raw: object) -> str:
        """Read the name of an excitation in a list. The default name contains the number of the excitation."""
        otherwise = f"excitation {place + 1}"
        name = raw.get("name", otherwise) if isinstance(raw, Mapping) else otherwise
        if isinstance(name, str) and name.strip() and name.isprintable() and len(name) <= MOST_LETTERS:
            return name.strip()
        allowed = f"a text of 1 to {MOST_LETTERS} printable characters"
        self._fault(
            f"excitation[{place}].name", describe(name), allowed, "write a short text, or leave it out"
        )
        return otherwise

    def _excitation(
        self, field: str, raw: object, known: tuple[str, ...], structure: Structure | None
    ) -> Excitation | None:
        """Read one excitation.

        Parameters
        ----------
        field : str
            Path of the excitation in the document.
        raw : object
            The value at this path.
        known : tuple of str
            Allowed keys.
        structure : Structure or None
            The structure; None if it could not be read.
        """
        if isinstance(raw, Mapping) and "frequency_hz" not in raw:
            raw = {ALIASES.get(key, key): value for key, value in raw.items()}
        raw = self._mapping(field, known, raw)
        if raw is None:
            return None
        before = len(self.faults)
        level: tuple[float, float] | None = (1.0, 1.0)
        given = [key for key in MOTIONS if key in raw]
        motion = MOTIONS[given[0]] if given else MOTIONS["base_amplitude_m"]
        for key in given[1:]:
            told = (
                f"{{field}} and `{field}.{given[0]}` are both given; one excitation may have only one of "
                "them, and the excitations of a list act one at a time."
            )
            self._fault(
                f"{field}.{key}",
                describe(raw[key]),
                f"one of {listing(MOTIONS)}",
                "keep one of them, or make a list of two excitations",
                told,
            )
        if given:
            level = self._span(f"{field}.{motion.key}", raw[motion.key], BASE[motion.key])
        if motion.order:
            why = f"{motion.key} gives a displacement only with a frequency in Hz"
            self._require_frequency(why, "base_amplitude_m")
        if motion.force and not self._has("structure", "stiffness_n_per_m"):
            needed = [key for key in ("mass_kg", "natural_frequency_hz") if not self._has("structure", key)]
            for key in needed:
                told = "{field} is missing: a force gives a displacement only with the stiffness of the structure."
                advice = "add it, or give the stiffness"
                self._fault(
                    f"structure.{key}", NOTHING, "mass and natural frequency, or stiffness", advice, told
                )
        asked = [key for key in ("frequency_hz", "frequency_ratio") if key in raw]
        if len(asked) != 1:
            allowed = "either frequency_hz or frequency_ratio, a number or {start, stop}"
            found = "both" if asked else NOTHING
            told = f"{{field}} must be {allowed}, not {found}."
            self._fault(f"{field}.frequency_hz", found, allowed, "give one of them", told)
            return None
        quantity = EXCITATION_FREQUENCY if asked == ["frequency_hz"] else FREQUENCY_RATIO
        band = self._span(f"{field}.{asked[0]}", raw[asked[0]], quantity)
        if asked == ["frequency_hz"]:
            self._require_frequency("a frequency in Hz needs it", "frequency_ratio")
        if len(self.faults) > before or level is None or band is None or structure is None:
            return None
        scale = structure.natural_frequency_hz if asked == ["frequency_hz"] else 1.0
        low, high = band[0] / scale, band[1] / scale
        if not (FREQUENCY_RATIO.admits(low) and FREQUENCY_RATIO.admits(high)):
            unit = " Hz" if asked == ["frequency_hz"] else ""
            found = f"{band[0]:.6g} to {band[1]:.6g}{unit}" if high > low else f"{band[0]:.6g}{unit}"
            allowed = f"{FREQUENCY_RATIO.lowest * scale:g} to {FREQUENCY_RATIO.highest * scale:g}{unit}"
            told = (
                f"{{field}} is {found}; allowed is {allowed}, from {FREQUENCY_RATIO.lowest:g} to "
                f"{FREQUENCY_RATIO.highest:g} times the natural frequency."
            )
            self._fault(f"{field}.{asked[0]}", found, allowed, "check the units", told)
            return None
        factor = structure.per_metre(motion)
        return Excitation(level[0] / factor, level[1] / factor, low, high, motion)

    def _require_frequency(self, why: str, instead: str) -> None:
        """Record a fault if the structure has no natural frequency.

        The fault advises to add the natural frequency, or to give the field `instead`.
        """
        if not self._has("structure", "natural_frequency_hz", "stiffness_n_per_m"):
            advice, told = f"add it, or give `{instead}`", f"{{field}} is missing: {why}."
            field = "structure.natural_frequency_hz"
            self._fault(field, NOTHING, "the natural frequency", advice, told)


def _has_amplitude(excitation: object) -> bool:
    """Whether an excitation is given in SI units, either as an amplitude or as records."""
    return isinstance(excitation, Mapping) and any(key in excitation for key in (*MOTIONS, *OF_RECORDS))
