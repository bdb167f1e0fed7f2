"""Claims on studies. Only the owner of a claim works on the study, and a claim ends if the owner does not renew it.

Small studies are processed together: one transaction claims, marks or ends many studies.
"""

import json
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, Row, select, update

from damperlab.studies.store.catalogue.rows import (
    ALIVE,
    alive_row,
    alive_rows,
    change_studies,
    claim_owner,
    record_of,
)
from damperlab.studies.store.catalogue.tables import WAITING, studies
from damperlab.studies.store.faults import StoreFault, StudyNotFound
from damperlab.studies.store.files.shelf import AT_ONCE
from damperlab.studies.store.life_cycle.blocks import Blocks
from damperlab.studies.store.record import BlockOutcome, Record

CLAIM_SECONDS = 60.0
"""Time after which a claim ends if it is not renewed [s]."""

FEW_POINTS = 16
"""Largest number of points of a study that is run together with other studies."""

UNCLAIMED: Mapping[str, Any] = {"claim_owner": None, "claim_expires": None}
"""Values of the claim columns in the row of an unclaimed study."""


def claimed(owner: str) -> dict[str, Any]:
    """Return the columns of a claim that begins or is renewed now, and ends after `CLAIM_SECONDS`."""
    return {"claim_owner": owner, "claim_expires": time.time() + CLAIM_SECONDS}


@dataclass(frozen=True)
class Waiting:
    """A study that has not ended and has no owner.

    Parameters
    ----------
    id : str
        Complete id of the study.
    small : bool
        Whether the study has only one block, at most `FEW_POINTS` points, and was never started.
    owner : str, optional
        Owner of the access key with which the study was submitted; None if no key was used.
    priority : int
        Priority of the study; see `Record`.
    """

    id: str
    small: bool
    owner: str | None
    priority: int


