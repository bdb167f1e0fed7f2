"""The catalogue: one row per study and one per done block, in SQLite.

WAL lets readers go on while one writes; synchronous=FULL makes a committed done-mark survive a power cut.
Every writing transaction begins IMMEDIATE, so that it waits for its turn instead of failing half-way.
"""

import os
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import (
    Column,
    Connection,
    Engine,
    Float,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    create_engine,
    event,
)
from sqlalchemy.exc import DatabaseError

from studies.faults import Fault
from studies.store.durable import sync_path
from studies.store.faults import StoreFault

VERSION = 1
"""Version of the schema, kept in the file's user_version."""

BUSY_SECONDS = 60.0
"""How long a transaction waits for its turn before it gives up [s]."""

_metadata = MetaData()

studies = Table(
    "studies",
    _metadata,
    # never reused: it orders the pages and names the cube's folder, so no study meets a deleted one's files
    Column("number", Integer, primary_key=True),
    Column("id", String(12), nullable=False),
    Column("digest", String(64), nullable=False),
    Column("name", Text, nullable=False),
    Column("state", String, nullable=False),
    Column("message", Text),
    Column("definition", Text, nullable=False),
    Column("provenance", Text, nullable=False),
    Column("shape", Text, nullable=False),
    Column("chunk", Text, nullable=False),
    Column("points_total", Integer, nullable=False),
    Column("blocks_total", Integer, nullable=False),
    # running sums over done_blocks: a record stays one row to read, however many blocks there are
    Column("points_done", Integer, nullable=False, default=0),
    Column("points_failed", Integer, nullable=False, default=0),
    Column("blocks_done", Integer, nullable=False, default=0),
    Column("seconds", Float, nullable=False, default=0.0),
    Column("kernel_seconds", Float, nullable=False, default=0.0),
    Column("created", Float, nullable=False),
    Column("started", Float),
    Column("finished", Float),
    # the pace is taken from the moment the study last began to run
    Column("run_began", Float),
    Column("run_points", Integer),
    Column("last_mark", Float),
    Column("claim_owner", String),
    Column("claim_expires", Float),
    Column("deleted", Float),
    sqlite_autoincrement=True,
)
Index("live_id", studies.c.id, unique=True, sqlite_where=studies.c.deleted.is_(None))

done_blocks = Table(
    "done_blocks",
    _metadata,
    Column("study", ForeignKey("studies.number", ondelete="CASCADE"), primary_key=True),
    Column("block", Integer, primary_key=True, autoincrement=False),
    Column("points", Integer, nullable=False),
    Column("failed", Integer, nullable=False),
    Column("seconds", Float, nullable=False),
    Column("kernel_seconds", Float, nullable=False),
    Column("message", Text),
    Column("at", Float, nullable=False),
    # clustered by its key: the marks of one study are read in one sweep
    sqlite_with_rowid=False,
)


class Catalogue:
    """The catalogue file of one data directory; usable from several threads, beside other processes.

    Parameters
    ----------
    path : Path
        The file; it is made when it is not there.

    Raises
    ------
    StoreFault
        If the file cannot be opened or written, is no catalogue, or was made by a newer version.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._engine = _engine(path)
        self._writer = self._engine.execution_options(writes=True)
        with self._faults():
            self._prepare()

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """Open one snapshot of the catalogue."""
        with self._faults(), self._engine.begin() as connection:
            yield connection

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """Open one transaction that no other writer shares; it commits at the end, or not at all."""
        with self._faults(), self._writer.begin() as connection:
            yield connection

    def close(self) -> None:
        """Close every connection."""
        self._engine.dispose()

    def _prepare(self) -> None:
        # most opens find the catalogue ready and need no turn at writing
        with self._engine.begin() as connection:
            found = _version(connection)
        if found > VERSION:
            self._engine.dispose()
            raise StoreFault(
                Fault(
                    str(self.path),
                    f"catalogue version {found}",
                    f"version {VERSION} or older",
                    "it was made by a newer damperlab: upgrade this one, or choose another data directory",
                )
            )
        if found == VERSION:
            return
        self._switch_to_wal()
        with self._writer.begin() as connection:
            if _version(connection) == 0:  # else another process was faster
                _metadata.create_all(connection)
                connection.exec_driver_sql(f"PRAGMA user_version = {VERSION}")
        sync_path(self.path.parent)

    def _switch_to_wal(self) -> None:
        # several processes may open a new folder at once, and the switch ignores the busy timeout
        give_up = time.monotonic() + BUSY_SECONDS
        while True:
            connection = self._engine.raw_connection()
            try:
                connection.cursor().execute("PRAGMA journal_mode = WAL")
                return
            except sqlite3.OperationalError as error:
                if "locked" not in str(error) or time.monotonic() > give_up:
                    raise
                time.sleep(0.02)
            finally:
                connection.close()

    @contextmanager
    def _faults(self) -> Iterator[None]:
        try:
            yield
        except (DatabaseError, sqlite3.DatabaseError) as error:
            cause = error.orig if isinstance(error, DatabaseError) else error
            if not isinstance(cause, sqlite3.OperationalError) and "not a database" not in str(cause):
                raise
            raise StoreFault(
                Fault(
                    str(self.path),
                    str(cause),
                    "a catalogue file that can be read and written",
                    "check the folder's permissions and free space, and that the catalogue is damperlab's",
                )
            ) from error


def _engine(path: Path) -> Engine:
    engine = create_engine(f"sqlite:///{path}", connect_args={"timeout": BUSY_SECONDS})

    @event.listens_for(engine, "connect")
    def _connect(connection: Any, _: Any) -> None:
        # transactions begin where `_begin` says, not where the driver guesses
        connection.isolation_level = None
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute("PRAGMA foreign_keys = ON")

    @event.listens_for(engine, "begin")
    def _begin(connection: Connection) -> None:
        writes = connection.get_execution_options().get("writes", False)
        connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")

    return engine


def _version(connection: Connection) -> int:
    return int(connection.exec_driver_sql("PRAGMA user_version").scalar_one())


def open_catalogue(data_dir: Path) -> Catalogue:
    """Open the catalogue of a data directory, making both where they are missing.

    Parameters
    ----------
    data_dir : Path
        The data directory.

    Raises
    ------
    StoreFault
        If the folder cannot be made or written, or its catalogue is not ours to read.
    """
    fault = Fault(
        "data_dir",
        str(data_dir),
        "a folder that can be made and written",
        "name another folder with --data-dir, or change its permissions",
    )
    try:
        (data_dir / "cubes").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StoreFault(fault) from error
    if not os.access(data_dir, os.W_OK | os.X_OK):
        raise StoreFault(fault)
    return Catalogue(data_dir / "catalogue.sqlite")
