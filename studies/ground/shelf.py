"""The store of records by id: built-in records, and records uploaded into a data directory."""

import io
import json
import os
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from damperlab.studies.faults import describe, listing, nearest
from damperlab.studies.ground.builtin import FIRST_COMPONENTS, builtin_ids, builtin_record, whole_id
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.store.faults import StoreFault, lost_files
from damperlab.studies.store.files.folder import Folder, sync_path
from damperlab.studies.store.files.sealed import PLACEHOLDER, is_sealed, require_seal, seal
from damperlab.studies.store.kept_quota import USUAL, KeptQuota
from damperlab.studies.store.provenance import SUBMITTED_BY, signed

_SUMMARY = frozenset(GroundMotion("", 1.0, np.ones(2)).summary())
"""Keys of a record's summary."""


class RecordNotFound(StoreFault):
    """Raised if no record has the requested id."""


class RecordDamaged(RecordNotFound):
    """Raised if the files of an uploaded record are damaged."""


class RecordKept(StoreFault):
    """Raised if a record cannot be removed."""


class ShelfFull(StoreFault):
    """Raised if no further record can be stored."""


_putting = threading.Lock()
"""Lock for counting the records and writing a new record, so that simultaneous requests cannot exceed the limit."""


class Shelf:
    """Store of the records in one data directory. Each record has two files that never change: samples and summary.

    Parameters
    ----------
    data_dir : Path
        Data directory, in which the folder `records` is created with the first record.
    quota : KeptQuota
        Limit on the number of stored records.
    """

    def __init__(self, data_dir: Path, quota: KeptQuota = USUAL) -> None:
        self.folder = Path(data_dir) / "records"
        self._quota = quota

    @classmethod
    def none(cls) -> "Shelf":
        """Return a store that contains only the built-in records."""
        return cls(Path(os.devnull))  # a path below which no folder can exist

    def ids(self) -> tuple[str, ...]:
        """Return the ids of all records; built-in records come first."""
        return (*builtin_ids(), *self._uploaded())

    def summaries(self) -> list[dict[str, Any]]:
        """Return id, summary and owner of every record. The samples of uploaded records are not read."""
        built_in: list[dict[str, Any]] = [
            {"id": name, **builtin_record(name).summary()} for name in builtin_ids()
        ]
        return built_in + [{"id": name, **self.summary(name)} for name in self._uploaded()]

    def summary(self, record_id: str) -> dict[str, Any]:
        """Return the summary of an uploaded record without its samples, or raise `RecordDamaged`."""
        try:
            content = (self.folder / f"{record_id}.json").read_bytes()
            if is_sealed(content):
                require_seal(content)
            kept: dict[str, Any] = json.loads(content)
            # summaries of early versions have no checksum
            if not isinstance(kept, dict) or set(kept) - {SUBMITTED_BY, "crc32c"} != _SUMMARY:
                raise ValueError("its entries are not those of a summary")
            if f"u-{kept['digest']}" != record_id:
                raise ValueError(f"it belongs to record {kept['digest']}")
        except (OSError, ValueError) as error:
            raise _damaged(record_id, str(error)) from error
        kept.pop("crc32c", None)
        return kept

    def damaged(self, pause: Callable[[], None] = lambda: None) -> Iterator[tuple[str, str]]:
        """Read every uploaded record, and yield the id of each damaged record with the reason.

        Parameters
        ----------
        pause : callable
            Function called before each record is read.
        """
        for record_id in self._uploaded():
            pause()
            try:
                self._motion(record_id)
            except RecordDamaged as error:
                yield record_id, str(error)

    def owner(self, record_id: str) -> str | None:
        """Return the owner of a record, or None for a built-in record or a record stored without an access key.

        Raises
        ------
        RecordNotFound
            If no record has this id. The name of an earthquake is not accepted.
        """
        if record_id in builtin_ids():
            return None
        self._require_uploaded(record_id)
        owner: str | None = self.summary(record_id).get(SUBMITTED_BY)
        return owner

    def remove(self, record_id: str) -> None:
        """Remove an uploaded record. Studies that use the record keep their own copies of the samples.

        Raises
        ------
        RecordNotFound
            If no record has this id. The name of an earthquake is not accepted.
        RecordKept
            If the record is built in.
        """
        if record_id in builtin_ids():
            advice = "only uploaded records can be removed"
            told = f"Record {record_id} is built in and cannot be removed."
            found = f"{record_id}, which is built in"
            raise RecordKept("record", found, "an uploaded record", advice, told)
        self._require_uploaded(record_id)
        # the summary is removed first: a record without a summary does not exist
        for suffix in (".json", ".npy"):
            (self.folder / f"{record_id}{suffix}").unlink(missing_ok=True)
        sync_path(self.folder)

    def _require_uploaded(self, record_id: str) -> None:
        if record_id not in set(self._uploaded()):
            advice = "`GET /api/v1/records` lists them"
            raise RecordNotFound("record", describe(record_id), "the whole id of an uploaded record", advice)

    def _uploaded(self) -> Iterator[str]:
        return (path.stem for path in sorted(self.folder.glob("u-*.json")))

    def get(self, record_id: str) -> tuple[str, GroundMotion]:
        """Return id and samples of a record. `record_id` may also be the name of an earthquake.

        Raises
        ------
        RecordNotFound
            If the record does not exist.
        """
        whole = whole_id(record_id)
        if whole in builtin_ids():
            return whole, builtin_record(whole)
        if whole in set(self._uploaded()):
            return whole, self._motion(whole)
        near = self._named(record_id) or nearest(record_id, (*FIRST_COMPONENTS, *self.ids()))
        advice = f"did you mean {near}?" if near else "list the records, or upload this one"
        allowed = f"one of {listing(FIRST_COMPONENTS)}, a component of these, or the id of an uploaded record"
        raise RecordNotFound("record", describe(record_id), allowed, advice)

    def _named(self, name: str) -> str | None:
        """Return the id of an uploaded record with this name."""
        for record_id in self._uploaded():
            with suppress(RecordDamaged):
                if self.summary(record_id)["name"] == name:
                    return record_id
        return None

    def _motion(self, record_id: str) -> GroundMotion:
        """Read an uploaded record. Raise `RecordDamaged` if the samples do not match the id."""
        kept = self.summary(record_id)
        try:
            samples = np.load(self.folder / f"{record_id}.npy", allow_pickle=False)
            motion = GroundMotion(kept["name"], kept["step_s"], samples, kept["source"])
            if f"u-{motion.digest}" != record_id:
                raise ValueError("its samples are not those that were uploaded")
        # numpy may raise any exception for a damaged file
        except Exception as error:
            raise _damaged(record_id, str(error)) from error
        return motion

    def put(self, motion: GroundMotion) -> tuple[str, bool]:
        """Store a record if its samples are not stored yet, or replace its files if they are damaged.

        Returns
        -------
        record_id : str
            Id of the record.
        new : bool
            False if the record existed already.

        Raises
        ------
        ShelfFull
            If the total number of records, or the number of the owner's records, is at its limit.
        """
        record_id = f"u-{motion.digest}"
        with _putting:
            kept = set(self._uploaded())
            if record_id in kept:
                with suppress(RecordDamaged):
                    self._motion(record_id)
                    return record_id, False
            else:
                self._quota.require("record", [self._owner_or_nobody(each) for each in kept], ShelfFull)
            self.folder.mkdir(parents=True, exist_ok=True)
            sync_path(self.folder.parent)
            samples = io.BytesIO()
            np.save(samples, motion.acceleration_m_s2, allow_pickle=False)
            # the summary is written last: a record without a summary does not exist
            Folder(self.folder).put(f"{record_id}.npy", samples.getvalue())
            summary = {"crc32c": PLACEHOLDER, **signed(motion.summary())}
            Folder(self.folder).put(f"{record_id}.json", seal(json.dumps(summary).encode()))
            return record_id, True

    def _owner_or_nobody(self, record_id: str) -> str | None:
        with suppress(RecordDamaged):
            owner: str | None = self.summary(record_id).get(SUBMITTED_BY)
            return owner
        return None


def _damaged(record_id: str, why: str) -> RecordDamaged:
    advice = "upload it again, which replaces its files; or remove them from the folder `records`"
    return lost_files(RecordDamaged, "record", record_id, why, advice)
