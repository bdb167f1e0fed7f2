"""Rows of the catalogue, as records, flags and faults."""

import base64
import binascii
import json
import time
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, TypeVar

from sqlalchemy import ColumnElement, Connection, Row, and_, func, insert, not_, or_, select, text

from damperlab.studies.faults import Fault, describe, nearest, printable
from damperlab.studies.kinds import dimensions_of_definition
from damperlab.studies.store.catalogue.rowsum import require_row
from damperlab.studies.store.catalogue.tables import done_blocks, events, studies
from damperlab.studies.store.faults import StoreFault, StudyNotFound, catalogue_damaged
from damperlab.studies.store.provenance import DESIGNS, SUBMITTED_BY
from damperlab.studies.store.record import Record, utc
from damperlab.studies.store.solver import is_outdated

Item = TypeVar("Item")

ALIVE = studies.c.deleted.is_(None)
"""The studies that were not deleted."""

LAST_SECONDS = 60.0
"""Time before the files of a deleted study may be removed, because clocks of processes may differ."""
NEVER_ENTERED = and_(studies.c.id == "", studies.c.digest == "")
"""Numbers reserved for studies while their cubes are created; an entered study takes over the row."""
RESERVED = and_(NEVER_ENTERED, studies.c.state == "queued")
"""Reserved numbers that were not withdrawn as garbage."""


def in_trash() -> ColumnElement[bool]:
    """Say whether a row's study was deleted and can still be restored."""
    return and_(studies.c.deleted > time.time() + LAST_SECONDS, studies.c.definition != "")


def alive_row(connection: Connection, study_id: str) -> Row[Any] | None:
    """Find a study by its complete id; None if there is none."""
    row = connection.execute(select(studies).where(studies.c.id == study_id, ALIVE)).one_or_none()
    if row is not None:
        require_row(studies, row, study_id)
    return row


def study_row(connection: Connection, study_id: str) -> Row[Any]:
    """Find a study by its complete id; raise `StudyNotFound` if there is none."""
    row = alive_row(connection, study_id)
    if row is None:
        raise unknown_study(connection, study_id)
    return row


VALUES = 500
"""Largest number of values, or rows, in one statement."""
FIRST_DIGITS = 4
"""Fewest digits that identify an id; a shorter text may as well be a mistyped name."""
NAMES_COMPARED = 1000
"""Newest studies whose names are searched for a mistyped one."""


def newest_row(connection: Connection, digest: str) -> Row[Any] | None:
    """Find the newest version of a definition; None if there is none."""
    query = select(studies).where(studies.c.digest == digest, ALIVE)
    row = connection.execute(query.order_by(studies.c.version.desc()).limit(1)).one_or_none()
    if row is not None:
        require_row(studies, row, row.id)
    return row


def asked_for(purpose: str) -> ColumnElement[bool]:
    """Say whether a program submitted a row's study for this purpose."""
    # the test for null comes first, so that the negation is true for a study submitted by a user
    return and_(studies.c.purpose.is_not(None), studies.c.purpose == purpose)


def unknown_study(connection: Connection, ref: str) -> StudyNotFound:
    """Make the fault for a missing study. It says when the study was deleted, which one was probably meant, and names a
    few others.
    """
    order = studies.c.number.desc()
    there = select(studies.c.id, studies.c.name).where(ALIVE).order_by(order).limit(NAMES_COMPARED)
    # studies submitted by programs are named only if there are no others
    own = there.where(not_(asked_for(DESIGNS)))
    newest = connection.execute(own).all() or connection.execute(there).all()
    known = ", ".join(f"{row.id} ({row.name})" for row in newest[:3])
    near = nearest(ref, dict.fromkeys(row.name for row in newest if row.name))
    advice = f"did you mean {near}?" if near else "`damperlab studies` lists what there is"
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
    return StudyNotFound(Fault("study", describe(ref) + when, allowed, advice, told))


def too_few_digits(ref: str, fits: Sequence[Row[Any]]) -> StudyNotFound:
    """Make the fault for the first digits of an id that are too few, or match several studies."""
    known = ", ".join(f"{row.id} ({row.name})" for row in fits[:3])
    if len(ref) < FIRST_DIGITS:
        allowed = f"a name, or at least the first {FIRST_DIGITS} digits of an id; these digits begin {known}"
        told = (
            f"No study is named {printable(ref)}, and an id needs {FIRST_DIGITS} digits; these begin {known}."
        )
    else:
        allowed = f"digits that fit one study; these fit {known}"
        told = f"{printable(ref)} fits more than one study: {known}."
    return StudyNotFound(Fault("study", describe(ref), allowed, "write more digits of the id", told))


