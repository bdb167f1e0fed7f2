"""A record as named in a study: its id, and the hash that identifies its samples."""

import json
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from damperlab.studies.faults import Fault, StudyFaults, attempt, describe, listing, unknown_key
from damperlab.studies.ground.generated import GENERATED, RECIPES, Recipe, each_of, recipe_in
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.question import read_record_reference
from damperlab.studies.ground.shelf import Shelf

Entry = tuple[str, str, object]
"""An entry of a list: its place, the prefix of the fields in faults of its parts, and the record as written."""
_KEYS = ("id", "sha256", "step_s", "samples", *GENERATED)


@dataclass(frozen=True)
class RecordSource:
    """A record of a study.

    Parameters
    ----------
    id : str
        Of the record.
    sha256 : str
        Of time step and samples, 64 hexadecimal digits; see `GroundMotion.content`.
    step_s : float
        Time step [s].
    samples : int
        Number of samples.
    recipe : str
        The definition of a generated record, as JSON of a mapping with one of `GENERATED`; empty for a stored
        record.
    """

    id: str
    sha256: str
    step_s: float
    samples: int
    recipe: str = ""

    @property
    def key(self) -> str:
        """Name of the samples in a cube."""
        return f"records/{self.id}.f8"

    @property
    def duration_s(self) -> float:
        """Time from the first sample to the last [s]."""
        return (self.samples - 1) * self.step_s

    def document(self) -> dict[str, Any]:
        """Give the source as JSON-able data."""
        held: dict[str, Any] = {
            "id": self.id,
            "sha256": self.sha256,
            "step_s": self.step_s,
            "samples": self.samples,
        }
        return held | (json.loads(self.recipe) if self.recipe else {})

    @property
    def generated(self) -> Recipe | None:
        """Definition of a generated record, if its method is one of `RECIPES`; otherwise None."""
        recipe = json.loads(self.recipe) if self.recipe else {}
        return next((RECIPES[way](recipe[way]) for way in recipe if way in RECIPES), None)

    @property
    def called(self) -> str:
        """Name in a sentence: its id, or its definition."""
        generated = self.generated
        return self.id if generated is None else generated.name

    def read(self, content: bytes) -> GroundMotion:
        """Read the samples from their file in a cube.

        Raises
        ------
        ValueError
            If they do not match `sha256`.
        """
        motion = GroundMotion(self.id, self.step_s, np.frombuffer(content[8:], "<f8"))
        if motion.sha256 != self.sha256:
            raise ValueError(f"the samples of record {self.id} are not those of the study")
        return motion


def read_source(raw: object, shelf: Shelf | None) -> tuple[RecordSource, GroundMotion | None]:
    """Read one entry of a study's ``records``.

    Parameters
    ----------
    raw : object
        The id of a record, an earthquake's name, one of `GENERATED` as
        ``{"sweep": {…}}``, or a `RecordSource.document`.
    shelf : Shelf, optional
        Store of records. Without it, an entry with a digest is accepted unchecked, as in a stored study, and an entry
        without a digest finds only built-in records.

    Returns
    -------
    source : RecordSource
        The record.
    motion : GroundMotion or None
        Its samples, if they were looked up.

    Raises
    ------
    StudyFaults
        If there is no such record, or its samples have changed.
    """
    if not isinstance(raw, dict):
        return _found(*read_record_reference(raw, shelf or Shelf.none()))
    faults = [unknown_key(key, key, _KEYS, raw) for key in raw if key not in _KEYS]
    if faults:
        raise StudyFaults(faults)
    ways = [way for way in GENERATED if way in raw]
    if len(ways) > 1:
        told = f"{{field}} and `{ways[0]}` are given together: a record is generated in one way."
        found, allowed = describe(raw[ways[1]]), f"one of {listing(GENERATED)}"
        raise StudyFaults([Fault(ways[1], found, allowed, "write two records", told)])
    if "id" not in raw and not ways:
        raise StudyFaults([Fault("id", "nothing", "the id of a record", "add `id`, or write the id alone")])
    if shelf is None and "sha256" in raw:
        for way in ways:
            if way in RECIPES:
                RECIPES[way](raw[way])
        return _stored(raw), None
    if ways:
        motion = GENERATED[ways[0]](raw[ways[0]])
        source = _source(f"u-{motion.digest}", motion, _recipe_of(raw))
    else:
        source, motion = _found(*read_record_reference(raw["id"], shelf or Shelf.none()))
    if raw.get("sha256", source.sha256) != source.sha256:
        found = f"record {source.id} with the digest {describe(raw['sha256'])}"
        advice = "leave `sha256` out to take the record as it is now"
        told = f"The samples of record {source.id} have changed: their SHA-256 is {source.sha256} now."
        raise StudyFaults([Fault("sha256", found, f"{source.sha256}, that of the record here", advice, told)])
    return source, motion


def read_sources(raw: object, shelf: Shelf | None) -> list[tuple[RecordSource, GroundMotion | None]]:
    """Read one entry of ``records`` as `read_source` does; with ``seeds`` it stands for that number of records.

    Raises
    ------
    StudyFaults
        As `read_source`.
    """
    entries, faults = each_of(raw)
    found = attempt(lambda: [read_source(each, shelf) for each in entries], [], faults)
    if faults:
        raise StudyFaults(faults)
    return found


def read_entries(
    entries: list[Entry], shelf: Shelf | None, named: set[str], faults: list[Fault]
) -> list[tuple[str, RecordSource, GroundMotion | None]]:
    """Read a list of records, each once; append faults to `faults`.

    Parameters
    ----------
    entries : list of Entry
        As they are written.
    shelf : Shelf, optional
        As in `read_source`.
    named : set of str
        Ids that are already used; the new ids are added.
    faults : list of Fault
        Faults so far.

    Returns
    -------
    list of tuple
        Each record with the place of its entry; an entry with seeds has several.
    """
    found = []
    for place, within, entry in entries:
        try:
            read = read_sources(entry, shelf)
        except StudyFaults as caught:
            # the fault of a missing record names the key `record`, which a list does not have
            faults += [
                replace(each, field=place) if each.field == "record" else each.under(within)
                for each in caught.faults
            ]
            continue
        for source, motion in read:
            if source.id in named:
                told = f"{{field}} names {source.called} a second time."
                words = f"{source.called} a second time"
                faults.append(Fault(place, words, "each record once", "remove the duplicate", told))
            named.add(source.id)
            found.append((place, source, motion))
    return found


def _found(record_id: str, motion: GroundMotion) -> tuple[RecordSource, GroundMotion]:
    return _source(record_id, motion), motion


def _source(record_id: str, motion: GroundMotion, recipe: str = "") -> RecordSource:
    return RecordSource(record_id, motion.sha256, motion.step_s, int(motion.acceleration_m_s2.size), recipe)


def _recipe_of(raw: dict[str, Any]) -> str:
    way = recipe_in(raw)
    return json.dumps({way: raw[way]}, sort_keys=True) if way else ""


def _stored(raw: dict[str, Any]) -> RecordSource:
    try:
        return RecordSource(
            str(raw["id"]),
            str(raw["sha256"]),
            float(raw["step_s"]),
            int(raw["samples"]),
            _recipe_of(raw),
        )
    except (KeyError, TypeError, ValueError):
        allowed = "id, sha256, step_s and samples as a stored study has them"
        raise StudyFaults([Fault("", describe(raw), allowed, "write the id of the record alone")]) from None
