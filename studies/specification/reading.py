"""A specification read from a document, with every fault named at once."""

import math
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeVar

from damperlab.studies.definition import MAX_NAME
from damperlab.studies.faults import (
    NOTHING,
    Fault,
    StudyFaults,
    describe,
    join,
    listing,
    nearest,
    printable,
    unknown_key,
)
from damperlab.studies.guard import guard
from damperlab.studies.physical import (
    BASE_AMPLITUDE,
    CLEARANCE,
    DAMPING,
    EXCITATION_FREQUENCY,
    FRICTION_FORCE,
    MASS,
    NATURAL_FREQUENCY,
    PARTICLE_MASS,
)
from damperlab.studies.quantity import (
    CLEARANCE_RATIO,
    DAMPING_RATIO,
    FREQUENCY_RATIO,
    FRICTION_RATIO,
    MASS_RATIO,
    RESTITUTION,
    Quantity,
    read_count,
)
from damperlab.studies.specification.specification import (
    CHOSEN,
    LIMITED,
    MEASURES,
    OF_STRUCTURE,
    RATIO_OF,
    Choice,
    Excitation,
    Specification,
    Structure,
    Tolerance,
)
from damperlab.studies.text import MAX_BYTES, Format, load_text

KEYS = (
    "name",
    "structure",
    "excitation",
    "choose",
    *CHOSEN,
    *(ratio for ratio in RATIO_OF.values() if ratio != "restitution"),
    "tolerances",
    "limits",
    "measure",
    "confidence",
    "budget_minutes",
    "budget_points",
    "builds",
)
STRUCTURE_KEYS = (
    "mass_kg",
    "natural_frequency_hz",
    "stiffness_n_per_m",
    "damping_ratio",
    "damping_n_s_per_m",
)
EXCITATION_KEYS = ("base_amplitude_m", "frequency_hz", "frequency_ratio")
LIMIT_KEYS = (*LIMITED, "cavity_length_m", "friction_force_n", "particle_mass_kg")
MOST_VALUES = 20
"""Values in a list of one quantity."""

STIFFNESS = Quantity("stiffness_n_per_m", "stiffness k [N/m]", 1e-12, 1e12, "give it in N/m")
LENGTH = Quantity("length", "length [m]", 1e-12, 1e12, "give it in m")
SPEED = Quantity("speed", "speed [m/s]", 1e-12, 1e12, "give it in m/s")
CONFIDENCE = Quantity("confidence", "confidence of errors and intervals", 0.5, 0.999, "the default is 0.9")
BUDGET_MINUTES = Quantity("budget_minutes", "core minutes", 0.01, 1e5, "the default is 8")
SHARE = Quantity("share", "share of the value", 0.0, 0.5, "write 10% for a tenth, or a number in the unit")
ANYTHING = Quantity("size", "tolerance", 0.0, 1e12, "write 10% for a tenth, or a number in the unit")

QUANTITIES = {
    "clearance_m": CLEARANCE,
    "friction_force_n": FRICTION_FORCE,
    "particle_mass_kg": PARTICLE_MASS,
    "restitution": RESTITUTION,
    "clearance_ratio": CLEARANCE_RATIO,
    "friction_ratio": FRICTION_RATIO,
    "mass_ratio": MASS_RATIO,
}

_ANOTHER = (
    " makes another base amplitude, and so other ratios of the same damper, at every frequency, which a design "
    "does not search"
)

REFUSED_EXCITATIONS = {
    "force_n": "A force on the structure is another scene than a shaken base: there the friction damper works against the "
    "structure's own velocity and the base stays at rest, which the solver does not compute",
    "base_velocity_m_per_s": "A base velocity that is constant over the band" + _ANOTHER,
    "base_acceleration_m_per_s2": "A base acceleration that is constant over the band" + _ANOTHER,
    "records": "Ground-motion records are asked of dampers by a ground-motion suite",
    "sweep": "A sweep through the band is a transient; a design is judged by its steady responses",
}
"""Excitations that a design does not know, and why."""
REFUSED_MEASURES = {
    "worst_acceleration": "the acceleration is not among the results of a study",
    "rms_displacement": "an rms over the band is not judged; that in time at the worst frequency is `worst_rms_displacement`",
    "rms_acceleration": "the acceleration is not among the results of a study",
}

T = TypeVar("T")

_FORMATS: dict[str, Format] = {".json": "json", ".yaml": "yaml", ".yml": "yaml"}


