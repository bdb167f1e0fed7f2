"""Finding studies: a study by its name, all studies page by page, and the state and events of a study."""

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
    """The catalogue's information about studies."""

    def find(self, ref: str) -> Record:
        """Find a study by its id, its name (the newest of that name), or the first digits of its id, in this order.

        Among several versions, or if the first was deleted, the first digits find the newest.

        Raises
        ------
        StudyNotFound
            If none is found, or fewer than `FIRST_DIGITS` digits are given, or they fit several.
        """
        # a command line or an address may contain half characters, which no database accepts, or NUL, which PostgreSQL
        # refuses
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
        """Whether a study of this complete id exists, or existed before it was deleted."""
        with self.catalogue.reading() as connection:
            found = connection.execute(select(studies.c.number).where(studies.c.id == study_id).limit(1))
            return found.first() is not None

    def newest(self, digest: str) -> Record | None:
        """Give the newest version of a definition; None if it was never submitted, or was deleted."""
        with self.catalogue.reading() as connection:
            row = newest_row(connection, digest)
        return None if row is None else record_of(row)

    def versions(self, study_id: str) -> list[Record]:
        """Give every version of a study, oldest first.

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
        """Give one page of records, newest first.

        Parameters
        ----------
        limit : int
            Largest number of records on the page, 1 to `PAGE_LIMIT`.
        cursor : str, optional
            The cursor of the page before. Studies submitted meanwhile do not shift the pages.
        wanted : Wanted
            Filter of the studies. With a range of an axis, a page may be short although others follow: at most
            `MOST_LOOKED_AT` studies are examined for one.

        Raises
        ------
        StoreFault
            If an argument is not allowed.
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
                # one row more than is shown, to detect further ones
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
        """Sum up the studies of each state; a state without studies is left out."""
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
        """Put a study into a state.

        Parameters
        ----------
        study_id : str
            The whole id.
        state : str
            One of `STATES`.
        message : str, optional
            Stored with the study; None keeps the present one, an empty one removes it.
        only_from : tuple of str
            The change happens only in one of these states; the returned record has the resulting state.
        owner : str, optional
            Owner of the claim; nothing changes if another owner has it.
        at_once : bool
            Whether to write the marks of an ending study before this returns. If not, `keep_late_marks` writes them.
            The marks of a study that is done are always written before.

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
            # if the study ended otherwise or has another runner, the cube's marks stay unchanged
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
        """Refuse to queue an ended study if the limit of waiting and running studies is reached; raise
        `TooManyUnfinished`.
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
        """Set the phase of a running study before it computes blocks; nothing changes if another owner has the claim.

        Parameters
        ----------
        study_id : str
            The whole id.
        phase : str or None
            One of `PREPARATIONS`; None once its blocks are being computed; the pace is measured from then on.
        done, total : int, optional
            Progress of the phase, if it can be counted.
        owner : str
            Owner that works on the study.
        message : str, optional
            Reason for waiting, or the missing resource; empty for none; by default unchanged.
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
            # the present marks are sufficient, so ending a study that can be resumed needs no space on a full disk

    def events(self, study_id: str) -> list[tuple[float, str]]:
        """Give the events of a study, oldest first: seconds since 1970, and text."""
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
