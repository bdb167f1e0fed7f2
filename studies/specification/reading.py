"""Read a specification from a document, and report every fault."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from damperlab.studies.consistency import rubbing_faults
from damperlab.studies.definition import MAX_NAME
from damperlab.studies.faults import Fault, StudyFaults, describe, join, listing
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.guard import guard, refuse_the_other
from damperlab.studies.named import named_specifications, named_texts
from damperlab.studies.quantity import OF_CAVITY, Quantity
from damperlab.studies.specification.damper import CONTACT_TIME
from damperlab.studies.specification.limit_fields import IN_RATIOS, LimitFields
from damperlab.studies.specification.measure import (
    DAMPER_LIMITS,
    LIMITS,
    MEASURES,
    MIXED_MEASURES,
    RECORD_MEASURES,
    Measure,
)
from damperlab.studies.specification.specification import (
    CHOSEN,
    JUDGES,
    RATIO_OF,
    Choice,
    Specification,
    Structure,
    beside_rubbing,
)
from damperlab.studies.text import Format, is_file, load_text, read_file, unknown_name
from damperlab.studies.variables import MADE_BY

KEYS = (
    "name",
    "structure",
    "excitation",
    "choose",
    *CHOSEN,
    *(ratio for ratio in RATIO_OF.values() if ratio != "restitution"),
    CONTACT_TIME.name,
    *(each.name for each in OF_CAVITY),
    "tolerances",
    "limits",
    "measure",
    "judge",
    "confidence",
    "budget_minutes",
    "budget_points",
    "builds",
)
CONFIDENCE = Quantity(
    "confidence", "confidence level of errors and intervals", 0.5, 0.999, "the default is 0.9"
)
BUDGET_MINUTES = Quantity(
    "budget_minutes",
    "core minutes that the responses are expected to take; the choice of dampers and the storage come on top",
    0.01,
    1e5,
    "the default is 8",
)
REFUSED_UNDER_RECORDS = {
    "rms_displacement": "this is the rms over a band; the rms in time, under the worst record or sweep, is "
    "`worst_rms_displacement`",
    "rms_acceleration": "this is the rms over a band; the rms in time, under the worst record or sweep, is "
    "`worst_rms_acceleration`",
}


def read_specification(path_or_name: str, shelf: Shelf | None = None) -> Specification:
    """Read a specification from a ``.json``, ``.yaml`` or ``.yml`` file, or by its name in the package.

    Parameters
    ----------
    path_or_name : str
        The file or the name.
    shelf : Shelf, optional
        Source of ground-motion records; see `parse_specification`.

    Raises
    ------
    StudyFaults
        If there is no such file or name, or if the specification has faults. The error lists every fault.
    """
    return parse_specification(specification_document(path_or_name), shelf)


def specification_document(path_or_name: str) -> dict[str, Any]:
    """Return the unvalidated document of a specification; see `read_specification`."""
    named = named_specifications()
    if path_or_name in named:
        return _mapping(load_specification(named[path_or_name], "yaml"))
    if not is_file(path_or_name):
        raise unknown_name(path_or_name, "specification", named, named_texts())
    return _mapping(load_specification(*read_file(path_or_name, "specification")))


def load_specification(text: bytes | str, written_in: Format) -> Any:
    """Parse the text of a specification with `damperlab.studies.text.load_text`, and adapt the messages."""
    try:
        return load_text(text, written_in, guarded=True)
    except StudyFaults as error:
        raise StudyFaults([_of_specification(fault) for fault in error.faults]) from None


def _of_specification(fault: Fault) -> Fault:
    """Adapt a fault that the text reader found, so that it mentions a specification instead of a study."""
    advice = "write less: a specification has few values" if "axes" in fault.advice else fault.advice
    return replace(fault, advice=advice, message=fault.message.replace("a study", "a specification"))


def parse_specification(document: object, shelf: Shelf | None = None) -> Specification:
    """Validate a specification.

    Parameters
    ----------
    document : object
        The document as read from JSON or YAML.
    shelf : Shelf, optional
        Source of ground-motion records; see `damperlab.studies.ground.source.read_source`.

    Raises
    ------
    StudyFaults
        If the document has faults; the error lists every fault.
    """
    refuse_the_other(document, "specification")
    given, faults = guard(_mapping(document))
    faults = [_of_specification(fault) for fault in faults]
    # YAML reads None for a key without a value, for example if all lines below the key are comments
    given = {key: value for key, value in given.items() if value is not None}
    reader = _Reader(given, faults, shelf)
    found = reader.specification()
    if found is None or reader.faults:
        raise StudyFaults(reader.faults)
    return found


def _mapping(document: object) -> dict[str, Any]:
    if isinstance(document, dict):
        return document
    advice = "write the keys `structure`, `excitation` and `choose` with their values"
    raise StudyFaults([Fault("specification", describe(document), "a mapping", advice)])


class _Reader(LimitFields):
    """Reads a complete specification."""

    def specification(self) -> Specification | None:
        """Read the complete specification. Return None if the specification has a fault."""
        self._unknown("", self.document, KEYS)
        structure = self._structure()
        records = self._records(structure)
        alone = bool(self._by_records) and not isinstance(self.document["excitation"], list)
        excitations = () if alone else self._excitations(structure)
        name = self._name()
        measure = self._measure()
        judge = self._judge(measure)
        confidence = self._number("confidence", CONFIDENCE, 0.9)
        minutes = self._number("budget_minutes", BUDGET_MINUTES, 8.0)
        points = self._count("budget_points", 100, 10_000_000, None)
        if "budget_points" in self.document and "budget_minutes" in self.document:
            told = "{field} and budget_minutes are both given."
            found = "a budget in points together with one in minutes"
            self._fault("budget_points", found, "one of the two", "remove one of them", told)
        builds = self._count("builds", 0, 10_000, 60)
        if structure is None or excitations is None or records is None:
            self._without_ratios(structure)
            return None
        # records have no base amplitude to which ratios could refer
        largest_m = max((each.highest_m for each in excitations), default=1.0)
        if not self._in_units:  # ratios then refer to the largest amplitude
            excitations = tuple(each.over(largest_m) for each in excitations)
            largest_m = 1.0
        choices = self._choices(largest_m, structure)
        self._touching(choices, structure)
        tolerances = self._tolerances(choices, largest_m, structure)
        limits = self._limits(largest_m, structure)
        references = () if self._in_units else DAMPER_LIMITS
        units = {name: structure.reference(DAMPER_LIMITS[name].unit, largest_m) for name in references}
        bounds = self._within_limits(choices, limits, tolerances, units)
        self._rubbing(choices)
        if judge == "worst" and (limits.keys() & LIMITS.keys()) - {"displacement_m"}:
            self._not_the_worst()
        if self.faults or measure is None or confidence is None or minutes is None:
            return None
        return Specification(
            name=name,
            structure=structure,
            excitations=excitations,
            choices=choices,
            limits={name: limit for name, limit in limits.items() if name in LIMITS},
            damper_limits={name: limit for name, limit in limits.items() if name in DAMPER_LIMITS},
            bounds=bounds,
            tolerances=tolerances,
            measure=self._measures[measure],
            judge=judge,
            confidence=confidence,
            budget_points=points,
            budget_minutes=minutes,
            builds=builds or 0,
            in_units=self._in_units,
            document=self.document,
            records=records,
        )

    def _rubbing(self, choices: Mapping[str, Choice]) -> None:
        """Refuse features that cannot be combined with friction of the particle or gravity."""
        for name in MADE_BY.values():
            chosen = self._has("choose", name)
            toleranced = self._has("tolerances", name) and (chosen or name in self.document)
            if choices[name].stop or toleranced:
                held = self.document["choose"] if chosen else self.document
                field = join("choose" if chosen else "", name)
                beside = beside_rubbing(self._in_units, choices)
                self.faults.extend(rubbing_faults(field, describe(held.get(name)), beside))
                return

    def _without_ratios(self, structure: Structure | None) -> None:
        """Find faults in values of the damper in SI units, even if structure or excitation are faulty."""
        choices = self._choices(1.0, None)
        chosen = self.document.get("choose")
        held = {*self.document, *(chosen if isinstance(chosen, dict) else ())}
        choices = {name: each for name, each in choices.items() if name in held}
        if self._in_units or CONTACT_TIME.name not in self.document:
            self._touching(choices, structure)
        tolerances = self._tolerances(choices, None, structure)
        limits = {name: limit for name, limit in self._limit_values().items() if name not in IN_RATIOS}
        if self._in_units:
            self._within_limits(choices, limits, tolerances, {})

    @property
    def _measures(self) -> dict[str, Measure]:
        if not self._by_records:
            return MEASURES
        return MIXED_MEASURES if self._shaken_over_bands else RECORD_MEASURES

    def _measure(self) -> str | None:
        raw = self.document.get("measure", next(iter(self._measures)))
        if isinstance(raw, str) and raw in self._measures:
            return raw
        why = REFUSED_UNDER_RECORDS.get(raw) if isinstance(raw, str) else None
        told = f"{{field}} cannot be {raw}: {why}." if why else ""
        self._fault("measure", describe(raw), f"one of {listing(self._measures)}", "choose one of them", told)
        return None

    def _judge(self, measure: str | None) -> str:
        raw = self.document.get("judge", "rest")
        if raw == "rest":
            return "rest"
        if not (isinstance(raw, str) and raw in JUDGES):
            self._fault("judge", describe(raw), f"one of {listing(JUDGES)}", "choose one of them")
        elif not self._shaken_over_bands:
            told = "{field} cannot be " + raw + ": under a record the structure begins at rest."
            self._fault("judge", raw, "rest", "leave it out", told)
        elif raw == "worst" and measure not in (None, "worst_displacement"):
            self._not_the_worst()
        return str(raw)

    def _not_the_worst(self) -> None:
        told = (
            "{field} cannot be `worst` here: of the responses from other starts, only the displacement of "
            "the structure is known."
        )
        advice = "choose `likely`, or measure and limit the displacement of the structure alone"
        self._fault("judge", "worst", "rest or likely", advice, told)

    def _name(self) -> str:
        raw = self.document.get("name", "")
        if isinstance(raw, str) and len(raw) <= MAX_NAME - 20 and raw.isprintable():
            return raw.strip()
        allowed = f"a text of at most {MAX_NAME - 20} printable characters"
        self._fault("name", describe(raw), allowed, "write a short text on one line, or leave it out")
        return ""
