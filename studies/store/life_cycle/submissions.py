"""Recomputation, start and deletion of studies."""

import json
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from sqlalchemy import Connection, Row, delete, func, select, update

from damperlab.studies.digest import family_digest
from damperlab.studies.faults import Fault
from damperlab.studies.store.catalogue.quota import Ledger
from damperlab.studies.store.catalogue.rows import (
    alive_row,
    in_trash,
    log_event,
    newest_row,
    record_of,
    study_row,
    unknown_study,
)
from damperlab.studies.store.catalogue.rowsum import is_sound, require_row
from damperlab.studies.store.catalogue.tables import done_blocks, studies
from damperlab.studies.store.cube.definition import parse_stored, with_attachments
from damperlab.studies.store.cube.description import first_pieces
from damperlab.studies.store.faults import NothingToDo, telling, using
from damperlab.studies.store.files.shelf import TOMBSTONE
from damperlab.studies.store.life_cycle.claims import require_free
from damperlab.studies.store.life_cycle.entering import Entering, Entry
from damperlab.studies.store.life_cycle.manifest import put_tombstone
from damperlab.studies.store.provenance import asked_by, signed, submitter
from damperlab.studies.store.record import Record
from damperlab.studies.vocabulary import ENDED

_AT_ONCE = 5000  # largest number of done-marks that one transaction removes


class Submissions(Entering):
    """The part of a store that submits, starts, recomputes and deletes studies."""

    def recompute(self, study_id: str, provenance: dict[str, str]) -> tuple[Record, bool]:
        """Enter a new version of a study, which today's solver will compute. The older versions are kept.

        Parameters
        ----------
        study_id : str
            Complete id of any version of the study.
        provenance : dict of str
            Provenance of today's solver.

        Returns
        -------
        record : Record
            Record of the new version. If the newest existing version is not outdated, its record is returned instead.
        created : bool
            Whether a new version was entered.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        NothingToDo
            If today's solver has computed the complete study, or if the study has no results yet.
        StoreFault, QuotaReached
            If the new version cannot be stored, or exceeds a quota (see `submit`).
        """
        with self.catalogue.reading() as connection:
            known = study_row(connection, study_id)
        shelf = self.cube_shelf(study_id, known.number)
        stored = parse_stored(record_of(known).definition, known.digest)
        with telling(shelf, None, "a ground-motion record"):
            study = with_attachments(stored, shelf)

        def decide(
            connection: Connection,
        ) -> tuple[list[Entry], Callable[[list[Record]], tuple[Record, bool]]]:
            older = record_of(study_row(connection, study_id))
            if not older.blocks_done or (older.state == "done" and not older.outdated):
                raise _nothing_to_recompute(older)
            row = newest_row(connection, older.digest)
            newest = record_of(row) if row is not None else older
            if newest.id != older.id and not newest.outdated:
                return [], lambda entered: (newest, False)
            entry = Entry(
                study, older.chunk, signed(provenance), older.reuse, newest.version + 1, older.priority
            )
            Ledger(connection, self.quota).enter(submitter.get(), study.points, entry.bytes, 1)
            return [entry], lambda entered: (entered[0], True)

        return self.enter(decide, "entered to be computed again")

    def begin(self, study_id: str, facts: Mapping[str, str], owner: str | None = None) -> Record:
        """Record the solver of a study before the first block is computed.

        The new solver replaces the solver that was recorded at submission if the study has no results yet.

        Parameters
        ----------
        study_id : str
            Complete id of the study.
        facts : mapping of str
            Provenance from the workers. If the `identity` in `facts` is already recorded, nothing changes.
        owner : str, optional
            Owner of the claim on the study. If another owner has the claim, nothing changes.

        Returns
        -------
        Record
            Present record of the study. If blocks are done, the caller must compare the provenance with `facts`.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        StoreFault
            If the cube cannot be written.
        """
        with self.catalogue.reading() as connection:
            row = study_row(connection, study_id)
        if not _may_begin(row, facts, owner):
            return record_of(row)
        provenance = {**record_of(row).provenance, **facts}
        # write the cube before the row; if the process dies between the two, the next call writes both again
        self._describe(row, provenance)
        with self.catalogue.writing() as connection:
            now = study_row(connection, study_id)
            begins = _may_begin(now, facts, owner) and now.provenance == row.provenance
            if begins:
                study = parse_stored(record_of(row).definition, row.digest)
                change = {"provenance": json.dumps(provenance), "family": family_digest(study, provenance)}
                connection.execute(update(studies).where(studies.c.number == row.number).values(change))
                log_event(connection, study_id, f"to be computed by solver {facts['identity']}")
                now = study_row(connection, study_id)
        if not begins:
            # another runner has taken over the study, so write the cube again as the catalogue describes it
            self._describe(now, record_of(now).provenance)
        return record_of(now)

    def _describe(self, row: Row[Any], provenance: Mapping[str, str]) -> None:
        """Write the description and the coordinates of a study's cube; raise `StoreFault` if they cannot be written."""
        record = record_of(row)
        study = parse_stored(record.definition, record.digest)
        shelf = self.cube_shelf(row.id, row.number)
        with using(shelf.address):
            shelf.fill(first_pieces(study, record.chunk, provenance, reuse=record.reuse, created=row.created))

    def delete(self, study_id: str, keep_seconds: float = 0.0) -> None:
        """Delete a study. The files of the study are removed later, by `bury`.

        Parameters
        ----------
        study_id : str
            Complete id of the study.
        keep_seconds : float
            Time for which the study stays in the trash [s]. During this time, `undelete` can restore the study.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        StudyBusy
            If the study has not ended, and a process works on the study.
        """
        with self.catalogue.writing() as connection:
            row = study_row(connection, study_id)
            if row.state not in ENDED:
                require_free(row, "delete")
            until = time.time() + keep_seconds
            connection.execute(update(studies).where(studies.c.number == row.number).values(deleted=until))
            log_event(connection, study_id, "deleted")
        # record the deletion in the cube only after the commit, so that this record is never wrong
        with suppress(OSError):
            put_tombstone(self.cube_shelf(study_id, row.number), until)

    def trashed(self, study_id: str) -> Record:
        """Return the record of a deleted study that can be restored; raise `StudyNotFound` if no such study exists."""
        with self.catalogue.reading() as connection:
            return record_of(_trashed_row(connection, study_id))

    def undelete(self, study_id: str) -> Record:
        """Restore a deleted study from the trash.

        Raises
        ------
        StudyNotFound
            If the study is not in the trash.
        NothingToDo
            If the same study was submitted again after the deletion.
        """
        with self.catalogue.reading() as connection:
            row = _restorable_row(connection, study_id)
        shelf = self.cube_shelf(study_id, row.number)
        with using(shelf.address):
            # remove the record of the deletion before the commit, so that no existing study has such a record
            shelf.remove(TOMBSTONE)
        try:
            with self.catalogue.writing() as connection:
                number = _restorable_row(connection, study_id).number
                connection.execute(update(studies).where(studies.c.number == number).values(deleted=None))
                log_event(connection, study_id, "restored from the trash")
                return record_of(study_row(connection, study_id))
        except Exception:
            with suppress(OSError):
                put_tombstone(shelf, row.deleted)
            raise

    def bury(self, before: float | None = None, stop: Callable[[], bool] = lambda: False) -> None:
        """Remove the files of deleted studies, then the done-marks and definitions of these studies.

        An empty row remains in the catalogue, so that the number and the revisions of the study are never used again.

        Parameters
        ----------
        before : float, optional
            Remove studies that were deleted before this time, in seconds since 1970; by default now.
        stop : callable
            Function that is called before each study; if it returns true, the remaining studies are left for later.
        """
        c = studies.c
        before = time.time() if before is None else before
        with self.catalogue.reading() as connection:
            rows = connection.execute(select(studies).where(c.deleted <= before, c.definition != "")).all()
        # if a row is damaged, the study may not have been deleted, so its files are kept
        for row in (row for row in rows if is_sound(studies, row)):
            if stop():
                return
            try:
                self.cube_shelf(row.id, row.number).clear()
            except OSError:
                continue  # the next call tries again
            while self._forget_marks(row.number):
                pass
            with self.catalogue.writing() as connection:
                texts = dict.fromkeys(("name", "definition", "provenance", "family"), "")
                empty = {**texts, "message": None, **asked_by({})}
                connection.execute(update(studies).where(c.number == row.number).values(empty))

    def _forget_marks(self, number: int) -> bool:
        """Remove up to `_AT_ONCE` done-marks of a deleted study. Return whether there may be more done-marks."""
        b = done_blocks.c
        with self.catalogue.writing() as connection:
            some = select(b.block).where(b.study == number).order_by(b.block).limit(_AT_ONCE)
            last = connection.execute(select(func.max(some.subquery().c.block))).scalar()
            if last is None:
                return False
            connection.execute(delete(done_blocks).where(b.study == number, b.block <= last))
            return True


