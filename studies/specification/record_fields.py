"""Read ground-motion records as the excitation of a specification."""

from collections.abc import Mapping
from typing import Any

from damperlab.studies.faults import NOTHING, Fault, describe, listing
from damperlab.studies.ground.generated import GENERATED
from damperlab.studies.ground.quantities import QUANTITIES
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.ground.source import Entry, read_entries
from damperlab.studies.ground.suite_reading import too_long
from damperlab.studies.specification.excitation import RecordCases
from damperlab.studies.specification.fields import Fields
from damperlab.studies.specification.specification import Structure

OF_RECORDS = ("records", *GENERATED)
"""Keys of an excitation by records. A single generated record may be given under its own key instead of `records`."""
RECORD_KEYS = (*OF_RECORDS, "scales", "tail_s")
MOST_CASES = 50
"""Largest number of cases of all excitations together. A case is one record at one scale."""
SCALE, TAIL = (QUANTITIES[name][0] for name in ("scale", "tail_s"))
WITHOUT_BASE = ("clearance_ratio", "friction_ratio")
"""Ratios that refer to a base amplitude, which records do not have."""


class RecordFields(Fields):
    """Reads records with scales.

    Parameters
    ----------
    document, faults
        The document and the faults found so far; see `Fields`.
    shelf : Shelf, optional
        The store of records; see `damperlab.studies.ground.source.read_source`.
    """

    def __init__(self, document: dict[str, Any], faults: list[Fault], shelf: Shelf | None = None) -> None:
        super().__init__(document, faults)
        self._shelf = shelf

    @property
    def _shakers(self) -> list[tuple[str, object]]:
        """The excitations, each with its path in the document."""
        raw = self.document.get("excitation")
        if isinstance(raw, list):
            return [(f"excitation[{place}]", each) for place, each in enumerate(raw)]
        return [("excitation", raw)]

    @property
    def _by_records(self) -> list[tuple[str, Mapping[str, Any]]]:
        """The excitations that consist of stored or generated records, each with its path in the document."""
        return [
            (place, each)
            for place, each in self._shakers
            if isinstance(each, Mapping) and any(key in each for key in OF_RECORDS)
        ]

    @property
    def _shaken_over_bands(self) -> bool:
        return len(self._shakers) > len(self._by_records)

    def _records(self, structure: Structure | None) -> tuple[RecordCases, ...] | None:
        """Read the records of a specification. Return None if some records cannot be read."""
        if not self._by_records:
            return ()
        self._unitless()
        if not self._shaken_over_bands:
            self._unknown_ratios()
        named: set[str] = set()
        read = [self._group(place, given, structure, named) for place, given in self._by_records]
        groups = tuple(each for each in read if each is not None)
        count = sum(len(each.cases) for each in groups)
        if count > MOST_CASES:
            place, given = self._by_records[0]
            key = next(key for key in OF_RECORDS if key in given)
            told = f"The records make {count} cases, each record at each of its scales; at most {MOST_CASES} are allowed."
            advice = "keep the records and scales that may be the worst"
            self._fault(f"{place}.{key}", f"{count} cases", f"at most {MOST_CASES}", advice, told)
        if len(groups) < len(read):
            return None
        # the stored document contains a hash of the samples, so that the digest depends on the samples
        held = iter(groups)
        places = {place for place, _ in self._by_records}
        kept = [_held(next(held), each) if place in places else each for place, each in self._shakers]
        listed = isinstance(self.document["excitation"], list)
        self.document = self.document | {"excitation": kept if listed else kept[0]}
        return groups

    def _unitless(self) -> None:
        """Refuse records if the structure is given in ratios."""
        for keys, advice in (
            (("mass_kg",), "add the mass"),
            (("natural_frequency_hz", "stiffness_n_per_m"), "add it, or `stiffness_n_per_m`"),
        ):
            if not self._has("structure", *keys):
                told = (
                    "{field} is missing: records are in m/s² and seconds, so the structure must be in units."
                )
                self._fault(f"structure.{keys[0]}", NOTHING, "a structure in units", advice, told)

    def _group(
        self, place: str, given: Mapping[str, Any], structure: Structure | None, named: set[str]
    ) -> RecordCases | None:
        """Read the records of one excitation.

        `named` contains the ids read so far; the ids of these records are added.
        """
        before = len(self.faults)
        raw = self._mapping(place, RECORD_KEYS if place == "excitation" else ("name", *RECORD_KEYS), given)
        assert raw is not None  # `given` is a mapping
        first, *others = [key for key in OF_RECORDS if key in raw]
        for key in others:
            told = (
                f"{{field}} and `{place}.{first}` are both given; one excitation may have only one of them."
            )
            advice = "write all of them in `records`, or make a list of excitations"
            self._fault(f"{place}.{key}", describe(raw[key]), f"one of {listing(OF_RECORDS)}", advice, told)
        if others:
            return None
        if first == "records":
            entries = self._entries(f"{place}.records", raw["records"])
        else:
            # the faults of a generated record already name the key
            entries = [(f"{place}.{first}", place, {first: raw[first]})]
        found = read_entries(entries, self._shelf, named, self.faults)
        scales = self._scales(f"{place}.scales", raw.get("scales", 1.0))
        tail = self._read(f"{place}.tail_s", raw.get("tail_s", 0.0), TAIL)
        if len(self.faults) > before or tail is None:
            return None
        if structure is not None:
            for field, source in {field: source for field, source, _ in found}.items():
                # the number of time steps is largest at the highest natural frequency within the tolerances
                self.faults += too_long(field, source, 1.5 * structure.natural_frequency_hz, tail)
        found.sort(key=lambda one: one[1].id)
        motions = {source.id: motion for _, source, motion in found if motion is not None}
        number = 1 + [field for field, _ in self._shakers].index(place)
        name = "" if place == "excitation" else str(raw.get("name", f"excitation {number}")).strip()
        return RecordCases(tuple(source for _, source, _ in found), scales, tail, motions, name)

    def _unknown_ratios(self) -> None:
        for place in ("", "choose", "tolerances"):
            held = self.document.get(place, {}) if place else self.document
            for key in WITHOUT_BASE if isinstance(held, Mapping) else ():
                if key in held:
                    name = "clearance_m" if key == "clearance_ratio" else "friction_force_n"
                    field = f"{place}.{key}" if place else key
                    told = "{field} is relative to the amplitude of the base, which records do not have."
                    self._fault(field, describe(held[key]), name, f"give `{name}`", told)

    def _entries(self, field: str, raw: object) -> list[Entry]:
        """Return the entries of a list of records, or of a single record."""
        entries = [raw] if isinstance(raw, str | dict) else raw
        if not isinstance(entries, list | tuple) or not 0 < len(entries) <= MOST_CASES:
            allowed = f"a list of 1 to {MOST_CASES} records"
            self._fault(field, describe(raw), allowed, "write [loma-prieta, el-centro]")
            return []
        places = [f"{field}[{index}]" for index in range(len(entries))]
        return list(zip(places, places, entries, strict=True))

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


def _held(group: RecordCases, given: object) -> dict[str, Any]:
    """Return an excitation that consists of records, in the form in which a specification stores it."""
    assert isinstance(given, Mapping)  # an excitation by records is a mapping
    name = {key: given[key] for key in ("name",) if key in given}
    # the parameters of a sweep define the samples; documents of other records contain a hash of the samples
    sources = [source.document() for source in group.sources]
    shaken = {"sweep": given["sweep"]} if "sweep" in given else {"records": sources}
    return name | shaken | {"scales": list(group.scales), "tail_s": group.tail_s}
