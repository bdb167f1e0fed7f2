"""Reading of the catalogue's rows: queries of studies and done-marks, and errors for missing rows."""

import json
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any, TypeVar

from sqlalchemy import ColumnElement, Connection, Row, and_, func, insert, not_, or_, select, text, update

from damperlab.studies.faults import describe, nearest, printable
from damperlab.studies.kinds import dimensions_of_definition
from damperlab.studies.store.catalogue.rowsum import require_row
from damperlab.studies.store.catalogue.tables import done_blocks, events, studies
from damperlab.studies.store.faults import StudyBusy, StudyNotFound, catalogue_damaged
from damperlab.studies.store.provenance import DESIGNS, SUBMITTED_BY
from damperlab.studies.store.record import Record, utc
from damperlab.studies.store.solver import is_outdated

Item = TypeVar("Item")

ALIVE = studies.c.deleted.is_(None)
"""Condition for studies that were not deleted."""

LAST_SECONDS = 60.0
"""A deleted study can be restored up to this time before its files are removed [s]."""
NEVER_ENTERED = and_(studies.c.id == "", studies.c.digest == "")
"""Condition for rows that reserve a number while the cube of a new study is created."""
RESERVED = and_(NEVER_ENTERED, studies.c.state == "queued")
"""Condition for rows that reserve a number, and that the garbage collection has not withdrawn."""


def in_trash() -> ColumnElement[bool]:
    """Return the condition for studies that were deleted and can still be restored."""
    return and_(studies.c.deleted > time.time() + LAST_SECONDS, studies.c.definition != "")


def alive_row(connection: Connection, study_id: str) -> Row[Any] | None:
    """Return the row of the study with this complete id; None if there is no such study."""
    row = connection.execute(select(studies).where(studies.c.id == study_id, ALIVE)).one_or_none()
    if row is not None:
        require_row(studies, row, study_id)
    return row


def alive_rows(connection: Connection, ids: Iterable[str]) -> list[Row[Any]]:
    """Return the rows of the studies with these complete ids, in the order of the ids; missing studies are left out."""
    found: dict[str, Row[Any]] = {}
    every = list(ids)
    for some in pieces(every):
        for row in connection.execute(select(studies).where(studies.c.id.in_(some), ALIVE)):
            require_row(studies, row, row.id)
            found[row.id] = row
    return [found[each] for each in every if each in found]


def study_row(connection: Connection, study_id: str) -> Row[Any]:
    """Return the row of the study with this complete id; raise `StudyNotFound` if there is no such study."""
    row = alive_row(connection, study_id)
    if row is None:
        raise unknown_study(connection, study_id)
    return row


def change_studies(connection: Connection, numbers: Iterable[int], change: Mapping[str, Any]) -> None:
    """Write the same new values into the rows of studies, given by their serial numbers, by column."""
    for some in pieces(numbers):
        connection.execute(update(studies).where(studies.c.number.in_(some)).values(change))


def last_number(connection: Connection) -> int:
    """Return the largest serial number of a study, including deleted studies; 0 for an empty table."""
    return int(connection.execute(select(func.coalesce(func.max(studies.c.number), 0))).scalar_one())


def rows_of_marks(connection: Connection, number: int) -> Sequence[Row[Any]]:
    """Return the rows of a study's done-marks, in the order of the blocks."""
    query = select(done_blocks).where(done_blocks.c.study == number).order_by(done_blocks.c.block)
    return connection.execute(query).all()


VALUES = 500
"""Largest number of values in one SQL condition, and of rows in one page of a query."""
FIRST_DIGITS = 4
"""Smallest number of first digits by which a study can be named. A shorter text is more likely a mistyped name."""
NAMES_COMPARED = 1000
"""Number of newest studies whose names are compared with a mistyped name."""


def newest_row(connection: Connection, digest: str) -> Row[Any] | None:
    """Return the row of the newest version of the study with this digest; None if there is no such study."""
    query = select(studies).where(studies.c.digest == digest, ALIVE)
    row = connection.execute(query.order_by(studies.c.version.desc()).limit(1)).one_or_none()
    if row is not None:
        require_row(studies, row, row.id)
    return row


def asked_for(purpose: str) -> ColumnElement[bool]:
    """Return the SQL condition that selects studies submitted for `purpose`, one of `DESIGNS` and `REFINES`."""
    # test for null, because `NOT purpose = …` is null in SQL, and not true, for a study that a user submitted
    return and_(studies.c.purpose.is_not(None), studies.c.purpose == purpose)


