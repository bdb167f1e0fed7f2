"""Lookup of studies by name or page by page, and access to the state and the events of a study."""

import math
import time
from typing import Any

from sqlalchemy import Connection, Row, func, select, update

from damperlab.studies.faults import Fault
from damperlab.studies.store.catalogue.base import StoreBase
from damperlab.studies.store.catalogue.quota import Ledger
from damperlab.studies.store.catalogue.rows import (
    ALIVE,
    FIRST_DIGITS,
    VALUES,
    alive_row,
    cursor_of,
    log_event,
    newest_row,
    number_before,
    record_of,
    study_row,
    too_few_digits,
    unknown_study,
)
from damperlab.studies.store.catalogue.rowsum import require_row
from damperlab.studies.store.catalogue.tables import events, studies
from damperlab.studies.store.faults import StoreFault, cannot_use
from damperlab.studies.store.life_cycle.manifest import keep_marks, put_off_marks
from damperlab.studies.store.life_cycle.wanted import ALL, Wanted
from damperlab.studies.store.record import PREPARATIONS, Page, Record, Totals
from damperlab.studies.vocabulary import ENDED, STATES

PAGE_LIMIT = 1000
"""Largest number of records on one page."""
MOST_LOOKED_AT = 5000
"""Largest number of studies whose axes are examined for one page."""


