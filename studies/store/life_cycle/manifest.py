"""The marks of a cube, stored with its blocks, from which the catalogue's entry of a study can be restored.

The description holds the definition, and every block's file describes its content. When the study ends, the marks are
added as one piece with a checksum. The piece does not change while blocks are marked, and later blocks do not outdate
it, because the header of a block's file is a mark too. It is removed before marks are invalidated.
"""

import json
import uuid
from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection, Row, select

from damperlab.studies.store.catalogue.base import StoreBase
from damperlab.studies.store.catalogue.home import fact, remember
from damperlab.studies.store.catalogue.rows import study_row
from damperlab.studies.store.catalogue.tables import done_blocks, studies
from damperlab.studies.store.cube.description import DESCRIPTION, as_complete
from damperlab.studies.store.files.sealed import PLACEHOLDER, require_seal, seal
from damperlab.studies.store.files.shelf import TOMBSTONE, Shelf
from damperlab.studies.vocabulary import ENDED

MARKS = "marks.json"
"""The key of the piece with the marks."""

PUT_OFF = "marks of "
"""Prefix of the fact that names an ended study whose marks are yet to be written with its blocks."""

NOT_KEPT = frozenset({"number", "definition", "provenance", "claim_owner", "claim_expires", "deleted", "crc"})
"""Columns of a study's row that are not stored: its description contains them, or they mean nothing to another
catalogue.
"""


def keep_marks(store: StoreBase, study_id: str, changes: Mapping[str, Any]) -> None:
    """Write a study's marks with its blocks, and its completeness into its description.

    Parameters
    ----------
    store : StoreBase
        Where the study is.
    study_id : str
        Its whole id.
    changes : mapping
        New values of columns of its row that are about to change.

    Raises
    ------
    OSError
        If they cannot be written.
    """
    with store.catalogue.reading() as connection:
        row = study_row(connection, study_id)
        columns = [column for column in done_blocks.c if column.name not in ("study", "crc")]
        query = select(*columns).where(done_blocks.c.study == row.number).order_by(done_blocks.c.block)
        marks = [list(mark) for mark in connection.execute(query)]
    kept = {name: value for name, value in row._mapping.items() if name not in NOT_KEPT} | dict(changes)
    document = {
        "crc32c": PLACEHOLDER,
        "study": kept,
        "columns": [column.name for column in columns],
        "blocks": marks,
    }
    shelf = store.cube_shelf(study_id, row.number)
    shelf.put(MARKS, seal(json.dumps(document).encode()))
    if len(marks) == row.blocks_total:
        _say_complete(shelf, True)


def put_off_marks(connection: Connection, study_id: str) -> None:
    """Note in a transaction that the marks of a study are to be written later.

    The text of the note is unique, so that the writer of the marks deletes this note and no later one.
    """
    remember(connection, f"{PUT_OFF}{study_id}", uuid.uuid4().hex)


def marks_put_off(connection: Connection, study_id: str) -> bool:
    """Whether the marks of a study are yet to be written."""
    return fact(connection, f"{PUT_OFF}{study_id}") is not None


def drop_marks(shelf: Shelf) -> None:
    """Remove a study's marks, before blocks of it are invalidated."""
    _say_complete(shelf, False)
    shelf.remove(MARKS)


def put_tombstone(shelf: Shelf, deleted: float) -> None:
    """Record with a cube's blocks that its study was deleted, and when; the files may remain for a while.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    shelf.put(TOMBSTONE, seal(json.dumps({"crc32c": PLACEHOLDER, "deleted": deleted}).encode()))


def read_tombstone(shelf: Shelf) -> float | None:
    """Give the time when a cube's study was deleted, in seconds since 1970; None if it was not.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is not what was written.
    """
    try:
        content = shelf.get(TOMBSTONE)
    except FileNotFoundError:
        return None
    require_seal(content)
    return float(json.loads(content)["deleted"])


def read_marks(shelf: Shelf) -> tuple[dict[str, Any], list[dict[str, Any]]] | None:
    """Give the study's data in the marks, and one dictionary per block; None if there are no marks.

    Raises
    ------
    OSError
        If they cannot be read.
    ValueError
        If they are not what was written.
    """
    try:
        content = shelf.get(MARKS)
    except FileNotFoundError:
        return None
    return parse_marks(content)


def parse_marks(content: bytes) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Read the content of the marks; raise `ValueError` if it is damaged."""
    require_seal(content)
    document = json.loads(content)
    columns = document["columns"]
    return document["study"], [dict(zip(columns, row, strict=True)) for row in document["blocks"]]


def lost_end(kept: Mapping[str, Any], row: Row[Any], last_event: float | None) -> bool:
    """Whether the marks record an end that the catalogue has lost, for example with the end of its write-ahead log.

    Parameters
    ----------
    kept : mapping
        The study's data in the marks; empty if there are none.
    row : Row
        The catalogue's data.
    last_event : float, optional
        Time of the study's latest event, in seconds since 1970. A study that was resumed after its end has not lost the
        end.
    """
    finished = kept.get("finished")
    if kept.get("state") not in ENDED or finished is None or row.finished == finished:
        return False
    return bool(max(last_event or 0.0, row.run_began or 0.0) < finished)


def study_columns() -> frozenset[str]:
    """Names of the columns that the marks may restore; marks of an older program may have fewer."""
    return frozenset(studies.c.keys()) - NOT_KEPT


def _say_complete(shelf: Shelf, complete: bool) -> None:
    try:
        old = shelf.get(DESCRIPTION)
        new = as_complete(old, complete)
    except (FileNotFoundError, ValueError):
        return  # the marks are damaged: `verify` reports this, and its repair writes them again
    if new != old:
        shelf.put(DESCRIPTION, new)
