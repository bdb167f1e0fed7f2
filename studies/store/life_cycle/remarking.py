"""Tags and notes in the catalogue; they are no part of what a study asks, and change no result."""

import json
import uuid
from collections.abc import Callable

from sqlalchemy import delete, select, update

from damperlab.studies.remarks import Remarks
from damperlab.studies.store.catalogue.base import StoreBase
from damperlab.studies.store.catalogue.home import remember
from damperlab.studies.store.catalogue.rows import record_of, study_row
from damperlab.studies.store.catalogue.tables import facts, studies
from damperlab.studies.store.faults import StudyNotFound, cannot_use
from damperlab.studies.store.life_cycle.manifest import keep_marks
from damperlab.studies.store.record import Record
from damperlab.studies.vocabulary import ENDED

_REMARKED = "remarked "
"""Begins the fact that names a study whose remarks are yet to be written beside its blocks."""


class Remarking(StoreBase):
    """How remarks are kept."""

    def remark(self, study_id: str, remarks: Remarks, *, at_once: bool = True) -> Record:
        """Keep what somebody says of a study: in the catalogue, and beside the blocks of one that has ended.

        Parameters
        ----------
        study_id : str
            Its whole id.
        remarks : Remarks
            What is said; what it leaves out stays as it is.
        at_once : bool
            Whether to wait until it stands beside the blocks too; where not, `keep_remarks` sees to it.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        StoreFault
            If it cannot be written.
        """
        said = {"tags": None if remarks.tags is None else json.dumps(remarks.tags), "note": remarks.note}
        change = {name: value for name, value in said.items() if value is not None}
        with self.catalogue.writing() as connection:
            number = study_row(connection, study_id).number
            connection.execute(update(studies).where(studies.c.number == number).values(change))
            row = study_row(connection, study_id)
            if row.state in ENDED:
                # from these a lost catalogue is made anew; of a study that goes on they are written as it ends
                remember(connection, f"{_REMARKED}{study_id}", uuid.uuid4().hex)
        if row.state in ENDED and at_once:
            self._keep_remark(study_id)
        return record_of(row)

    def keep_remarks(self, stop: Callable[[], bool] = lambda: False) -> None:
        """Write remarks beside the blocks of studies where that was put off, or cut short.

        Raises
        ------
        StoreFault
            If one cannot be written; it is put off again.
        """
        for key in self._remarked():
            if stop():
                return
            self._keep_remark(key.removeprefix(_REMARKED))

    def _remarked(self, key: str = _REMARKED) -> dict[str, str]:
        query = select(facts.c.key, facts.c.value).where(facts.c.key.startswith(key, autoescape=True))
        with self.catalogue.reading() as connection:
            return {row.key: row.value for row in connection.execute(query)}

    def _keep_remark(self, study_id: str) -> None:
        key = f"{_REMARKED}{study_id}"
        last = self._remarked(key).get(key)
        try:
            keep_marks(self, study_id, {})
        except (StudyNotFound, FileNotFoundError):
            pass  # deleted, or its cube is lost: there is nothing to write beside
        except OSError as error:
            raise cannot_use(self.shelf.address, error) from error
        with self.catalogue.writing() as connection:
            # a remark that came meanwhile is written in its turn
            connection.execute(delete(facts).where(facts.c.key == key, facts.c.value == last))
