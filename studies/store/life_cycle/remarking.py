"""Storage of the names, tags and notes of studies, which have no effect on results."""

import json
from collections.abc import Callable

from sqlalchemy import delete, select, update

from damperlab.studies.remarks import Remarks
from damperlab.studies.store.catalogue.rows import record_of, study_row
from damperlab.studies.store.catalogue.tables import facts, studies
from damperlab.studies.store.faults import StoreFault, StudyNotFound, cannot_use
from damperlab.studies.store.life_cycle.lookup import Lookup
from damperlab.studies.store.life_cycle.manifest import PUT_OFF, drop_marks, keep_marks, put_off_marks
from damperlab.studies.store.record import Record
from damperlab.studies.vocabulary import ENDED


class Remarking(Lookup):
    """The part of a store that stores remarks."""

    def remark(self, study_id: str, remarks: Remarks, *, at_once: bool = True) -> Record:
        """Store a user's remarks about a study in the catalogue, and for an ended study also in the cube.

        Parameters
        ----------
        study_id : str
            Complete id of the study.
        remarks : Remarks
            The remarks. A remark that is None is not changed.
        at_once : bool
            Whether to write the remarks into the cube now. If not, `keep_late_marks` writes the remarks later.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        StoreFault
            If the remarks cannot be written.
        """
        tags = None if remarks.tags is None else json.dumps(remarks.tags)
        said = {"tags": tags, "note": remarks.note, "name": remarks.name}
        change = {name: value for name, value in said.items() if value is not None}
        with self.catalogue.writing() as connection:
            number = study_row(connection, study_id).number
            connection.execute(update(studies).where(studies.c.number == number).values(change))
            row = study_row(connection, study_id)
            if row.state in ENDED:
                # write the marks again, because a lost catalogue is restored from the marks in the cube
                put_off_marks(connection, study_id)
        if row.state in ENDED and at_once:
            self._keep_late(study_id)
        return record_of(row)

    def keep_late_marks(self, stop: Callable[[], bool] = lambda: False) -> None:
        """Write the postponed done-marks of ended studies into their cubes.

        Parameters
        ----------
        stop : callable
            Function that is called before each study; if it returns true, the remaining studies are left for later.

        Raises
        ------
        StoreFault
            If the marks of a study cannot be written. The marks of all other studies are still written.
        """
        failed: StoreFault | None = None
        for key in self._put_off():
            if stop():
                return
            try:
                self._keep_late(key.removeprefix(PUT_OFF))
            except StoreFault as error:  # continue with the other studies
                failed = failed or error
        if failed is not None:
            raise failed

    def _put_off(self, key: str = PUT_OFF) -> dict[str, str]:
        query = select(facts.c.key, facts.c.value).where(facts.c.key.startswith(key, autoescape=True))
        with self.catalogue.reading() as connection:
            return {row.key: row.value for row in connection.execute(query)}

    def _keep_late(self, study_id: str) -> None:
        key = f"{PUT_OFF}{study_id}"
        note = self._put_off(key).get(key)
        try:
            # the done-marks of a resumed study are written when the study ends
            before = self.find(study_id)
            if before.ended:
                keep_marks(self, study_id, {})
                after = self.find(study_id)
                if (after.revision, after.state, after.finished) != (
                    before.revision,
                    before.state,
                    before.finished,
                ):
                    # the study changed during this write, which may have replaced newer marks
                    with self.catalogue.reading() as connection:
                        number = study_row(connection, study_id).number
                    drop_marks(self.cube_shelf(study_id, number))
                    self._keep_late(study_id)
                    return
        except (StudyNotFound, FileNotFoundError):
            pass  # the study was deleted or its cube is lost, so there is no place to write to
        except OSError as error:
            raise cannot_use(self.shelf.address, error) from error
        with self.catalogue.writing() as connection:
            # delete only this note: marks that were postponed meanwhile have another note
            connection.execute(delete(facts).where(facts.c.key == key, facts.c.value == note))
