"""States, phases and remarks of studies.

The state, the done-marks and the remarks of an ended study are also stored in its cube.
"""

import json
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

from sqlalchemy import Connection, Row, delete, select, update

from damperlab.studies.digest import family_digest
from damperlab.studies.remarks import Remarks
from damperlab.studies.store.catalogue.quota import Ledger
from damperlab.studies.store.catalogue.rows import (
    ALIVE,
    change_studies,
    log_event,
    log_events,
    record_of,
    study_row,
)
from damperlab.studies.store.catalogue.tables import facts, studies
from damperlab.studies.store.cube.definition import parse_stored
from damperlab.studies.store.cube.description import first_pieces
from damperlab.studies.store.faults import StoreFault, StudyNotFound, cannot_use, using
from damperlab.studies.store.life_cycle.lookup import Lookup, storable
from damperlab.studies.store.life_cycle.manifest import (
    MARKS,
    PUT_OFF,
    keep_marks,
    marks_put_off,
    put_off_marks,
)
from damperlab.studies.store.record import PREPARATIONS, Record
from damperlab.studies.vocabulary import ENDED, STATES


class States(Lookup):
    """The part of a store that changes the states, phases, events and remarks of studies."""

    def set_state(
        self,
        study_id: str,
        state: str,
        message: str | None = None,
        *,
        only_from: tuple[str, ...] = STATES,
        owner: str | None = None,
        at_once: bool = True,
    ) -> Record:
        """Change the state of a study, and return the study's record.

        Parameters
        ----------
        study_id : str
            Complete id of the study.
        state : str
            One of `STATES`.
        message : str, optional
            Message to store with the study. None keeps the present message; an empty text removes the message.
        only_from : tuple of str
            States in which the study may be changed. In any other state, nothing changes.
        owner : str, optional
            Owner of the claim on the study. If another owner has the claim, nothing changes.
        at_once : bool
            Whether to write the done-marks of a cancelled or failed study into the cube before this method returns. If
            not, `keep_late_marks` writes the marks later.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        TooManyUnfinished
            If an ended study is to be queued again and the limit of waiting and running studies is reached.
        """
        if state not in STATES:
            raise ValueError(f"{state!r} is none of {STATES}")
        now = time.time()
        if state == "done":
            with self.catalogue.reading() as connection:
                changes = _may_change(study_row(connection, study_id), only_from, owner)
            # if the state will not be changed, the marks in the cube must not be changed either
            if changes:
                self._keep_marks_of_done(study_id, message, now)
        late = state in ENDED and state != "done"
        with self.catalogue.writing() as connection:
            if late:
                put_off_marks(connection, study_id)
            record = self._change_state(
                connection, study_id, state, message, only_from=only_from, owner=owner, now=now
            )
        if late and at_once:
            # a cancelled or failed study may end without a list of marks, because the disk may be full
            with suppress(StoreFault):
                self.settle_marks(study_id)
        return record

    def _change_state(
        self,
        connection: Connection,
        study_id: str,
        state: str,
        message: str | None = None,
        *,
        only_from: tuple[str, ...],
        owner: str | None,
        now: float | None = None,
    ) -> Record:
        now = time.time() if now is None else now
        row = study_row(connection, study_id)
        if not _may_change(row, only_from, owner):
            return record_of(row)
        if state == "queued":
            self._require_turn(connection, row)
        change: dict[str, Any] = {"state": state} | _phase(None)
        if message is not None:
            change["message"] = message or None
        if state == "running":
            change |= {"started": row.started or now, "finished": None}
            change |= {"run_began": now, "run_points": row.points_done, "last_mark": None}
        elif state == "queued":
            change["finished"] = None
        elif row.state != state:
            change["finished"] = now
        change_studies(connection, [row.number], change)
        if row.state != state:
            log_event(connection, study_id, f"{row.state} to {state}" + (f": {message}" if message else ""))
        return record_of(study_row(connection, study_id))

    def _change_states(
        self, connection: Connection, rows: Sequence[Row[Any]], state: str, change: Mapping[str, Any]
    ) -> None:
        """Set the state and other columns of several studies, and log the change of each state."""
        change_studies(connection, [row.number for row in rows], {"state": state, **_phase(None), **change})
        log_events(connection, {row.id: f"{row.state} to {state}" for row in rows})

    def _require_turn(self, connection: Connection, row: Row[Any]) -> None:
        """Raise `TooManyUnfinished` if the study has ended, and queuing it again would exceed the limit of waiting and
        running studies.
        """
        if row.state in ENDED:
            Ledger(connection, self.quota).enter(row.submitted_by, 0, 0, 1)

    def set_phase(
        self,
        study_id: str,
        phase: str | None,
        done: int | None = None,
        total: int | None = None,
        *,
        owner: str,
        message: str | None = None,
    ) -> None:
        """Set the phase of a running study: one of `PREPARATIONS`, or None when the computation of blocks begins.

        Nothing changes if another owner has the claim. `done` and `total` count the items of the phase, if known. The
        message says why the study waits. An empty text removes the present message; None keeps it.
        """
        if phase not in (None, *PREPARATIONS):
            raise ValueError(f"{phase!r} is none of {PREPARATIONS}")
        change = _phase(phase, done, total)
        if phase is None:
            change["run_began"] = time.time()
        if message is not None:
            change["message"] = storable(message) or None
        ours = (studies.c.id == study_id, ALIVE, studies.c.claim_owner == owner, studies.c.state == "running")
        with self.catalogue.writing() as connection:
            connection.execute(update(studies).where(*ours).values(change))

    def begin(self, study_id: str, facts: Mapping[str, str], owner: str | None = None) -> Record:
        """Record the solver of a study before the first block is computed, and return the record of the study.

        `facts` is the provenance from the workers. If no block is done, the workers' solver replaces the solver
        that was recorded at submission. If blocks are done, the recorded solver is kept, and the caller must
        compare the provenance of the record with `facts`. Nothing changes if the `identity` in `facts` is
        already recorded, or if another owner has the claim.

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
                change_studies(connection, [row.number], change)
                log_event(connection, study_id, f"to be computed by solver {facts['identity']}")
                now = study_row(connection, study_id)
        if not begins:
            # another runner has taken over the study, so write the cube again with the catalogue's provenance
            self._describe(now, record_of(now).provenance)
        return record_of(now)

    def _describe(self, row: Row[Any], provenance: Mapping[str, str]) -> None:
        """Write the description and the coordinates of a study's cube; raise `StoreFault` if they cannot be written."""
        record = record_of(row)
        study = parse_stored(record.definition, record.digest)
        shelf = self.cube_shelf(row.id, row.number)
        with using(shelf.address):
            shelf.fill(first_pieces(study, record.chunk, provenance, reuse=record.reuse, created=row.created))

    def note(self, study_id: str, what: str) -> None:
        """Add an event to a study's log."""
        with self.catalogue.writing() as connection:
            log_event(connection, study_id, storable(what))

    def _keep_marks_of_done(self, study_id: str, message: str | None, now: float) -> None:
        """Write the done-marks of a study before its state becomes `done`; raise `StoreFault` if this fails."""
        told = {} if message is None else {"message": message or None}
        with using(self.shelf.address):
            keep_marks(self, study_id, {"state": "done", "finished": now} | told)

    def remark(self, study_id: str, remarks: Remarks, *, at_once: bool = True) -> Record:
        """Store a user's remarks about a study in the catalogue, and for an ended study also in the cube.

        A remark that is None is not changed. If `at_once` is false, `keep_late_marks` writes the remarks into the cube
        later.

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
            change_studies(connection, [number], change)
            row = study_row(connection, study_id)
            if row.state in ENDED:
                # the list of marks in the cube also stores the remarks, so the list must be written again
                put_off_marks(connection, study_id)
        if row.state in ENDED and at_once:
            self.settle_marks(study_id)
        return record_of(row)

    def keep_late_marks(self, stop: Callable[[], bool] = lambda: False) -> None:
        """Write the postponed done-marks of ended studies into their cubes.

        The function `stop` is called before each study; if it returns true, the remaining studies are left for later.

        Raises
        ------
        StoreFault
            If the marks of a study cannot be written. The marks of all other studies are still written.
        """
        failed: StoreFault | None = None
        query = select(facts.c.key).where(facts.c.key.startswith(PUT_OFF, autoescape=True))
        with self.catalogue.reading() as connection:
            keys = connection.execute(query).scalars().all()
        for key in keys:
            if stop():
                return
            try:
                self.settle_marks(key.removeprefix(PUT_OFF))
            except StoreFault as error:  # continue with the other studies
                failed = failed or error
        if failed is not None:
            raise failed

    def settle_marks(self, study_id: str) -> None:
        """Make the list of done-marks in a cube agree with the catalogue, and delete the note of `put_off_marks`.

        The list is written if the study has ended, and removed otherwise. Both are repeated if the study changes
        meanwhile.
        """
        with self.catalogue.reading() as connection:
            note = marks_put_off(connection, study_id)
        settled: object = ()
        try:
            while (end := self._end_of(study_id)) != settled:
                settled = end
                if end is not None:
                    keep_marks(self, study_id, {})
                else:
                    self.find_cube(study_id).remove(MARKS)
        except (StudyNotFound, FileNotFoundError):
            pass  # the study was deleted or its cube is lost, so there is no place to write to
        except OSError as error:
            raise cannot_use(self.shelf.address, error) from error
        with self.catalogue.writing() as connection:
            # delete only this note: marks that were postponed meanwhile have another note
            key = f"{PUT_OFF}{study_id}"
            connection.execute(delete(facts).where(facts.c.key == key, facts.c.value == note))

    def _end_of(self, study_id: str) -> tuple[Any, ...] | None:
        """Return the state, the revision and the end time of a study; None if the study has not ended."""
        with self.catalogue.reading() as connection:
            row = study_row(connection, study_id)
        return (row.state, row.revision, row.finished) if row.state in ENDED else None


def _may_begin(row: Row[Any], facts: Mapping[str, str], owner: str | None) -> bool:
    """Whether `owner` may replace the recorded solver. The solver in `facts` must be another one, no block may be done,
    and no other owner may have the claim.
    """
    known = json.loads(row.provenance).get("identity") == facts["identity"]
    return not known and not row.blocks_done and owner in (None, row.claim_owner)


def _may_change(row: Row[Any], only_from: tuple[str, ...], owner: str | None) -> bool:
    return row.state in only_from and owner in (None, row.claim_owner)


def _phase(phase: str | None, done: int | None = None, total: int | None = None) -> dict[str, Any]:
    return {"phase": phase, "phase_done": done, "phase_total": total}
