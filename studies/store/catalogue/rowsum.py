"""Checksums of the catalogue's rows. A flipped bit in the database is reported as damage, and never read as a result.

A transaction removes the checksum of each row that it writes, and adds the new checksum before it ends
(`Catalogue.writing`). So a row lacks its checksum only while a transaction writes it.
"""

from collections.abc import Mapping
from functools import cache
from typing import Any

import google_crc32c
from sqlalchemy import (
    Boolean,
    Column,
    Connection,
    Float,
    Insert,
    Integer,
    Row,
    Table,
    Update,
    bindparam,
    select,
    update,
)

from damperlab.studies.store.catalogue.tables import SUMMED
from damperlab.studies.store.faults import CatalogueDamaged, catalogue_damaged

_LEFT_OUT = {"crc", "claim_owner", "claim_expires"}
"""Columns that a checksum leaves out. Claims need none, because frequent renewals correct a flipped bit."""

_TOUCHED = "damperlab touched"
_SEALS = {"seals": True}
_AT_ONCE = 1000


def row_sum(table: Table, row: Row[Any]) -> int:
    """Return the checksum of a row: the CRC-32C of the columns whose values differ from the defaults."""
    values = row._mapping
    # defaults are left out, so that a new column does not change the checksums of existing rows
    kept = [
        (name, plain)
        for name, kind, default in _told(table)
        if (value := values[name]) is not None and (plain := _plain(kind, value)) != default
    ]
    return int(google_crc32c.value(repr(kept).encode()))


@cache
def _told(table: Table) -> tuple[tuple[str, type, Any], ...]:
    """Return name, type and default of each column of a table that its checksums contain."""
    return tuple(
        (column.name, _kind(column), getattr(column.default, "arg", None))
        for column in table.c
        if column.name not in _LEFT_OUT
    )


def _kind(column: Column[Any]) -> type:
    """Return the type whose values every database returns for a column."""
    if isinstance(column.type, Float):
        return float
    return int if isinstance(column.type, Boolean | Integer) else str


def is_sound(table: Table, row: Row[Any]) -> bool:
    """Whether a row is intact. The row must have all columns of the table."""
    if row.crc is not None:
        return bool(row.crc == row_sum(table, row))
    # a row without a checksum is being written; but SQLite reads a damaged page of zeros as rows of null values
    return all(row._mapping[column.name] is not None for column in table.c if not column.nullable)


def require_row(table: Table, row: Row[Any], study_id: str) -> None:
    """Raise `CatalogueDamaged` if a row is damaged. The row must have all columns of the table."""
    if not is_sound(table, row):
        raise damaged_row(table, study_id)


def damaged_row(table: Table, study_id: str) -> CatalogueDamaged:
    """Return the error for a damaged row of a table."""
    return catalogue_damaged(
        study_id,
        f"a row of {table.name} whose checksum does not match its contents",
        "restore the damaged rows from the cubes with `damperlab store rebuild`, which leaves intact rows "
        "unchanged",
    )


def watch(
    connection: Connection, statement: Any, many: Any, one: Any, options: Mapping[str, Any]
) -> tuple[Any, Any, Any]:
    """Make an UPDATE statement also remove the checksums of the rows. Store the table's name for `seal_rows`.

    SQLAlchemy calls this function before each statement, and executes the returned statement.
    """
    if isinstance(statement, Insert | Update) and statement.table in SUMMED and not options.get("seals"):
        connection.info.setdefault(_TOUCHED, set()).add(statement.table.name)
        if isinstance(statement, Update):
            statement = statement.values(crc=None)
    return statement, many, one


def seal_rows(connection: Connection) -> None:
    """Add missing checksums to the rows of the tables that the transaction has written."""
    touched = connection.info.pop(_TOUCHED, set())
    for table in SUMMED:
        if table.name in touched:
            _seal(connection, table)


def forget_touched(connection: Connection) -> None:
    """Forget which tables an earlier transaction on this connection has written."""
    connection.info.pop(_TOUCHED, None)


def _seal(connection: Connection, table: Table) -> None:
    own = list(table.primary_key.columns)
    change = (
        update(table)
        .where(*(column == bindparam(f"of_{column.name}") for column in own))
        .values(crc=bindparam("sum"))
        .execution_options(**_SEALS)
    )
    while True:
        rows = connection.execute(select(table).where(table.c.crc.is_(None)).limit(_AT_ONCE)).all()
        if not rows:
            return
        connection.execute(
            change,
            [
                {
                    **{f"of_{column.name}": row._mapping[column.name] for column in own},
                    "sum": row_sum(table, row),
                }
                for row in rows
            ],
        )


def _plain(kind: type, value: Any) -> Any:
    """Convert a value to the form that every database returns."""
    try:
        plain = kind(value)
    except (TypeError, ValueError):
        return repr(value)
    # SQLite stores values of any type in a column, so a flipped bit may change the type
    return plain if plain == value else repr(value)
