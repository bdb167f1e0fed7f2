"""Repeated submission for another solver, and deletion."""

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
from damperlab.studies.store.cube.chunks import telling
from damperlab.studies.store.cube.definition import parse_stored, with_attachments
from damperlab.studies.store.cube.description import first_pieces
from damperlab.studies.store.faults import NothingToDo, using
from damperlab.studies.store.files.shelf import TOMBSTONE
from damperlab.studies.store.life_cycle.claims import require_free
from damperlab.studies.store.life_cycle.entering import Entering, Entry
from damperlab.studies.store.life_cycle.manifest import put_tombstone
from damperlab.studies.store.provenance import asked_by, signed, submitter
from damperlab.studies.store.record import Record
from damperlab.studies.vocabulary import ENDED

_AT_ONCE = 5000  # most marks removed in one transaction


class Submissions(Entering):
    """The part of the store that enters studies again, starts them and deletes them."""

    def recompute(self, study_id: str, provenance: dict[str, str]) -> tuple[Record, bool]:
        """Enter a study once more, for today's solver, and keep the old version.

        Parameters
        ----------
        study_id : str
            The complete id of any version.
        provenance : dict of str
            Provenance of today's solver.

        Returns
        -------
        record : Record
            The new version, or the newest one if it already belongs to today's solver or waits for it.
        created : bool
            Whether it is new.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        NothingToDo
            If today's solver has already computed the complete study, or it has no results yet.
        StoreFault, QuotaReached
            As for `submit`.
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
        """Record the solver of a study before its first block: one solver on one kind of processor computes a cube.

        If the solver changed while the study waited, the study has no results yet, so the new solver replaces the
        recorded one.

        Parameters
        ----------
        study_id : str
            The whole id.
        facts : mapping of str
            Provenance from the workers. If its `identity` is the recorded one, nothing changes.
        owner : str, optional
            Owner of the claim on the study; nothing changes if another owner has it.

        Returns
        -------
        Record
            The study's present record. If blocks are done, its provenance is unchanged, and the caller must compare it
            with `facts`.

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
        # the cube is written before the row; if the process dies in between, the next call writes both
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
            # another runner has taken over the study, so its cube is written again from the catalogue
            self._describe(now, record_of(now).provenance)
        return record_of(now)

    def _describe(self, row: Row[Any], provenance: Mapping[str, str]) -> None:
        """Write the study's data into its cube; raise `StoreFault` if it cannot be written."""
        record = record_of(row)
        study = parse_stored(record.definition, record.digest)
        shelf = self.cube_shelf(row.id, row.number)
        with using(shelf.address):
            shelf.fill(first_pieces(study, record.chunk, provenance, reuse=record.reuse, created=row.created))

    def delete(self, study_id: str, keep_seconds: float = 0.0) -> None:
        """Delete a study; `bury` removes its files afterwards, which may take long.

        Parameters
        ----------
        study_id : str
            Its whole id.
        keep_seconds : float
            Time in the trash, from where `undelete` restores it.

        The study is gone once the deletion is committed. The next call of `bury`, in this process or another, removes the
        files. A service calls it in the background, as do `damperlab delete` and `damperlab store gc`.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        StudyBusy
            If a process works on it and it has not ended. After its end, a runner may still be cleaning up.
        """
        with self.catalogue.writing() as connection:
            row = study_row(connection, study_id)
            if row.state not in ENDED:
                require_free(row, "delete")
            until = time.time() + keep_seconds
            connection.execute(update(studies).where(studies.c.number == row.number).values(deleted=until))
            log_event(connection, study_id, "deleted")
        # written after the commit, because the record beside the cube must never be wrong; its absence matters only if
        # the catalogue is lost too
        with suppress(OSError):
            put_tombstone(self.cube_shelf(study_id, row.number), until)

    def trashed(self, study_id: str) -> Record:
        """Give a deleted study that can be restored; raise `StudyNotFound` if there is none."""
        with self.catalogue.reading() as connection:
            return record_of(_trashed_row(connection, study_id))

    def undelete(self, study_id: str) -> Record:
        """Restore a study from the trash, as it was.

        Raises
        ------
        StudyNotFound
            If it is not there.
        NothingToDo
            If it was submitted again meanwhile.
        """
        with self.catalogue.reading() as connection:
            row = _restorable_row(connection, study_id)
        shelf = self.cube_shelf(study_id, row.number)
        with using(shelf.address):
            # removed before the commit, because no record beside the cube may mark an existing study as deleted
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
        """Remove the files of studies that were deleted before a time, in seconds since 1970, by default now.

        The row of a deleted study loses its marks and its definition last, so that an interrupted removal is found
        again by the next call. An empty row remains, so that the study's number and revisions are never used twice.
        """
        c = studies.c
        before = time.time() if before is None else before
        with self.catalogue.reading() as connection:
            rows = connection.execute(select(studies).where(c.deleted <= before, c.definition != "")).all()
        # a damaged row may belong to a study that was not deleted: its files stay
        for row in (row for row in rows if is_sound(studies, row)):
            if stop():
                return
            try:
                self.cube_shelf(row.id, row.number).clear()
            except OSError:
                continue  # found again by the next call
            while self._forget_marks(row.number):
                pass
            with self.catalogue.writing() as connection:
                texts = dict.fromkeys(("name", "definition", "provenance", "family"), "")
                empty = {**texts, "message": None, **asked_by({})}
                connection.execute(update(studies).where(c.number == row.number).values(empty))

    def _forget_marks(self, number: int) -> bool:
        """Remove some marks of a deleted study, and say whether there may be more. It removes few at a time, so that
        other writers do not wait long.
        """
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
        allowed, advice = "a study that was not submitted again", "delete the other one first"
        raise NothingToDo(Fault("study", study_id, allowed, advice, told))
    return row


def _may_begin(row: Row[Any], facts: Mapping[str, str], owner: str | None) -> bool:
    """Whether this owner has yet to record the solver of a study."""
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