def read_specification(path_or_name: str) -> Specification:
    """Read a specification from a ``.json``, ``.yaml`` or ``.yml`` file, or by the name of a named one.

    Raises
    ------
    StudyFaults
        Where there is neither such a file nor such a name, or with every fault of the specification.
    """
    path = Path(path_or_name)
    written_in = _FORMATS.get(path.suffix.lower())
    if written_in is None:
        named = named_specifications()
        if path_or_name in named:
            return parse_specification(load_text(named[path_or_name], "yaml"))
        allowed = f"a {', '.join(_FORMATS)} file, or one of the named specifications {listing(named)}"
        told = f"There is no specification {printable(path_or_name)}: name {allowed}."
        near = nearest(path_or_name, named)
        advice = f"did you mean {near}?" if near else "name one of them"
        raise StudyFaults([Fault("specification", describe(path_or_name), allowed, advice, told)])
    try:
        with path.open("rb") as file:
            text = file.read(MAX_BYTES[written_in] + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else "not a path"
        told = f"The file {printable(path_or_name)} cannot be read: {reason}."
        raise StudyFaults(
            [Fault("specification", describe(path_or_name), "a readable file", "check the path", told)]
        ) from None
    return parse_specification(load_text(text, written_in))


@cache
def named_specifications() -> dict[str, bytes]:
    """Return the named specifications of the package as they were written: YAML in UTF-8 with comments, by name."""
    entries = sorted(
        (files("damperlab.studies") / "specification" / "catalog").iterdir(), key=lambda entry: entry.name
    )
    return {
        entry.name.removesuffix(".yaml"): entry.read_bytes()
        for entry in entries
        if entry.name.endswith(".yaml")
    }


def parse_specification(document: object) -> Specification:
    """Validate a specification.

    Parameters
    ----------
    document : object
        As read from JSON or YAML.

    Raises
    ------
    StudyFaults
        With every fault of the document.
    """
    if not isinstance(document, dict):
        advice = "write keys and values: structure, excitation, choose"
        raise StudyFaults([Fault("specification", describe(document), "a mapping", advice)])
    given, faults = guard(document)
    reader = _Reader(given, faults)
    found = reader.specification()
    if found is None or reader.faults:
        raise StudyFaults(reader.faults)
    return found


class _Reader:
    """Reads a document part by part, and keeps the faults.

    Parameters
    ----------
    document : dict
        Guarded.
    faults : list of Fault
        Those found so far.
    """

    def __init__(self, document: dict[str, Any], faults: list[Fault]) -> None:
        self.document = document
        self.faults = faults

    def specification(self) -> Specification | None:
        """Read all of it; None where something was wrong that the rest depends on."""
        self._unknown("", self.document, KEYS)
        structure = self._structure()
        excitation = self._excitation(structure)
        name = self._name()
        measure = self._measure()
        confidence = self._number("confidence", CONFIDENCE, 0.9)
        minutes = self._number("budget_minutes", BUDGET_MINUTES, 8.0)
        points = self._count("budget_points", 100, 10_000_000, None)
        builds = self._count("builds", 0, 10_000, 60)
        if structure is None or excitation is None:
            self._choices(1.0, None)
            return None
        choices = self._choices(excitation.highest_m, structure)
        limits, bounds = self._limits(choices)
        tolerances = self._tolerances(choices, excitation.highest_m, structure)
        if self.faults or measure is None or confidence is None or minutes is None:
            return None
        return Specification(
            name=name,
            structure=structure,
            excitation=excitation,
            choices=choices,
            limits=limits,
            bounds=bounds,
            tolerances=tolerances,
            measure=MEASURES[measure],
            confidence=confidence,
            budget_points=points,
            budget_minutes=minutes,
            builds=builds or 0,
            in_units=self._in_units,
            document=self.document,
        )

    # structure and excitation

    @property
    def _in_units(self) -> bool:
        structure, excitation = (self.document.get(key) for key in ("structure", "excitation"))
        return (
            isinstance(structure, Mapping)
            and isinstance(excitation, Mapping)
            and all(
                (
                    "mass_kg" in structure,
                    "natural_frequency_hz" in structure or "stiffness_n_per_m" in structure,
                    "base_amplitude_m" in excitation,
                )
            )
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
                told = f"{{field}} and `structure.{one}` say the same twice."
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
            allowed = "natural_frequency_hz or stiffness_n_per_m beside the mass"
            told = "{field} has a mass, and neither natural_frequency_hz nor stiffness_n_per_m beside it."
            self._fault("structure", "a mass alone", allowed, "add one of the two", told)
        if "damping_ratio" not in raw and "damping_n_s_per_m" not in raw:
            told = "{field} is missing."
            self._fault(
                "structure.damping_ratio", NOTHING, DAMPING_RATIO.allowed, "add the damping ratio", told
            )
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
        return Structure(mass, frequency, damping)

    def _excitation(self, structure: Structure | None) -> Excitation | None:
        raw = self.document.get("excitation")
        if isinstance(raw, Mapping):
            for key in set(raw) & set(REFUSED_EXCITATIONS):
                why = REFUSED_EXCITATIONS[key]
                advice = "give `base_amplitude_m`, the displacement of the base"
                self._fault(
                    f"excitation.{key}", describe(raw[key]), listing(EXCITATION_KEYS), advice, f"{why}."
                )
            raw = {key: value for key, value in raw.items() if key not in REFUSED_EXCITATIONS}
        raw = self._mapping("excitation", EXCITATION_KEYS, raw)
        if raw is None:
            return None
        before = len(self.faults)
        amplitude: tuple[float, float] | None = (1.0, 1.0)
        if "base_amplitude_m" in raw:
            amplitude = self._span("excitation.base_amplitude_m", raw["base_amplitude_m"], BASE_AMPLITUDE)
        asked = [key for key in ("frequency_hz", "frequency_ratio") if key in raw]
        if len(asked) != 1:
            allowed = "either frequency_hz or frequency_ratio, a number or {start, stop}"
            found = "both" if asked else NOTHING
            told = f"{{field}} must be {allowed}, not {found}."
            self._fault("excitation.frequency_hz", found, allowed, "give one of them", told)
            return None
        quantity = EXCITATION_FREQUENCY if asked == ["frequency_hz"] else FREQUENCY_RATIO
        band = self._span(f"excitation.{asked[0]}", raw[asked[0]], quantity)
        if asked == ["frequency_hz"] and not self._has(
            "structure", "natural_frequency_hz", "stiffness_n_per_m"
        ):
            told = "{field} is missing: a frequency in Hz needs it."
            self._fault(
                "structure.natural_frequency_hz",
                NOTHING,
                "the natural frequency",
                "add it, or give `frequency_ratio`",
                told,
            )
        if len(self.faults) > before or amplitude is None or band is None or structure is None:
            return None
        scale = structure.natural_frequency_hz if asked == ["frequency_hz"] else 1.0
        low, high = band[0] / scale, band[1] / scale
        if not (FREQUENCY_RATIO.admits(low) and FREQUENCY_RATIO.admits(high)):
            told = f"{{field}} makes frequency ratios from {low:.6g} to {high:.6g}; they must be {FREQUENCY_RATIO.allowed}."
            self._fault(
                f"excitation.{asked[0]}",
                describe(raw[asked[0]]),
                FREQUENCY_RATIO.allowed,
                "check the units",
                told,
            )
            return None
        return Excitation(*amplitude, low, high)

    # what is chosen, limits and tolerances

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
                    "{field} is in units, and the specification lacks mass_kg, natural_frequency_hz or base_amplitude_m, "
                    "which make a ratio of it."
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
        for index, entry in enumerate(entries):
            place, name = f"{field}[{index}]", ""
            if isinstance(entry, Mapping):
                self._unknown(place, entry, ("name", quantity.name))
                name = str(entry.get("name", ""))
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
            found[value] = name[:MAX_NAME]
        if len(found) < len(entries):
            return None
        values = tuple(sorted(found))
        names = tuple(found[value] for value in values) if any(found.values()) else ()
        return Choice(values[0], values[-1], values, names)

    def _limits(self, choices: dict[str, Choice]) -> tuple[dict[str, float], dict[str, str]]:
        raw = self._mapping("limits", LIMIT_KEYS, self.document.get("limits", {})) or {}
        limits: dict[str, float] = {}
        bounds: dict[str, str] = {}
        if raw and not self._in_units:
            told = "{field} are in units, and the specification is in ratios."
            self._fault(
                "limits",
                describe(raw),
                "limits beside a structure and a base amplitude in units",
                "add mass_kg, natural_frequency_hz and base_amplitude_m",
                told,
            )
            return limits, bounds
        for key, value in raw.items():
            field = f"limits.{key}"
            quantity = {"friction_force_n": FRICTION_FORCE, "particle_mass_kg": PARTICLE_MASS}.get(
                key, LENGTH
            )
            limit = self._read(field, value, SPEED if key in LIMITED and "speed" in key else quantity)
            if limit is None:
                continue
            if key in LIMITED:
                limits[key] = limit
                continue
            name = "clearance_m" if key == "cavity_length_m" else key
            self._cut(choices, name, limit / 2 if key == "cavity_length_m" else limit, field, bounds)
        return limits, bounds

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
        choices[name] = Choice(
            choice.start, values[-1] if values else most, values, choice.names[: len(values)]
        )
        bounds[name] = field

    def _tolerances(
        self, choices: dict[str, Choice], amplitude_m: float, structure: Structure
    ) -> dict[str, Tolerance]:
        ratios = [ratio for ratio in RATIO_OF.values() if ratio not in CHOSEN]
        known = (*CHOSEN, *ratios, *OF_STRUCTURE)
        raw = self._mapping("tolerances", known, self.document.get("tolerances", {})) or {}
        found: dict[str, Tolerance] = {}
        names = {ratio: name for name, ratio in RATIO_OF.items()}
        for key, value in raw.items():
            field, name = f"tolerances.{key}", names.get(key, key)
            if name in found:
                told = f"{{field}} gives the tolerance of {name} a second time."
                self._fault(field, describe(value), "each tolerance once", "keep one of the two", told)
                continue
            tolerance = self._tolerance(field, value)
            if tolerance is None:
                continue
            if not tolerance.relative:
                if key in OF_STRUCTURE:
                    size = {
                        "mass_kg": structure.mass_kg,
                        "natural_frequency_hz": structure.natural_frequency_hz,
                        "damping_ratio": structure.damping_ratio,
                    }[key]
                    tolerance = Tolerance(tolerance.size / size if size else 0.0, True)
                elif key != name:
                    tolerance = Tolerance(tolerance.size * _scale(name, amplitude_m, structure), False)
            self._check_size(field, name, tolerance, choices)
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

    # what is left, and small things

    def _measure(self) -> str | None:
        raw = self.document.get("measure", "worst_displacement")
        if isinstance(raw, str) and raw in MEASURES:
            return raw
        why = REFUSED_MEASURES.get(raw) if isinstance(raw, str) else None
        told = f"{{field}} cannot be {raw}: {why}." if why else ""
        self._fault("measure", describe(raw), f"one of {listing(MEASURES)}", "choose one of them", told)
        return None

    def _name(self) -> str:
        raw = self.document.get("name", "")
        if isinstance(raw, str) and len(raw) <= MAX_NAME - 20 and raw.isprintable():
            return raw.strip()
        allowed = f"a text of at most {MAX_NAME - 20} printable characters"
        self._fault("name", describe(raw), allowed, "write a short text on one line, or leave it out")
        return ""

    def _number(self, key: str, quantity: Quantity, default: float) -> float | None:
        return self._read(key, self.document[key], quantity) if key in self.document else default

    def _count(self, key: str, lowest: int, highest: int, default: int | None) -> int | None:
        if key not in self.document:
            return default
        return self._try(lambda: read_count(self.document[key], lowest, highest, key))

    def _span(self, field: str, raw: object, quantity: Quantity) -> tuple[float, float] | None:
        """Read a number, or ``{start, stop}``."""
        if not isinstance(raw, Mapping):
            value = self._read(field, raw, quantity)
            return None if value is None else (value, value)
        self._unknown(field, raw, ("start", "stop"))
        ends: list[float] = []
        for key in ("start", "stop"):
            place = f"{field}.{key}"
            if key not in raw:
                self._fault(place, NOTHING, "a number", f"add `{key}`; a range needs start and stop")
            elif (value := self._read(place, raw[key], quantity)) is not None:
                ends.append(value)
        if len(ends) < 2:
            return None
        if not ends[0] < ends[1]:
            self._fault(
                f"{field}.stop",
                f"{ends[1]:g}",
                f"greater than start ({ends[0]:g})",
                "exchange start and stop, or write a single value as a plain number",
            )
            return None
        return ends[0], ends[1]

    def _mapping(self, key: str, known: tuple[str, ...], raw: object = NOTHING) -> Mapping[str, Any] | None:
        value = self.document.get(key) if raw is NOTHING else raw
        if not isinstance(value, Mapping):
            found = NOTHING if value is None else describe(value)
            self._fault(key, found, f"a mapping of {listing(known)}", "write keys and values")
            return None
        self._unknown(key, value, known)
        return value

    def _has(self, key: str, *names: str) -> bool:
        held = self.document.get(key)
        return isinstance(held, Mapping) and any(name in held for name in names)

    def _read(self, field: str, raw: object, quantity: Quantity) -> float | None:
        return self._try(lambda: quantity.read(raw, field))

    def _try(self, read: Callable[[], T]) -> T | None:
        try:
            return read()
        except StudyFaults as error:
            self.faults.extend(error.faults)
            return None

    def _unknown(self, field: str, raw: Mapping[str, Any], known: tuple[str, ...]) -> None:
        self.faults.extend(unknown_key(join(field, key), key, known) for key in raw if key not in known)

    def _fault(self, field: str, found: str, allowed: str, advice: str, told: str = "") -> None:
        self.faults.append(Fault(field, found, allowed, advice, told))


def _scale(name: str, amplitude_m: float, structure: Structure) -> float:
    """Give what a ratio is multiplied with to make the quantity; d/Z and γ_F are those of the largest amplitude."""
    return {
        "clearance_m": amplitude_m,
        "friction_force_n": structure.stiffness_n_per_m * amplitude_m,
        "particle_mass_kg": structure.mass_kg,
        "restitution": 1.0,
    }[name]