class Claims(Blocks):
    """The claims on the studies of a store.

    A claim ends when the wall clock has passed the claim's expiry time, or when this process has seen no renewal for
    `CLAIM_SECONDS`. The second rule ends the claim of a dead owner even if the wall clock is set back. If another owner
    then claims the study, `mark` refuses the results of the first owner.
    """

    def claim(self, study_id: str, owner: str) -> bool:
        """Claim a study. Return False if another owner has a valid claim, or the study does not exist.

        If the claim is not renewed, it ends after `CLAIM_SECONDS`.
        """
        with self.catalogue.writing() as connection:
            row = alive_row(connection, study_id)
            if row is None or (row.claim_owner != owner and self._holds(row)):
                return False
            change_studies(connection, [row.number], claimed(owner))
            return True

    def renew(self, study_id: str, owner: str) -> bool:
        """Renew a claim. Return False if this owner no longer has the claim; the owner must then stop working."""
        return self._if_owned(study_id, owner, claimed(owner))

    def release(self, study_id: str, owner: str) -> None:
        """Release a claim. Nothing happens if this owner does not have the claim."""
        self._if_owned(study_id, owner, UNCLAIMED)

    def abandoned(self, study_id: str) -> bool:
        """Whether no process works on a study. Repeated calls also detect an owner that stopped renewing."""
        with self.catalogue.reading() as connection:
            row = alive_row(connection, study_id)
        return row is not None and not self._holds(row)

    def unclaimed(self, dead: Callable[[str], bool], most: int | None = None) -> list[Waiting]:
        """Return the queued and running studies without an owner, by descending priority, then by submission time.

        The function `dead` returns whether an owner is known to be dead, although its claim has not ended. At most
        `most` studies of each submitter are returned, by default all.
        """
        c = studies.c
        # read only a few columns, because ten thousand studies may wait
        query = select(
            c.id,
            c.number,
            c.claim_owner,
            c.claim_expires,
            c.blocks_total,
            c.points_total,
            c.started,
            c.submitted_by,
            c.priority,
        )
        query = query.where(WAITING).order_by(c.priority.desc(), c.created, c.number)
        found: list[Waiting] = []
        counts: Counter[str | None] = Counter()
        with self.catalogue.reading() as connection:
            rows: Iterable[Any] = connection.execute(query)
            for row in rows:
                if most is not None and counts[row.submitted_by] >= most:
                    continue
                if not self._holds(row) or (row.claim_owner and dead(str(row.claim_owner))):
                    one = row.blocks_total == 1 and row.started is None
                    small = one and row.points_total <= FEW_POINTS
                    found.append(Waiting(row.id, small, row.submitted_by, row.priority))
                    counts[row.submitted_by] += 1
        return found

    def _holds(self, row: Row[Any]) -> bool:
        if row.claim_owner is None:
            self._renewals.pop(row.number, None)
            return False
        now, renewal = time.monotonic(), (row.claim_owner, row.claim_expires)
        seen, since = self._renewals.get(row.number, (None, now))
        if seen != renewal:
            since = now
            self._renewals[row.number] = renewal, now
        return claim_owner(row) is not None and now - since <= CLAIM_SECONDS

    def _if_owned(self, study_id: str, owner: str, change: Mapping[str, Any]) -> bool:
        with self.catalogue.writing() as connection:
            row = alive_row(connection, study_id)
            if row is None or row.claim_owner != owner:
                return False
            change_studies(connection, [row.number], change)
            return True

    def claim_all(self, ids: Sequence[str], owner: str, identity: str) -> list[Record]:
        """Claim and start the queued studies that were never started and have no owner.

        `identity` identifies the owner's solver and processor; see `damperlab.studies.store.solver.identity_of`. A
        study with another recorded identity is skipped.
        """
        with self.catalogue.writing() as connection:
            taken = [
                row
                for row in alive_rows(connection, ids)
                if row.state == "queued"
                and row.started is None
                and not self._holds(row)
                and json.loads(row.provenance).get("identity") == identity
            ]
            now = time.time()
            began = {"started": now, "finished": None, "run_began": now, "run_points": studies.c.points_done}
            change = {**claimed(owner), **began, "last_mark": None}
            self._change_states(connection, taken, "running", change)
            return [record_of(row) for row in alive_rows(connection, [row.id for row in taken])]

    def renew_all(self, owner: str) -> None:
        """Renew every claim of an owner."""
        change = update(studies).where(studies.c.claim_owner == owner, ALIVE)
        with self.catalogue.writing() as connection:
            connection.execute(change.values(claimed(owner)))

    def finish_all(self, owner: str, outcomes: Mapping[str, Sequence[BlockOutcome]]) -> set[str]:
        """Set the done-marks of all blocks of each study, and end each study whose cube contains the marks.

        The method returns the ids of the ended studies.
        """
        with self.catalogue.writing() as connection:
            marked = [
                each for each, ends in outcomes.items() if self._mark_all(connection, each, ends, owner)
            ]
        now = time.time()
        with ThreadPoolExecutor(AT_ONCE) as pool:
            kept = list(pool.map(lambda study_id: self._kept(study_id, now), marked))
        good = [study_id for study_id, kept_now in zip(marked, kept, strict=True) if kept_now]
        with self.catalogue.writing() as connection:
            ours = [
                row
                for row in alive_rows(connection, good)
                if row.claim_owner == owner and row.state == "running"
            ]
            self._change_states(connection, ours, "done", {**UNCLAIMED, "finished": now})
        return {row.id for row in ours}

    def release_all(self, owner: str) -> None:
        """Queue the running studies of an owner again, and release all claims of the owner."""
        c = studies.c
        with self.catalogue.writing() as connection:
            rows = connection.execute(select(c.id, c.number).where(c.claim_owner == owner, ALIVE)).all()
            for row in rows:
                self._change_state(connection, row.id, "queued", only_from=("running",), owner=owner)
                change_studies(connection, [row.number], UNCLAIMED)

    def _mark_all(
        self, connection: Connection, study_id: str, outcomes: Sequence[BlockOutcome], owner: str
    ) -> bool:
        try:
            return self._mark(connection, study_id, outcomes, owner)
        except StudyNotFound:
            return False  # the study was deleted meanwhile

    def _kept(self, study_id: str, now: float) -> bool:
        try:
            self._keep_marks_of_done(study_id, None, now)
        except StoreFault:
            return False  # study deleted, or disk full: the next run ends a study that still exists
        return True