def marks_of(
    connection: Connection, row: Row[Any], *, after: int | None = None, upto: int | None = None
) -> dict[int, str]:
    """Give the generation of every done block of a study, or of those done between two revisions, by the block's index.

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
"""The columns of a study with sums of columns of its done-marks."""


def sums_of_marks(connection: Connection, number: int) -> dict[str, Any]:
    """Add up the done-marks of a study, by the names of the columns for the sums."""
    b = done_blocks.c
    columns = [func.coalesce(func.sum(b[column]), 0).label(name) for name, column in SUMS.items()]
    query = select(func.count().label("blocks_done"), *columns).where(b.study == number)
    return dict(connection.execute(query).one()._mapping)


def lost_marks(row: Row[Any], found: int) -> str | None:
    """Report that the number of done-marks differs from a study's row, or that a study is done although marks are
    missing; None if all is well.
    """
    if found != row.blocks_done:
        return f"{found} done-marks where {row.blocks_done} blocks are done"
    if row.state == "done" and found < row.blocks_total:
        return f"a study that is done although {row.blocks_total - found} of {row.blocks_total} done-marks are missing"
    return None


def claim_owner(row: Row[Any]) -> str | None:
    """Give the present owner of the claim on the study."""
    # the time has no checksum; an invalid one counts as past
    ends = row.claim_expires if isinstance(row.claim_expires, float) else 0.0
    return str(row.claim_owner) if row.claim_owner is not None and ends >= time.time() else None


def _seconds_left(row: Row[Any]) -> float | None:
    left = row.points_total - row.points_done
    if left == 0:
        return 0.0
    if row.state != "running" or row.last_mark is None or row.points_done == row.run_points:
        return None
    # measured in wall time, so that the pace is right for any number of workers
    pace = (row.last_mark - row.run_began) / (row.points_done - row.run_points)
    if pace <= 0.0:
        return None  # the clock was set back meanwhile
    return float(max(0.0, left * pace - max(0.0, time.time() - row.last_mark)))


def record_of(row: Row[Any]) -> Record:
    """Convert a study's row into a record."""
    require_row(studies, row, row.id)
    created = utc(row.created)
    assert created is not None
    prepares = row.state == "running" and row.phase is not None
    definition, provenance = json.loads(row.definition), json.loads(row.provenance)
    return Record(
        id=row.id,
        name=row.name,
        state=row.state,
        phase=row.phase if prepares else row.state,
        phase_done=row.phase_done if prepares else None,
        phase_total=row.phase_total if prepares else None,
        points_total=row.points_total,
        points_done=row.points_done,
        points_failed=row.points_failed,
        blocks_total=row.blocks_total,
        blocks_done=row.blocks_done,
        created=created,
        started=utc(row.started),
        finished=utc(row.finished),
        seconds_left=_seconds_left(row),
        definition=definition,
        digest=row.digest,
        chunk=tuple(json.loads(row.chunk)),
        provenance=provenance,
        message=row.message,
        seconds=row.seconds,
        kernel_seconds=row.kernel_seconds,
        owner=claim_owner(row),
        points_reused=row.points_reused,
        revision=row.revision,
        reuse=row.reuse,
        shape=tuple(json.loads(row.shape)),
        version=row.version,
        outdated=row.blocks_done > 0 and is_outdated(provenance),
        priority=row.priority,
        tags=tuple(json.loads(row.tags)),
        note=row.note,
        dimensions=dimensions_of_definition(definition),
        submitted_by=provenance.get(SUBMITTED_BY),
    )


def cursor_of(number: int) -> str:
    """Give the cursor of the page after the study of this number."""
    return base64.urlsafe_b64encode(f"before {number}".encode()).decode().rstrip("=")


def number_before(cursor: str) -> int:
    """Read a cursor; raise `StoreFault` if it is invalid."""
    try:
        text = base64.urlsafe_b64decode(cursor + "=" * (-len(cursor) % 4)).decode()
        word, number = text.split(" ")
        if word == "before" and number.isascii() and number.isdigit() and len(number) < 19:
            return int(number)
    except (binascii.Error, ValueError):
        pass
    raise StoreFault(
        Fault("cursor", describe(cursor), "the cursor of a page", "leave it out for the first page")
    )


def pieces(items: Iterable[Item]) -> Iterator[list[Item]]:
    """Split long lists into parts that one statement takes."""
    every = list(items)
    for start in range(0, len(every), VALUES):
        yield every[start : start + VALUES]


def log_event(connection: Connection, study_id: str, what: str) -> None:
    """Add an event to a study's log."""
    connection.execute(insert(events).values(study=study_id, at=time.time(), what=what))


def last_event(connection: Connection, study_id: str) -> float | None:
    """Give the time of a study's latest event, in seconds since 1970."""
    found = connection.execute(select(func.max(events.c.at)).where(events.c.study == study_id)).scalar()
    return found if isinstance(found, float) else None


def advance_counters(connection: Connection) -> None:
    """Advance the counter of numbers after rows were inserted with given numbers, which PostgreSQL's counters do not
    notice.
    """
    if connection.dialect.name != "postgresql":
        return
    for table in (studies, events):
        last = select(func.max(table.c.number)).scalar_subquery()
        counter = func.pg_get_serial_sequence(text(f"'{table.name}'"), text("'number'"))
        connection.execute(select(func.setval(counter, func.coalesce(last, 1))))
