"""The list of done-marks in a cube, from which a lost catalogue can be restored.

The list is written as one file when a study ends, and removed before done-marks are invalidated. The done-marks of
blocks that are done later are only in the headers of the blocks' files.
"""

import json
import uuid
from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection, Row, select

from damperlab.studies.store.catalogue.home import fact, remember
from damperlab.studies.store.catalogue.rows import study_row
from damperlab.studies.store.catalogue.tables import done_blocks
from damperlab.studies.store.cubes import Cubes
from damperlab.studies.store.files.sealed import PLACEHOLDER, require_seal, seal
from damperlab.studies.store.files.shelf import TOMBSTONE, Shelf
from damperlab.studies.vocabulary import ENDED

MARKS = "marks.json"
"""Name of the file with the list of done-marks."""

PUT_OFF = "marks of "
"""Prefix of the keys in the table `facts` that name studies whose done-marks must still be written."""

NOT_KEPT = frozenset({"number", "definition", "provenance", "claim_owner", "claim_expires", "deleted", "crc"})
"""Columns of a study's row that are not written with the done-marks."""


def keep_marks(store: Cubes, study_id: str, changes: Mapping[str, Any]) -> None:
    """Write the done-marks of a study into its cube.

    `changes` contains the values, by column, that the caller is about to write into the study's row.

    Raises
    ------
    OSError
        If the marks cannot be written.
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
    store.cube_shelf(study_id, row.number).put(MARKS, seal(json.dumps(document).encode()))


def put_off_marks(connection: Connection, study_id: str) -> None:
    """Record a note in the catalogue: the done-marks of a study must be written into its cube later.

    Each note has a unique text. So a process that has written the marks deletes only the note that it has read.
    """
    remember(connection, f"{PUT_OFF}{study_id}", uuid.uuid4().hex)


def marks_put_off(connection: Connection, study_id: str) -> str | None:
    """Return the note of `put_off_marks` for a study; None if there is no such note."""
    return fact(connection, f"{PUT_OFF}{study_id}")


def put_tombstone(shelf: Shelf, deleted: float) -> None:
    """Record in a cube that the study was deleted, with the time of the deletion; raise `OSError` if this fails."""
    shelf.put(TOMBSTONE, seal(json.dumps({"crc32c": PLACEHOLDER, "deleted": deleted}).encode()))


def read_tombstone(shelf: Shelf) -> float | None:
    """Return the time when a cube's study was deleted, in seconds since 1970; None if the study was not deleted.

    Raises
    ------
    OSError
        If the record of the deletion cannot be read.
    ValueError
        If the record of the deletion is damaged.
    """
    try:
        content = shelf.get(TOMBSTONE)
    except FileNotFoundError:
        return None
    require_seal(content)
    return float(json.loads(content)["deleted"])


def read_marks(shelf: Shelf) -> tuple[dict[str, Any], list[dict[str, Any]]] | None:
    """Return the stored columns of the study's row, and the done-marks; None if the cube has no list of done-marks.

    Raises
    ------
    OSError
        If the list cannot be read.
    ValueError
        If the list is damaged.
    """
    try:
        content = shelf.get(MARKS)
    except FileNotFoundError:
        return None
    require_seal(content)
    document = json.loads(content)
    columns = document["columns"]
    return document["study"], [dict(zip(columns, row, strict=True)) for row in document["blocks"]]


def lost_end(kept: Mapping[str, Any], row: Row[Any], last_event: float | None) -> bool:
    """Whether the cube records that the study ended, but the catalogue has lost this information.

    `kept` is the study's data from `read_marks`; it is empty if the cube has no list of done-marks. If the latest event
    in the catalogue is later than the recorded end, the study was resumed, and nothing is lost.
    """
    finished = kept.get("finished")
    if kept.get("state") not in ENDED or finished is None or row.finished == finished:
        return False
    return bool(max(last_event or 0.0, row.run_began or 0.0) < finished)
