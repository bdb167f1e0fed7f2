"""Claims: only one owner works on a study, and a claim that is not renewed ends."""

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, Row, select, tuple_, update

from damperlab.studies.faults import Fault
from damperlab.studies.store.catalogue.base import StoreBase
from damperlab.studies.store.catalogue.rows import VALUES, alive_row, claim_owner
from damperlab.studies.store.catalogue.tables import WAITING, studies
from damperlab.studies.store.faults import StudyBusy

CLAIM_SECONDS = 60.0
"""Duration of a claim without renewal [s]."""


FEW_POINTS = 16
"""Largest number of points of a study that is run together with others."""


@dataclass(frozen=True)
class Waiting:
    """A study that waits to be run and has no owner.

    Parameters
    ----------
    id : str
        Its whole id.
    small : bool
        Whether it has one block of a few points and was never started.
    owner : str, optional
        Its submitter; None without keys.
    priority : int
        See `Record`.
    """

    id: str
    small: bool
    owner: str | None
    priority: int


class Claims(StoreBase):
    """The claims on the studies of a store.

    A claim ends when its time is over by the wall clock. It also ends if the observer sees no renewal for that long by
    its monotonic clock, so setting a wall clock back does not keep a dead owner's claim. A clock set forward may end the
    claim of a living owner, whose later writes are then refused (`Blocks.mark`).
    """

    def claim(self, study_id: str, owner: str, seconds: float | None = None) -> bool:
        """Claim a study; False while another owner's claim is valid.

        Parameters
        ----------
        study_id, owner : str
            The study, and a name that no other runner has.
        seconds : float, optional
            Duration without renewal [s]; by default `CLAIM_SECONDS`.
        """
        with self.catalogue.writing() as connection:
            row = alive_row(connection, study_id)
            if row is None or (row.claim_owner != owner and self._holds(row)):
                return False
            self._set_claim(connection, row.number, owner, _end(seconds))
            return True

    def renew(self, study_id: str, owner: str, seconds: float | None = None) -> bool:
        """Renew a claim; False if another owner has it: the work must then stop."""
        return self._if_owned(study_id, owner, owner, _end(seconds))

    def release(self, study_id: str, owner: str) -> None:
        """Release a claim; nothing happens if another owner has it."""
        self._if_owned(study_id, owner, None, None)

    def abandoned(self, study_id: str) -> bool:
        """Whether no process works on a study; call it repeatedly to see whether its claim is renewed."""
        with self.catalogue.reading() as connection:
            row = alive_row(connection, study_id)
        return row is not None and not self._holds(row)

    def unclaimed(self, dead: Callable[[str], bool], most: int | None = None) -> list[Waiting]:
        """Give the queued and running studies without an owner: the highest priority first, and within a priority the
        oldest first.

        Parameters
        ----------
        dead : callable
            Whether an owner can be recognised as dead before its claim ends.
        most : int, optional
            Largest number of studies of each submitter to look for.
        """
        c = studies.c
        # only a few columns are read, page by page, because ten thousand studies may wait and each new one triggers a
        # check
        query = select(
            c.id,
            c.number,
            c.created,
            c.claim_owner,
            c.claim_expires,
            c.blocks_total,
            c.points_total,
            c.started,
            c.submitted_by,
            c.priority,
        )
        query = query.where(WAITING).order_by(c.priority.desc(), c.created, c.number).limit(VALUES)
        found: list[Waiting] = []
        counts: Counter[str | None] = Counter()
        with self.catalogue.reading() as connection:
            page: Sequence[Any] = connection.execute(query).all()
            while page:
                for row in page:
                    owner = row.submitted_by
                    if most is not None and counts[owner] >= most:
                        continue
                    if not self._holds(row) or (row.claim_owner and dead(str(row.claim_owner))):
                        small = (row.blocks_total, row.started) == (
                            1,
                            None,
                        ) and row.points_total <= FEW_POINTS
                        found.append(Waiting(row.id, small, owner, row.priority))
                        counts[owner] += 1
                if len(page) < VALUES:
                    break
                last = page[-1]
                behind = tuple_(-c.priority, c.created, c.number)
                page = connection.execute(
                    query.where(behind > tuple_(-last.priority, last.created, last.number))
                ).all()
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

    def _if_owned(self, study_id: str, owner: str, heir: str | None, expires: float | None) -> bool:
        with self.catalogue.writing() as connection:
            row = alive_row(connection, study_id)
            if row is None or row.claim_owner != owner:
                return False
            self._set_claim(connection, row.number, heir, expires)
            return True

    def _set_claim(
        self, connection: Connection, number: int, owner: str | None, expires: float | None
    ) -> None:
        change = update(studies).where(studies.c.number == number)
        connection.execute(change.values(claim_owner=owner, claim_expires=expires))


def _end(seconds: float | None) -> float:
    return time.time() + (CLAIM_SECONDS if seconds is None else seconds)


def require_free(row: Row[Any], what: str) -> None:
    """Refuse the action `what` on a study with an owner; raise `StudyBusy`."""
    owner = claim_owner(row)
    if owner is not None:
        raise StudyBusy(
            Fault(
                "study",
                f"{row.id} is {row.state}, worked on by {owner}",
                f"a study that no process works on, to {what} it",
                f"cancel it first, with `damperlab cancel {row.id}` or, over HTTP, by POST to its `/cancel`",
                f"Study {row.id} is {row.state} and worked on by {owner}, so it is not possible to {what} it now.",
            )
        )