def _trashed_row(connection: Connection, study_id: str) -> Row[Any]:
    query = select(studies).where(studies.c.id == study_id, in_trash()).order_by(studies.c.number.desc())
    row = connection.execute(query.limit(1)).one_or_none()
    if row is None:
        raise unknown_study(connection, study_id)
    require_row(studies, row, study_id)
    return row


def _restorable_row(connection: Connection, study_id: str) -> Row[Any]:
    row = _trashed_row(connection, study_id)
    if alive_row(connection, study_id) is not None:
        told = f"Study {study_id} was submitted again since it was deleted."
        allowed, advice = "a study that was not submitted again", "delete the study that was submitted again"
        raise NothingToDo(Fault("study", study_id, allowed, advice, told))
    return row


def _may_begin(row: Row[Any], facts: Mapping[str, str], owner: str | None) -> bool:
    """Whether this owner may record the solver of a study: another solver is recorded, and no block is done."""
    known = json.loads(row.provenance).get("identity") == facts["identity"]
    return not known and not row.blocks_done and owner in (None, row.claim_owner)


def _nothing_to_recompute(record: Record) -> NothingToDo:
    if not record.blocks_done:
        found, advice = f"{record.id}, which has no results yet", f"run `damperlab run {record.id}`"
        told = f"Study {record.id} has no results yet, so there is nothing to compute again."
    else:
        found = f"{record.id}, whose results today's solver computed: it would give the same bits"
        told = (
            f"The results of study {record.id} were computed by today's solver, which would give the same "
            "bits again."
        )
        advice = "there is nothing to do; `damperlab store verify` checks that the results are intact"
    allowed = "a study whose results another solver computed"
    return NothingToDo(Fault("study", found, allowed, advice, told))
