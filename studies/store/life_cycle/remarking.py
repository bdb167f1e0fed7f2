"""Tags and notes in the catalogue; they are no part of what a study asks, and change no result."""

import json

from sqlalchemy import update

from damperlab.studies.remarks import Remarks
from damperlab.studies.store.catalogue.base import StoreBase
from damperlab.studies.store.catalogue.rows import record_of, study_row
from damperlab.studies.store.catalogue.tables import studies
from damperlab.studies.store.faults import cannot_use
from damperlab.studies.store.life_cycle.manifest import keep_marks
from damperlab.studies.store.record import Record
from damperlab.studies.vocabulary import ENDED


class Remarking(StoreBase):
    """How remarks are kept."""

    def remark(self, study_id: str, remarks: Remarks) -> Record:
        """Keep what somebody says of a study.

        Parameters
        ----------
        study_id : str
            Its whole id.
        remarks : Remarks
            What is said; what it leaves out stays as it is.

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
            try:
                # from these a lost catalogue is made anew; of a study that goes on they are written as it ends
                keep_marks(self, study_id, {})
            except OSError as error:
                raise cannot_use(self.shelf.address, error) from error
        return record_of(row)