def unknown_study(connection: Connection, ref: str) -> StudyNotFound:
    """Return the error for a missing study. The message names a similar study and the newest studies."""
    order = studies.c.number.desc()
    there = select(studies.c.id, studies.c.name).where(ALIVE).order_by(order).limit(NAMES_COMPARED)
    # leave out studies that a design submitted, unless there are no other studies
    own = there.where(not_(asked_for(DESIGNS)))
    newest = connection.execute(own).all() or connection.execute(there).all()
    known = ", ".join(f"{row.id} ({row.name})" for row in newest[:3])
    near = nearest(ref, dict.fromkeys(row.name for row in newest if row.name))
    lists = "`damperlab studies` lists the studies" if known else "submit a study first"
    advice = f"did you mean {near}?" if near else lists
    allowed = (
        f"an id, a name, or the first digits of an id; newest: {known}"
        if known
        else "nothing: there are no studies yet"
    )
    called = studies.c.id == ref if ref == "" else or_(studies.c.id == ref, studies.c.name == ref)
    row = connection.execute(
        select(studies.c.id, studies.c.deleted)
        .where(called, not_(ALIVE), not_(NEVER_ENTERED))
        .order_by(studies.c.deleted.desc())
        .limit(1)
    ).one_or_none()
    when = ""
    if row is not None:
        restorable = row.deleted > time.time()
        what = "in the trash until" if restorable else "deleted"
        when = f", {what} {utc(row.deleted):%Y-%m-%d %H:%M:%S} UTC"
        if restorable:
            advice = f"restore it with `damperlab undelete {row.id}`"
    told = f"There is no study {printable(ref)}{when}. " + (
        f"A study is named by its id, its name, or the first digits of its id; the newest are {known}."
        if known
        else "There are no studies yet."
    )
    return StudyNotFound("study", describe(ref) + when, allowed, advice, told)


def too_few_digits(ref: str, fits: Sequence[Row[Any]]) -> StudyNotFound:
    """Return the error for the first digits of an id, if they are too few or fit several studies."""
    known = ", ".join(f"{row.id} ({row.name})" for row in fits[:3])
    fitting = f"{printable(ref)} fits {known}"
    if len(ref) < FIRST_DIGITS:
        allowed = f"a name, or at least the first {FIRST_DIGITS} digits of an id; {fitting}"
        told = (
            f"No study is named {printable(ref)}, and at least {FIRST_DIGITS} digits of an id are needed; "
            f"{fitting}."
        )
    else:
        allowed = f"digits that fit one study only; {fitting}"
        told = f"{printable(ref)} fits more than one study: {known}."
    return StudyNotFound("study", describe(ref), allowed, "write more digits of the id", told)


def marks_of(
    connection: Connection, row: Row[Any], *, after: int | None = None, upto: int | None = None
) -> dict[int, str]:
    """Return the generation of each done block of a study, by the block's index.

    A generation is the unique name of an attempt to compute a block. A block is returned only if it was done after the
    revision `after`, and not later than the revision `upto`.

    Raises
    ------
    CatalogueDamaged
        If a done-mark has an index that no block of the study has.
    """
    c = done_blocks.c
    query = select(c.block, c.generation).where(c.study == row.number)
    if after is not None:
        query = query.where(c.revision > after)
    if upto is not None:
        query = query.where(c.revision <= upto)
    marks = {mark.block: str(mark.generation) for mark in connection.execute(query)}
    for block in marks:
        if not (isinstance(block, int) and 0 <= block < row.blocks_total):
            raise catalogue_damaged(row.id, f"a done-mark of a block {block} that does not exist")
    return marks


SUMS = {
    "points_done": "points",
    "points_failed": "failed",
    "points_reused": "reused",
    "seconds": "seconds",
    "kernel_seconds": "kernel_seconds",
}
"""Columns of `studies` that contain sums over done-marks, with the summed columns of `done_blocks`."""


def sums_of_marks(connection: Connection, number: int) -> dict[str, Any]:
    """Return the sums over the done-marks of a study. The keys are names of columns of `studies`."""
    b = done_blocks.c
    columns = [func.coalesce(func.sum(b[column]), 0).label(name) for name, column in SUMS.items()]
    query = select(func.count().label("blocks_done"), *columns).where(b.study == number)
    return dict(connection.execute(query).one()._mapping)


