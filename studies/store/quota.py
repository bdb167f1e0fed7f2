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

    def require(self, connection: Connection, points: int, size: int) -> None:
        """Refuse a study for which too little is left.

        Raises
        ------
        QuotaReached
            Saying how much it would take and how much is left.
        """
        if self.points is None and self.bytes is None:
            return
        used = taken(connection)
        for field, limit, before, wanted, unit in (
            ("quota_points", self.points, used.points, points, "points"),
            ("quota_bytes", self.bytes, used.bytes, size, "bytes"),
        ):
            if limit is not None and before + wanted > limit:
                raise QuotaReached(
                    Fault(
                        field,
                        f"a study of {wanted:,} {unit}",
                        f"{max(0, limit - before):,} {unit}: the quota is {limit:,}, of which other "
                        f"studies use {before:,}",
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
