"""Deletion of studies, and their restoration from the trash."""

import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from sqlalchemy import ColumnElement, Connection, Row, delete, func, or_, select

from damperlab.studies.store.catalogue.rows import (
    alive_row,
    change_studies,
    in_trash,
    log_event,
    record_of,
    require_free,
    study_row,
    unknown_study,
)
from damperlab.studies.store.catalogue.rowsum import is_sound, require_row
from damperlab.studies.store.catalogue.tables import done_blocks, studies
from damperlab.studies.store.cubes import Cubes
from damperlab.studies.store.faults import NothingToDo, using
from damperlab.studies.store.files.shelf import TOMBSTONE
from damperlab.studies.store.life_cycle.manifest import put_tombstone
from damperlab.studies.store.provenance import asked_by
from damperlab.studies.store.record import Record
from damperlab.studies.vocabulary import ENDED

_AT_ONCE = 5000  # largest number of done-marks that one transaction removes


class Deletion(Cubes):
    """The part of a store that deletes and restores studies."""

    def delete(self, study_id: str, keep_seconds: float = 0.0) -> None:
        """Delete a study. The files of the study are removed later, by `bury`.

        The study stays in the trash for `keep_seconds`. During this time, `undelete` can restore the study.

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
            change_studies(connection, [row.number], {"deleted": until})
            log_event(connection, study_id, "deleted")
        # record the deletion in the cube only after the commit, because the commit may fail
        with suppress(OSError):
            put_tombstone(self.cube_shelf(study_id, row.number), until)

    def trashed(self, ref: str) -> Record:
        """Return the record of the study in the trash with this id or name. If there are several, the last deleted one
        is used.

        Raises
        ------
        StudyNotFound
            If no such study is in the trash.
        """
        named = or_(studies.c.id == ref, studies.c.name == ref)
        with self.catalogue.reading() as connection:
            return record_of(_trashed_row(connection, ref, named))

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
                change_studies(connection, [number], {"deleted": None})
                log_event(connection, study_id, "restored from the trash")
                return record_of(study_row(connection, study_id))
        except Exception:
            with suppress(OSError):
                put_tombstone(shelf, row.deleted)
            raise

    def bury(self, before: float | None = None, stop: Callable[[], bool] = lambda: False) -> None:
        """Remove the files of deleted studies, then the done-marks and definitions of these studies.

        An empty row remains in the catalogue, so that the serial number and the revisions of the study are never used
        again. Only studies deleted up to the time `before` are removed (in seconds since 1970, by default now). The
        function `stop` is called before each study; if it returns true, the remaining studies are left for later.
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
                change_studies(connection, [row.number], empty)

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


def _trashed_row(connection: Connection, ref: str, named: ColumnElement[bool]) -> Row[Any]:
    query = select(studies).where(named, in_trash()).order_by(studies.c.deleted.desc())
    row = connection.execute(query.limit(1)).one_or_none()
    if row is None:
        raise unknown_study(connection, ref)
    require_row(studies, row, row.id)
    return row


def _restorable_row(connection: Connection, study_id: str) -> Row[Any]:
    row = _trashed_row(connection, study_id, studies.c.id == study_id)
    if alive_row(connection, study_id) is not None:
        told = f"Study {study_id} was submitted again since it was deleted."
        allowed, advice = "a study that was not submitted again", "delete the study that was submitted again"
        raise NothingToDo("study", study_id, allowed, advice, told)
    return row
