"""Quota of the studies in a store, checked at submission. Sizes are those of complete studies before compression."""

from dataclasses import dataclass
from typing import Optional

from sqlalchemy import Connection, func, select

from damperlab.studies.faults import Fault
from damperlab.studies.store.catalogue.tables import WAITING, studies
from damperlab.studies.store.faults import QuotaReached, TooManyUnfinished

_ADVICE = "delete studies that are not needed (`damperlab delete`), ask for fewer points or metrics, or raise the quota"


@dataclass(frozen=True)
class Taken:
    """Usage of the studies in a store, including deleted ones whose files still exist.

    Parameters
    ----------
    points, bytes : int
        Totals when every study is complete, before compression.
    unfinished : int
        Waiting and running studies; 0 if not counted.
    """

    points: int
    bytes: int
    unfinished: int = 0

    def plus(self, points: int, size: int, count: int = 1) -> "Taken":
        """Give the usage with additional points, bytes and studies."""
        return Taken(self.points + points, self.bytes + size, self.unfinished + count)


@dataclass(frozen=True)
class Quota:
    """Limits of all studies together; None for no limit.

    Parameters
    ----------
    points, bytes : int, optional
        Bytes are counted before compression, so they are known before any point is computed.
    unfinished : int, optional
        Waiting and running studies.
    of_owner : Quota, optional
        Limits of the studies of each owner of keys.
    setting : str
        Prefix of the settings for quotas.
    """

    points: int | None = None
    bytes: int | None = None
    unfinished: int | None = None
    of_owner: Optional["Quota"] = None
    setting: str = "quota"

    @property
    def limited(self) -> bool:
        """Whether there is a limit to all studies together."""
        return not self.points is self.bytes is self.unfinished is None

    def require(self, before: Taken, after: Taken) -> None:
        """Refuse studies that exceed the remaining quota.

        Parameters
        ----------
        before, after : Taken
            Usage without them and with them.

        Raises
        ------
        QuotaReached
            With their usage and the remaining quota; `TooManyUnfinished` if waiting frees some quota.
        """
        for unit, limit, used, wanted in (
            ("points", self.points, before.points, after.points - before.points),
            ("bytes", self.bytes, before.bytes, after.bytes - before.bytes),
        ):
            if limit is not None and wanted and used + wanted > limit:
                raise QuotaReached(
                    Fault(
                        f"{self.setting}_{unit}",
                        f"a study of {wanted:,} {unit}",
                        f"{max(0, limit - used):,} {unit}: the quota is {limit:,}, of which other "
                        f"studies use {used:,}",
                        _ADVICE,
                        f"{{field}} does not suffice: the study would take {wanted:,} {unit}, and {max(0, limit - used):,} "
                        f"{unit} of {limit:,} are left.",
                    )
                )
        if self.unfinished is not None and self.unfinished < after.unfinished > before.unfinished:
            found = f"{after.unfinished:,} studies that wait or run"
            allowed = f"at most {self.unfinished:,} at a time"
            advice = "wait until some have ended, or cancel some"
            told = f"{{field}} allows {allowed}, and there would be {found}."
            raise TooManyUnfinished(Fault(f"{self.setting}_unfinished", found, allowed, advice, told))


class Ledger:
    """Usage while studies are entered in one transaction: in total, and by each owner.

    Parameters
    ----------
    connection : Connection
        Connection of the transaction, before any study is entered.
    quota : Quota
        The limits.
    """

    def __init__(self, connection: Connection, quota: Quota) -> None:
        self._connection = connection
        self._quota = quota
        self._sums: dict[str | None, Taken] = {}

    def enter(self, owner: str | None, points: int, size: int, count: int) -> None:
        """Count studies of one owner before they are entered. If they exceed a quota, none is counted.

        Raises
        ------
        QuotaReached
            As `Quota.require`.
        """
        each = self._quota.of_owner if owner is not None else None
        after: dict[str | None, Taken] = {}
        for whose, quota in ((None, self._quota), (owner, each)):
            if quota is not None and quota.limited:
                before = self._sums.get(whose) or taken(
                    self._connection, whose, unfinished=quota.unfinished is not None
                )
                after[whose] = before.plus(points, size, count)
                quota.require(before, after[whose])
        self._sums |= after


def taken(connection: Connection, owner: str | None = None, *, unfinished: bool = False) -> Taken:
    """Add up the usage of all studies, or of one owner."""
    c = studies.c
    sums = select(func.coalesce(func.sum(c.points_total), 0), func.coalesce(func.sum(c.bytes_total), 0))
    # a study whose files have been removed leaves an empty row
    sums = sums.where(c.definition != "")
    count = select(func.count()).select_from(studies).where(WAITING)
    if owner is not None:
        sums, count = sums.where(c.submitted_by == owner), count.where(c.submitted_by == owner)
    points, size = connection.execute(sums).one()
    waiting = connection.execute(count).scalar_one() if unfinished else 0
    return Taken(int(points), int(size), int(waiting))
