"""Claims on studies. Only the owner of a claim works on the study, and a claim ends if the owner does not renew it."""

import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Row, select

from damperlab.studies.store.catalogue.rows import alive_row, change_study, claim_owner
from damperlab.studies.store.catalogue.tables import WAITING, studies
from damperlab.studies.store.cubes import Cubes
from damperlab.studies.store.faults import StudyBusy

CLAIM_SECONDS = 60.0
"""Time after which a claim ends if it is not renewed [s]."""


FEW_POINTS = 16
"""Largest number of points of a study that is run together with other studies."""


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


class Claims(Cubes):
    """The claims on the studies of a store.

    A claim ends when its time is over by the wall clock, or when this process has seen no renewal for `CLAIM_SECONDS`.
    So the claim of a dead owner ends even if the wall clock is set back. If another owner then claims the study,
    `Blocks.mark` refuses the results of the first owner.
    """

    def claim(self, study_id: str, owner: str, seconds: float | None = None) -> bool:
        """Claim a study. Return False if another owner has a valid claim, or the study does not exist.

        If the claim is not renewed, it ends after `seconds`, by default `CLAIM_SECONDS`.
        """
        with self.catalogue.writing() as connection:
            row = alive_row(connection, study_id)
            if row is None or (row.claim_owner != owner and self._holds(row)):
                return False
            change_study(connection, row.number, claimed(owner, seconds))
            return True

    def renew(self, study_id: str, owner: str, seconds: float | None = None) -> bool:
        """Renew a claim. Return False if this owner no longer has the claim; the owner must then stop working."""
        return self._if_owned(study_id, owner, claimed(owner, seconds))

    def release(self, study_id: str, owner: str) -> None:
        """Release a claim. Nothing happens if this owner does not have the claim."""
        self._if_owned(study_id, owner, UNCLAIMED)

    def abandoned(self, study_id: str) -> bool:
        """Whether no process works on a study. Repeated calls also detect that a claim is not renewed."""
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
            change_study(connection, row.number, change)
            return True


UNCLAIMED: Mapping[str, Any] = {"claim_owner": None, "claim_expires": None}
"""Values of the claim columns in the row of an unclaimed study."""


def claimed(owner: str, seconds: float | None = None) -> dict[str, Any]:
    """Return the columns of a claim that begins or is renewed now, and ends after `seconds` or `CLAIM_SECONDS`."""
    return {
        "claim_owner": owner,
        "claim_expires": time.time() + (CLAIM_SECONDS if seconds is None else seconds),
    }


def require_free(row: Row[Any], what: str) -> None:
    """Raise `StudyBusy` if the study has an owner; `what` is the refused action, for the message."""
    owner = claim_owner(row)
    if owner is not None:
        raise StudyBusy(
            "study",
            f"{row.id} is {row.state}, worked on by {owner}",
            f"a study that no process works on, to {what} it",
            f"cancel it first, with `damperlab cancel {row.id}` or, over HTTP, by POST to its `/cancel`",
            f"Study {row.id} is {row.state} and worked on by {owner}, so it is not possible to {what} it now.",
        )