class Lookup(StoreBase):
    """The part of a store that finds studies, and sets their states."""

    def find(self, ref: str) -> Record:
        """Find a study by its complete id, by its name, or by the first digits of its id, in this order.

        If several studies have the name, or several versions of a study have the digits, the newest is returned.

        Raises
        ------
        StudyNotFound
            If no study fits, several studies fit the digits, or fewer than `FIRST_DIGITS` digits are given.
        """
        # replace lone surrogates and NUL, which databases refuse
        ref = _sayable(ref)
        with self.catalogue.reading() as connection:
            row = alive_row(connection, ref)
            if row is not None:
                return record_of(row)
            newest = select(studies).where(ALIVE).order_by(studies.c.number.desc())
            named = ref and connection.execute(newest.where(studies.c.name == ref).limit(1)).one_or_none()
            if named:
                return record_of(named)
            starts = func.substr(studies.c.id, 1, len(ref)) == ref.lower()
            fits = connection.execute(newest.where(starts).limit(4)).all() if ref else []
            if not fits:
                raise unknown_study(connection, ref)
            if len(ref) < FIRST_DIGITS or len({row.digest for row in fits}) > 1:
                raise too_few_digits(ref, fits)
            return record_of(max(fits, key=lambda row: row.version))  # the newest of several versions

    def existed(self, study_id: str) -> bool:
        """Whether a study with this complete id exists or was deleted."""
        with self.catalogue.reading() as connection:
            found = connection.execute(select(studies.c.number).where(studies.c.id == study_id).limit(1))
            return found.first() is not None

    def newest(self, digest: str) -> Record | None:
        """Return the newest version of the study with this digest; None if there is no such study."""
        with self.catalogue.reading() as connection:
            row = newest_row(connection, digest)
        return None if row is None else record_of(row)

    def versions(self, study_id: str) -> list[Record]:
        """Return every version of a study, oldest first.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        """
        with self.catalogue.reading() as connection:
            digest = study_row(connection, study_id).digest
            query = select(studies).where(studies.c.digest == digest, ALIVE).order_by(studies.c.version)
            return [record_of(row) for row in connection.execute(query)]

    def page(self, limit: int = 50, cursor: str | None = None, wanted: Wanted = ALL) -> Page:
        """Return one page of records, newest first.

        Parameters
        ----------
        limit : int
            Largest number of records on the page, 1 to `PAGE_LIMIT`.
        cursor : str, optional
            Cursor from the previous page; by default the first page is returned.
        wanted : Wanted
            Conditions on the studies. With a condition on an axis, a page may have fewer than `limit` records although
            more pages follow.

        Raises
        ------
        StoreFault
            If `limit` or `cursor` is invalid.
        """
        if not 1 <= limit <= PAGE_LIMIT:
            raise StoreFault(
                Fault("limit", str(limit), f"a number from 1 to {PAGE_LIMIT}", "ask page by page")
            )
        query = select(studies).where(*wanted.clauses()).order_by(studies.c.number.desc())
        before = math.inf if cursor is None else number_before(cursor)
        found: list[Row[Any]] = []
        looked_at, more = 0, True
        with self.catalogue.reading() as connection:
            while more and len(found) < limit and looked_at < MOST_LOOKED_AT:
                # read one row more than needed, to detect whether more rows follow
                size = VALUES if wanted.looks_inside else limit
                behind = query if before == math.inf else query.where(studies.c.number < before)
                rows = connection.execute(behind.limit(size + 1)).all()
                more = len(rows) > size
                for row in rows[:size]:
                    if len(found) == limit:
                        more = True
                        break
                    looked_at, before = looked_at + 1, row.number
                    if not wanted.looks_inside or wanted.fits(row):
                        found.append(row)
        return Page(tuple(map(record_of, found)), cursor_of(int(before)) if more else None)

    def totals(self) -> dict[str, Totals]:
        """Return the sums over the studies in each state. States without studies are left out."""
        c = studies.c
        sums = (
            c.points_total,
            c.points_done,
            c.points_failed,
            c.bytes_total,
            c.blocks_total - c.blocks_done,
        )
        query = select(c.state, func.count(), *(func.sum(one) for one in sums)).where(ALIVE).group_by(c.state)
        with self.catalogue.reading() as connection:
            return {row[0]: Totals(*map(int, row[1:])) for row in connection.execute(query)}

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
        later = state in ENDED and state != "done" and not at_once
        if state in ENDED and not later:
            with self.catalogue.reading() as connection:
                changes = _may_change(study_row(connection, study_id), only_from, owner)
            # if the state will not be changed, the marks in the cube must not be changed either
            if changes:
                self._keep_marks(study_id, state, message, now)
        with self.catalogue.writing() as connection:
            if later:
                put_off_marks(connection, study_id)
            return self._change_state(connection, study_id, state, message, only_from, owner, now)

    def _change_state(
        self,
        connection: Connection,
        study_id: str,
        state: str,
        message: str | None,
        only_from: tuple[str, ...],
        owner: str | None,
        now: float,
    ) -> Record:
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
        connection.execute(update(studies).where(studies.c.number == row.number).values(change))
        if row.state != state:
            log_event(connection, study_id, f"{row.state} to {state}" + (f": {message}" if message else ""))
        return record_of(study_row(connection, study_id))

    def _require_turn(self, connection: Connection, row: Row[Any]) -> None:
        """Raise `TooManyUnfinished` if an ended study would exceed the limit of waiting and running studies."""
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
        """Set the phase of a running study. Nothing changes if another owner has the claim.

        Parameters
        ----------
        study_id : str
            Complete id of the study.
        phase : str or None
            One of `PREPARATIONS`, or None when the computation of blocks begins.
        done, total : int, optional
            Number of completed items and of all items of the phase, if known.
        owner : str
            Owner of the claim on the study.
        message : str, optional
            Reason why the study waits. An empty text removes the present message; None keeps the message.
        """
        if phase not in (None, *PREPARATIONS):
            raise ValueError(f"{phase!r} is none of {PREPARATIONS}")
        change = _phase(phase, done, total)
        if phase is None:
            change["run_began"] = time.time()
        if message is not None:
            change["message"] = _sayable(message) or None
        ours = (studies.c.id == study_id, ALIVE, studies.c.claim_owner == owner, studies.c.state == "running")
        with self.catalogue.writing() as connection:
            connection.execute(update(studies).where(*ours).values(change))

    def note(self, study_id: str, what: str) -> None:
        """Add an event to a study's log."""
        with self.catalogue.writing() as connection:
            log_event(connection, study_id, _sayable(what))

    def _keep_marks(self, study_id: str, state: str, message: str | None, now: float) -> None:
        changes = {"state": state, "finished": now} | (
            {} if message is None else {"message": message or None}
        )
        try:
            keep_marks(self, study_id, changes)
        except OSError as error:
            if state == "done":
                raise cannot_use(self.shelf.address, error) from error
            # a cancelled or failed study may end without a list of marks, because the disk may be full

    def events(self, study_id: str) -> list[tuple[float, str]]:
        """Return the events of a study, oldest first. Each event is a time in seconds since 1970 and a text."""
        query = select(events).where(events.c.study == study_id).order_by(events.c.number)
        with self.catalogue.reading() as connection:
            rows = connection.execute(query).all()
        for row in rows:
            require_row(events, row, study_id)
        return [(row.at, row.what) for row in rows]


def _may_change(row: Row[Any], only_from: tuple[str, ...], owner: str | None) -> bool:
    return row.state in only_from and owner in (None, row.claim_owner)


def _phase(phase: str | None, done: int | None = None, total: int | None = None) -> dict[str, Any]:
    return {"phase": phase, "phase_done": done, "phase_total": total}


def _sayable(text: str) -> str:
    return text.encode(errors="replace").decode().replace("\0", "?")
