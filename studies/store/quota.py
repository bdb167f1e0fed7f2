"""How much the studies of a store may take, counted when one is submitted: before compression, as if it were done."""

from dataclasses import dataclass

from sqlalchemy import Connection, func, select

from damperlab.studies.faults import Fault
from damperlab.studies.store.faults import QuotaReached
from damperlab.studies.store.tables import studies

_ADVICE = "delete studies that are not needed (`damperlab delete`), ask for fewer points or metrics, or raise the quota"


@dataclass(frozen=True)
class Taken:
    """What the studies of a store take, those included that are deleted and whose files are still there.

    Parameters
    ----------
    points, bytes : int
        When every study is done, before compression.
    """

    points: int
    bytes: int

    def plus(self, points: int, size: int) -> "Taken":
        """Give what is taken with so much more."""
        return Taken(self.points + points, self.bytes + size)


@dataclass(frozen=True)
class Quota:
    """The most that studies may take together; None for as much as there is room for.

    Parameters
    ----------
    points, bytes : int, optional
        Bytes before compression, so that it can be known before a point is computed.
    """

    points: int | None = None
    bytes: int | None = None

    @property
    def limited(self) -> bool:
        """Whether there is a limit."""
        return self.points is not None or self.bytes is not None

    def require(self, before: Taken, after: Taken) -> None:
        """Refuse studies for which too little is left.

        Parameters
        ----------
        before, after : Taken
            Without them and with them.

        Raises
        ------
        QuotaReached
            Saying how much they would take and how much is left.
        """
        for field, limit, used, wanted, unit in (
            ("quota_points", self.points, before.points, after.points - before.points, "points"),
            ("quota_bytes", self.bytes, before.bytes, after.bytes - before.bytes, "bytes"),
        ):
            if limit is not None and wanted and used + wanted > limit:
                raise QuotaReached(
                    Fault(
                        field,
                        f"a study of {wanted:,} {unit}",
                        f"{max(0, limit - used):,} {unit}: the quota is {limit:,}, of which other "
                        f"studies use {used:,}",
                        _ADVICE,
                    )
                )


def taken(connection: Connection) -> Taken:
    """Add up what the studies take."""
    c = studies.c
    sums = select(func.coalesce(func.sum(c.points_total), 0), func.coalesce(func.sum(c.bytes_total), 0))
    # of a study whose files are gone an empty row stays
    points, size = connection.execute(sums.where(c.definition != "")).one()
    return Taken(int(points), int(size))