def lost_marks(row: Row[Any], found: int) -> str | None:
    """Return a message if done-marks are missing, else None; `found` is the number of existing done-marks."""
    if found != row.blocks_done:
        return f"{found} done-marks where {row.blocks_done} blocks are done"
    if row.state == "done" and found < row.blocks_total:
        return f"a study that is done although {row.blocks_total - found} of {row.blocks_total} done-marks are missing"
    return None


def claim_owner(row: Row[Any]) -> str | None:
    """Return the owner of the claim on a study; None if there is no claim, or the claim has ended."""
    # claims have no checksum, so the time may be invalid; the claim is then regarded as ended
    ends = row.claim_expires if isinstance(row.claim_expires, float) else 0.0
    return str(row.claim_owner) if row.claim_owner is not None and ends >= time.time() else None


def require_free(row: Row[Any], what: str) -> None:
    """Raise `StudyBusy` if a process has a claim on the study; `what` names the refused action."""
    owner = claim_owner(row)
    if owner is not None:
        raise StudyBusy(
            "study",
            f"{row.id} is {row.state}, worked on by {owner}",
            f"a study that no process works on, to {what} it",
            f"cancel it first, with `damperlab cancel {row.id}` or, over HTTP, by POST to its `/cancel`",
            f"Study {row.id} is {row.state} and worked on by {owner}, so it is not possible to {what} it now.",
        )


def _seconds_left(row: Row[Any]) -> float | None:
    left = row.points_total - row.points_done
    if left == 0:
        return 0.0
    if row.state != "running" or row.last_mark is None or row.points_done == row.run_points:
        return None
    # use wall time per point, so that the estimate is right for any number of workers
    pace = (row.last_mark - row.run_began) / (row.points_done - row.run_points)
    if pace <= 0.0:
        return None  # the clock has been set back
    return float(max(0.0, left * pace - max(0.0, time.time() - row.last_mark)))


_FIELDS = frozenset(field.name for field in fields(Record))


def record_of(row: Row[Any]) -> Record:
    """Convert the row of a study to a record."""
    require_row(studies, row, row.id)
    prepares = row.state == "running" and row.phase is not None
    definition, provenance = json.loads(row.definition), json.loads(row.provenance)
    computed = {
        "phase": row.phase if prepares else row.state,
        "phase_done": row.phase_done if prepares else None,
        "phase_total": row.phase_total if prepares else None,
        "created": utc(row.created),
        "started": utc(row.started),
        "finished": utc(row.finished),
        "seconds_left": _seconds_left(row),
        "definition": definition,
        "chunk": tuple(json.loads(row.chunk)),
        "provenance": provenance,
        "owner": claim_owner(row),
        "shape": tuple(json.loads(row.shape)),
        "outdated": row.blocks_done > 0 and is_outdated(provenance),
        "tags": tuple(json.loads(row.tags)),
        "dimensions": dimensions_of_definition(definition),
        "submitted_by": provenance.get(SUBMITTED_BY),
    }
    # the other fields of a record are columns of the row
    copied = {name: value for name, value in row._mapping.items() if name in _FIELDS}
    return Record(**(copied | computed))


def pieces(items: Iterable[Item]) -> Iterator[list[Item]]:
    """Yield the items in lists of at most `VALUES` items, each of which fits into one SQL condition."""
    every = list(items)
    for start in range(0, len(every), VALUES):
        yield every[start : start + VALUES]


def log_event(connection: Connection, study_id: str, what: str) -> None:
    """Add an event to a study's log."""
    log_events(connection, {study_id: what})


def log_events(connection: Connection, whats: Mapping[str, str]) -> None:
    """Add an event to the log of each study, by id."""
    now = time.time()
    if whats:
        rows = [{"study": study_id, "at": now, "what": what} for study_id, what in whats.items()]
        connection.execute(insert(events), rows)


def last_event(connection: Connection, study_id: str) -> float | None:
    """Return the time of a study's latest event, in seconds since 1970; None if there is no event."""
    found = connection.execute(select(func.max(events.c.at)).where(events.c.study == study_id)).scalar()
    return found if isinstance(found, float) else None


def advance_counters(connection: Connection) -> None:
    """Set PostgreSQL's sequences to the largest serial number in each table, after rows with given serial numbers were
    inserted.
    """
    if connection.dialect.name != "postgresql":
        return
    for table in (studies, events):
        last = select(func.max(table.c.number)).scalar_subquery()
        counter = func.pg_get_serial_sequence(text(f"'{table.name}'"), text("'number'"))
        connection.execute(select(func.setval(counter, func.coalesce(last, 1))))
