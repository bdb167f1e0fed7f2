"""Ground-motion records as the excitation of a specification, read from a document."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from damperlab.studies.faults import NOTHING, Fault, StudyFaults, describe
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.quantities import QUANTITIES
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.ground.source import RecordSource, read_source
from damperlab.studies.ground.suite import windows_of
from damperlab.studies.ground.suite_reading import MOST_WINDOWS
from damperlab.studies.specification.fields import Fields
from damperlab.studies.specification.records import RecordCases
from damperlab.studies.specification.specification import Structure

RECORD_KEYS = ("records", "scales", "tail_s")
MOST_CASES = 50
"""Records times scales."""
SCALE, TAIL = (QUANTITIES[name][0] for name in ("scale", "tail_s"))
WITHOUT_BASE = ("clearance_ratio", "friction_ratio")
"""Ratios to an amplitude of the base, which records do not have."""


class RecordFields(Fields):
    """Reads records with scales.

    Parameters
    ----------
    document, faults
        As of `Fields`.
    shelf : Shelf, optional
        Where records are; see `damperlab.studies.ground.source.read_source`.
    """

    def __init__(self, document: dict[str, Any], faults: list[Fault], shelf: Shelf | None = None) -> None:
        super().__init__(document, faults)
        self._shelf = shelf

    @property
    def _shakers(self) -> list[tuple[str, object]]:
        """What shakes the structure, each with its place in the document."""
        raw = self.document.get("excitation")
        if isinstance(raw, list):
            return [(f"excitation[{place}]", each) for place, each in enumerate(raw)]
        return [("excitation", raw)]

    @property
    def _by_records(self) -> list[tuple[str, Mapping[str, Any]]]:
        """Those of them that are ground-motion records."""
        return [
            (place, each) for place, each in self._shakers if isinstance(each, Mapping) and "records" in each
        ]

    @property
    def _shaken_by_records(self) -> bool:
        return bool(self._by_records)

    @property
    def _shaken_over_bands(self) -> bool:
        return len(self._shakers) > len(self._by_records)

    def _records(self, structure: Structure | None) -> RecordCases | None:
        """Read the records of a specification that has them."""
        (place, given), *further = self._by_records
        for field, _ in further:
            told = f"{{field}} holds records, and so does `{place}`: the worst of all is judged, so that one list will do."
            advice = f"move them into `{place}.records`"
            self._fault(field, "records a second time", "one excitation of records", advice, told)
        raw = self._mapping(place, RECORD_KEYS if place == "excitation" else ("name", *RECORD_KEYS), given)
        before = len(self.faults)
        if raw is None:
            return None
        if not self._shaken_over_bands:
            self._unknown_ratios()
        for keys, advice in (
            (("mass_kg",), "add the mass"),
            (("natural_frequency_hz", "stiffness_n_per_m"), "add it, or `stiffness_n_per_m`"),
        ):
            if not self._has("structure", *keys):
                told = "{field} is missing: records are in m/s² and seconds, so that the structure must be in units."
                self._fault(f"structure.{keys[0]}", NOTHING, "a structure in units", advice, told)
        found = self._sources(f"{place}.records", raw["records"])
        scales = self._scales(f"{place}.scales", raw.get("scales", 1.0))
        tail = self._read(f"{place}.tail_s", raw.get("tail_s", 0.0), TAIL)
        if len(self.faults) > before or tail is None:
            return None
        if len(found) * len(scales) > MOST_CASES:
            cases = f"{len(found) * len(scales)} cases"
            told = f"{{field}} make {cases}, every record at every scale; at most {MOST_CASES} are allowed."
            advice = "keep the records and scales that may be the worst"
            self._fault(f"{place}.records", cases, f"at most {MOST_CASES}", advice, told)
        if structure is not None:
            self._too_long(f"{place}.records", [source for source, _ in found], structure, tail)
        found.sort(key=lambda one: one[0].id)
        # the record as it is now is what is asked, so its samples' digest is in the document, and in its digest
        held = {"records": [source.document() for source, _ in found], "scales": list(scales), "tail_s": tail}
        held = {key: raw[key] for key in ("name",) if key in raw} | held
        kept = [held if field == place else each for field, each in self._shakers]
        self.document = self.document | {"excitation": held if place == "excitation" else kept}
        motions = {source.id: motion for source, motion in found if motion is not None}
        number = 1 + [field for field, _ in self._shakers].index(place)
        name = "" if place == "excitation" else str(raw.get("name", f"excitation {number}")).strip()
        return RecordCases(tuple(source for source, _ in found), scales, tail, motions, name)

    def _unknown_ratios(self) -> None:
        for place in ("", "choose", "tolerances"):
            held = self.document.get(place, {}) if place else self.document
            for key in WITHOUT_BASE if isinstance(held, Mapping) else ():
                if key in held:
                    name = "clearance_m" if key == "clearance_ratio" else "friction_force_n"
                    field = f"{place}.{key}" if place else key
                    told = "{field} is over the amplitude of the base, which records do not have."
                    self._fault(field, describe(held[key]), name, f"give `{name}`", told)

    def _sources(self, field: str, raw: object) -> list[tuple[RecordSource, GroundMotion | None]]:
        entries = [raw] if isinstance(raw, str | dict) else raw
        if not isinstance(entries, list | tuple) or not 0 < len(entries) <= MOST_CASES:
            allowed = f"a list of 1 to {MOST_CASES} records"
            self._fault(field, describe(raw), allowed, "write [loma-prieta, el-centro]")
            return []
        found: dict[str, tuple[RecordSource, GroundMotion | None]] = {}
        for index, entry in enumerate(entries):
            place = f"{field}[{index}]"
            try:
                source, motion = read_source(entry, self._shelf)
            except StudyFaults as caught:
                # a record that is not found says so under a name of its own, which a list has no use for
                self.faults.extend(
                    replace(each, field=place) if each.field == "record" else each.under(place)
                    for each in caught.faults
                )
                continue
            if source.id in found:
                told = f"{{field}} names {source.id} a second time."
                self._fault(place, f"{source.id} a second time", "each record once", "remove one", told)
            found[source.id] = source, motion
        return list(found.values())

    def _scales(self, field: str, raw: object) -> tuple[float, ...]:
        entries = list(raw) if isinstance(raw, list | tuple) else [raw]
        if not entries:
            self._fault(field, describe(raw), "a number or a list of numbers", "write [0.5, 1]")
        several = isinstance(raw, list | tuple)
        found: list[float] = []
        for index, entry in enumerate(entries[: MOST_CASES + 1]):
            place = f"{field}[{index}]" if several else field
            value = self._read(place, entry, SCALE)
            if value in found:
                self._fault(place, f"{value:g} a second time", "each scale once", "remove one of the two")
            elif value is not None:
                found.append(value)
        return tuple(sorted(found))

    def _too_long(self, field: str, sources: list[RecordSource], structure: Structure, tail_s: float) -> None:
        for index, source in enumerate(sources):
            steps = float(windows_of(source, 1.5 * structure.natural_frequency_hz, tail_s))
            if steps > MOST_WINDOWS:
                found = f"{steps:,.0f} steps of {source.id}"
                told = f"{{field}} takes about {found} a damper; at most {MOST_WINDOWS:,} are allowed."
                advice = "use a shorter record or tail, or a slower structure"
                self._fault(f"{field}[{index}]", found, f"at most {MOST_WINDOWS:,} steps", advice, told)
