"""Quota of the studies in a store, which is checked at submission. Sizes are for complete, uncompressed studies."""

from dataclasses import dataclass
from typing import Optional

from sqlalchemy import Connection, func, select

from damperlab.studies.store.catalogue.tables import WAITING, studies
from damperlab.studies.store.faults import QuotaReached, TooManyUnfinished

_ADVICE = "delete studies that are not needed (`damperlab delete`), ask for fewer points or metrics, or raise the quota"


@dataclass(frozen=True)
class Usage:
    """Usage of a store by its studies, including deleted studies whose files still exist.

    Parameters
    ----------
    points, bytes : int
        Number of points and bytes of all studies when they are complete, before compression.
    unfinished : int
        Number of waiting and running studies; 0 if these studies were not counted.
    """

    points: int
    bytes: int
    unfinished: int = 0


@dataclass(frozen=True)
class Quota:
    """Limits on the studies of a store or of one owner.

    Parameters
    ----------
    points, bytes : int, optional
        Largest number of points and of bytes before compression; None for no limit.
    unfinished : int, optional
        Largest number of waiting and running studies; None for no limit.
    of_owner : Quota, optional
        Limits on the studies of each owner of access keys; None for no limits.
    setting : str
        Prefix for the names of the limits in messages, for example `quota_points`.
    """

    points: int | None = None
    bytes: int | None = None
    unfinished: int | None = None
    of_owner: Optional["Quota"] = None
    setting: str = "quota"

    @property
    def limited(self) -> bool:
        """Whether there is a limit on all studies together."""
        return any(limit is not None for limit in (self.points, self.bytes, self.unfinished))

    def require(self, before: Usage, after: Usage) -> None:
        """Raise an error if new studies exceed the quota, given the usage without and with the new studies.

        Raises
        ------
        QuotaReached
            If the points or bytes exceed the quota.
        TooManyUnfinished
            If too many studies would wait or run.
        """
        for unit, limit, used, wanted in (
            ("points", self.points, before.points, after.points - before.points),
            ("bytes", self.bytes, before.bytes, after.bytes - before.bytes),
        ):
            if limit is not None and wanted and used + wanted > limit:
                raise QuotaReached(
                    f"{self.setting}_{unit}",
                    f"a study of {wanted:,} {unit}",
                    f"{max(0, limit - used):,} {unit}: the quota is {limit:,}, of which other "
                    f"studies use {used:,}",
                    _ADVICE,
                    f"{{field}} does not suffice: the study would take {wanted:,} {unit}, and {max(0, limit - used):,} "
                    f"{unit} of {limit:,} are left.",
                )
        if self.unfinished is not None and self.unfinished < after.unfinished > before.unfinished:
            found = f"{after.unfinished:,} studies that wait or run"
            allowed = f"at most {self.unfinished:,} at a time"
            advice = "wait until some have ended, or cancel some"
            told = f"{{field}} allows {allowed}, and there would be {found}."
            raise TooManyUnfinished(f"{self.setting}_unfinished", found, allowed, advice, told)


class Ledger:
    """Counts the usage, in total and of each owner, while one transaction enters several studies.

    The ledger must be made before the transaction enters the first study.
    """

    def __init__(self, connection: Connection, quota: Quota) -> None:
        self._connection = connection
        self._quota = quota
        self._sums: dict[str | None, Usage] = {}

    def enter(self, owner: str | None, points: int, size: int, count: int) -> None:
        """Add new studies of one owner to the usage. If the studies exceed a quota, no study is added.

        Raises
        ------
        QuotaReached
            If the points, the bytes or the number of unfinished studies exceed a quota (`Quota.require`).
        """
        each = self._quota.of_owner if owner is not None else None
        after: dict[str | None, Usage] = {}
        for whose, quota in ((None, self._quota), (owner, each)):
            if quota is not None and quota.limited:
                before = self._sums.get(whose) or usage_of(
                    self._connection, whose, unfinished=quota.unfinished is not None
                )
                after[whose] = Usage(before.points + points, before.bytes + size, before.unfinished + count)
                quota.require(before, after[whose])
        self._sums |= after


def usage_of(connection: Connection, owner: str | None = None, *, unfinished: bool = False) -> Usage:
    """Return the usage by all studies, or by the studies of one owner."""
    c = studies.c
    sums = select(func.coalesce(func.sum(c.points_total), 0), func.coalesce(func.sum(c.bytes_total), 0))
    # leave out deleted studies whose files have been removed; their rows have an empty definition
    sums = sums.where(c.definition != "")
    count = select(func.count()).select_from(studies).where(WAITING)
    if owner is not None:
        sums, count = sums.where(c.submitted_by == owner), count.where(c.submitted_by == owner)
    points, size = connection.execute(sums).one()
    waiting = connection.execute(count).scalar_one() if unfinished else 0
    return Usage(int(points), int(size), int(waiting))
