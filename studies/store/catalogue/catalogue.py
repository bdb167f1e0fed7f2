"""The catalogue: a database in SQLite or PostgreSQL, with a row for each study and a row for each done block.

SQLite uses a write-ahead log (WAL), so readers continue while one process writes. With synchronous=FULL, a committed
done-mark survives a power cut. A writing transaction waits for the write lock at its start: BEGIN IMMEDIATE in SQLite,
an advisory lock in PostgreSQL.
"""

import math
import os
import re
import socket
import sqlite3
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

from sqlalchemy import URL, Connection, Engine, create_engine, event, insert, inspect, make_url, select
from sqlalchemy.exc import (
    ArgumentError,
    DatabaseError,
    DBAPIError,
    DisconnectionError,
    NoSuchModuleError,
    PendingRollbackError,
    ResourceClosedError,
)
from sqlalchemy.exc import TimeoutError as PoolTimeout
from sqlalchemy.pool import NullPool

from damperlab.studies.store.catalogue.rowsum import forget_touched, seal_rows, watch
from damperlab.studies.store.catalogue.tables import create_tables, facts
from damperlab.studies.store.faults import CatalogueDamaged, StoreFault
from damperlab.studies.store.files.folder import sync_path

BUSY_SECONDS = 60.0
"""Longest time that a transaction waits for the write lock by default [s]."""

SQLITE_FILE = "catalogue.sqlite"
"""Name of the SQLite file in the data directory."""

REVISION = 2
"""Revision of the database schema, stored in the catalogue. Version 0.1.0 of damperlab had revision 1."""

_REVISION_KEY = "revision"
"""Key of the revision in the table `facts`."""

_WRITER = "-writer"
"""Suffix of the file that contains the id of the writing process."""

_IDLE_SECONDS = 60
"""Time after which PostgreSQL ends an idle writing transaction, and so releases the write lock [s]."""

_STATEMENT_SECONDS = 30
"""Time after which PostgreSQL ends a statement [s]."""

_POOL_SECONDS = 10
"""Longest time that a thread waits for a free connection [s]."""

_PATIENCE = {
    "connect_timeout": 5,
    # detect a broken connection within seconds
    "keepalives": 1,
    "keepalives_idle": 5,
    "keepalives_interval": 3,
    "keepalives_count": 3,
    "tcp_user_timeout": 10_000,
}
"""Longest times to connect to PostgreSQL, and to notice a broken connection [s; `tcp_user_timeout` in ms]."""

_DAMAGED = ("not a database", "malformed", "no such table", "no such column")
"""Parts of SQLite's messages for a damaged file, and for missing tables and columns."""

_LOST = {"UndefinedTable", "UndefinedColumn"}
"""Exceptions of PostgreSQL's driver for missing tables and columns."""

_TROUBLES = {
    "OperationalError",
    "InterfaceError",
    "LockNotAvailable",
    # the server has ended an idle transaction, refuses writes, or has revoked a right
    "InternalError",
    "InsufficientPrivilege",
}
"""Names of the drivers' exception classes whose cause is outside the program."""
_NOT_OURS = (
    # no connection was free in time, or the connection was lost
    PoolTimeout,
    DisconnectionError,
    PendingRollbackError,
    ResourceClosedError,
    # with SQLite, only damaged names of tables or columns can raise a UnicodeDecodeError
    UnicodeDecodeError,
)
"""Exceptions whose cause is always outside the program."""
_WRITERS_LOCK = 0x64616D70  # arbitrary number that identifies the write lock


class Catalogue:
    """The catalogue of a data directory. Several threads and processes may use one catalogue at the same time.

    Parameters
    ----------
    url : URL
        Address of the database, `sqlite:///path` or `postgresql://…`. Missing tables are created.
    wait_seconds : float
        Longest time that a transaction waits for the write lock [s].

    Raises
    ------
    StoreFault
        If the database cannot be used, is not a catalogue, or contains the tables of another version.
    """

    def __init__(self, url: URL, wait_seconds: float = BUSY_SECONDS) -> None:
        self._url = url
        self.read_only = False
        """Whether the catalogue refuses every change."""
        self._wait_seconds = wait_seconds
        # at most one thread of this process waits for the database's write lock, so that connections remain for readers
        self._turn = threading.Lock()
        self.name = url.render_as_string(hide_password=True) if url.host or not url.database else url.database
        """Path of the SQLite file, or address of the PostgreSQL database without the password."""
        self.is_file = url.get_backend_name() == "sqlite"
        """Whether the catalogue is a SQLite file in the data directory."""
        with self._faults():
            self._engine = _sqlite_engine(url, wait_seconds) if self.is_file else _postgresql_engine(url)
            # `greet` opens a new connection each time, because all connections of the pool may be blocked
            self._greeting = create_engine(url, poolclass=NullPool, connect_args=_patience(url))
            event.listen(self._engine, "before_execute", watch, retval=True)
            try:
                self._prepare()
            except BaseException:
                self._engine.dispose()
                raise

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """Open a transaction that reads one snapshot of the catalogue."""
        with self._faults(), self._engine.begin() as connection:
            yield connection

    def greet(self) -> None:
        """Send a query to the database over a separate connection; raise `StoreFault` if the query fails."""
        with self._faults(), self._greeting.connect() as connection:
            connection.exec_driver_sql("SELECT 1 FROM facts")

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """Open a transaction that excludes other writers. An exception in the context rolls the transaction back."""
        if self.read_only:
            raise StoreFault(
                self.name,
                "a data folder that is not writable, opened for reading only",
                "a writable data folder, for any change",
                "copy the folder elsewhere, or change its permissions or how its disk is mounted",
                f"{self.name} was opened for reading only, because its folder is not writable; nothing can be changed.",
            )
        give_up = time.monotonic() + self._wait_seconds
        with self._faults(), self._in_turn(), self._engine.connect() as connection:
            connection.execution_options(writes=max(0.001, give_up - time.monotonic()))
            with connection.begin():
                forget_touched(connection)
                self._sign()
                yield connection
                seal_rows(connection)

    @contextmanager
    def _in_turn(self) -> Iterator[None]:
        if not self._turn.acquire(timeout=self._wait_seconds):
            raise self._busy("it is locked: other threads of this process write")
        try:
            yield
        finally:
            self._turn.release()

    def _sign(self) -> None:
        """Write the id of this process into a file, so that messages of waiting processes can name the writer."""
        if self.is_file and self._url.database:
            with suppress(OSError):
                Path(f"{self._url.database}{_WRITER}").write_text(
                    f"{os.getpid()} {socket.gethostname()} {time.time():.0f}"
                )

    def _lock_holder(self) -> str:
        """Describe, for a message, the process that seems to have the write lock."""
        try:
            pid, host, since = Path(f"{self._url.database}{_WRITER}").read_text().split()
            seconds = max(0.0, time.time() - float(since))
        except (OSError, ValueError):
            return "another process holds the lock"
        return (
            f"process {pid} on {host} has held the lock for {seconds:.0f} s; if the process hangs, end it "
            f"(kill -9 {pid})"
        )

    def integrity(self) -> list[str]:
        """Return SQLite's messages about damage in the file; an empty list for PostgreSQL, which is not checked."""
        if not self.is_file:
            return []
        with self.reading() as connection:
            found = [str(row[0]) for row in connection.exec_driver_sql("PRAGMA integrity_check(10)")]
            found += [
                f"a row of {row[0]} refers to a row that does not exist"
                for row in connection.exec_driver_sql("PRAGMA foreign_key_check")
            ]
        return [line for line in found if line != "ok"]

    def close(self) -> None:
        """Close every connection."""
        self._engine.dispose()

    def _prepare(self) -> None:
        # if the tables exist already, no write lock is needed
        with self._engine.begin() as connection:
            found = _revision(connection)
        if found == REVISION:
            return
        if found is not None:
            raise self._another(found)
        if self.is_file:
            self._switch_to_wal()
        with self._engine.execution_options(writes=self._wait_seconds).begin() as connection:
            if _revision(connection) is None:  # otherwise another process was faster
                try:
                    create_tables(connection)
                except DatabaseError as error:
                    if "already exists" not in str(error.orig):
                        raise
                    raise self._damaged(f"tables without their revision ({error.orig})") from error
                connection.execute(insert(facts).values(key=_REVISION_KEY, value=str(REVISION)))
        if self.is_file and self._url.database:
            sync_path(Path(self._url.database).parent)

    def _another(self, found: str | int) -> StoreFault:
        """Return the error for a catalogue whose revision is not `REVISION`."""
        if not isinstance(found, int):
            return self._damaged(f"catalogue revision {found!r}, which no version has written")
        if found < REVISION:
            kind: type[StoreFault] = CatalogueDamaged
            advice = (
                "export its studies with `damperlab export` of the older version, or choose another data "
                "directory; if no older version has opened the catalogue, the catalogue is damaged: run `damperlab store "
                "rebuild`"
            )
            told = f"{self.name} was made by a damperlab older than 0.2.0."
        else:
            kind = StoreFault
            advice = (
                "upgrade damperlab, or choose another data directory; if no newer version has opened the catalogue, the "
                "catalogue is damaged: move it away, and make a new one with `damperlab store rebuild`"
            )
            told = (
                f"{self.name} was made by a newer damperlab: it is a catalogue of revision {found}, and this "
                f"version supports {REVISION}."
            )
        return kind(self.name, f"catalogue revision {found}", f"revision {REVISION}", advice, told)

    def _damaged(self, found: str) -> CatalogueDamaged:
        advice = "make it again from the cubes with `damperlab store rebuild`"
        told = f"{self.name} is damaged: {found}."
        return CatalogueDamaged(self.name, found, f"revision {REVISION}", advice, told)

    def _switch_to_wal(self) -> None:
        # repeat the switch to WAL while another process opens the folder, because the switch ignores the busy timeout
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
        except (DBAPIError, sqlite3.Error, *_NOT_OURS) as error:
            cause = error.orig if isinstance(error, DBAPIError) and error.orig is not None else error
            # look at the names of all base classes, because drivers have subclasses for many errors, such as a time-out
            kinds = {kind.__name__ for kind in type(cause).__mro__}
            broken = isinstance(error, DBAPIError) and error.connection_invalidated
            found = str(cause).strip() or type(cause).__name__
            damaged = any(each in found for each in _DAMAGED) or bool(kinds & _LOST)
            damaged |= self.is_file and isinstance(cause, UnicodeDecodeError)
            outside = isinstance(error, _NOT_OURS) or kinds & _TROUBLES
            if not (outside or broken or damaged or "invalid connection option" in found):
                raise
            if "database is locked" in found or "lock timeout" in found:
                raise self._busy(found) from error
            raise (CatalogueDamaged if damaged else StoreFault)(
                self.name,
                found,
                "a catalogue that can be reached, read and written",
                "make the catalogue again from the cubes with `damperlab store rebuild`"
                if damaged
                else "try again in a moment: too many requests came together, or the database is slow"
                if isinstance(error, PoolTimeout)
                else "check that its server runs and its address and password are right"
                if not self.is_file
                else "check the folder's permissions and free space, and that the catalogue is damperlab's",
                f"{self.name} cannot be read or written: {found.splitlines()[0].rstrip('.')}.",
            ) from error

    def _busy(self, found: str) -> StoreFault:
        return StoreFault(
            self.name,
            found,
            f"the write lock of the catalogue within {self._wait_seconds:g} s",
            f"{self._lock_holder()}. Try again in a moment; nothing was lost",
            f"The write lock of {self.name} could not be acquired within {self._wait_seconds:g} s ({found}).",
        )


def _sqlite_engine(url: URL, wait_seconds: float) -> Engine:
    engine = create_engine(url, pool_timeout=_POOL_SECONDS)

    @event.listens_for(engine, "connect")
    def _connect(connection: Any, _: Any) -> None:
        # `_begin` starts transactions, not the driver
        connection.isolation_level = None
        # decode invalid texts with replacements: the row's checksum shows the damage, and other rows stay readable
        connection.text_factory = partial(str, encoding="utf-8", errors="replace")
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute("PRAGMA foreign_keys = ON")

    @event.listens_for(engine, "begin")
    def _begin(connection: Connection) -> None:
        seconds = connection.get_execution_options().get("writes")
        patience = wait_seconds if seconds is None else seconds
        connection.exec_driver_sql(f"PRAGMA busy_timeout = {math.ceil(1000 * patience)}")
        connection.exec_driver_sql("BEGIN" if seconds is None else "BEGIN IMMEDIATE")

    return engine


def _postgresql_engine(url: URL) -> Engine:
    # pool_pre_ping: a connection of the pool is tested before it is used, and replaced if it is broken
    engine = create_engine(url, pool_pre_ping=True, pool_timeout=_POOL_SECONDS, connect_args=_patience(url))

    @event.listens_for(engine, "begin")
    def _begin(connection: Connection) -> None:
        seconds = connection.get_execution_options().get("writes")
        if seconds is not None:
            connection.exec_driver_sql(f"SET LOCAL lock_timeout = {math.ceil(1000 * seconds)}")
            # add the time of the wait for the write lock, because PostgreSQL waits within a statement
            longest = math.ceil(1000 * (seconds + _STATEMENT_SECONDS))
            connection.exec_driver_sql(f"SET LOCAL statement_timeout = {longest}")
            connection.exec_driver_sql(
                f"SET LOCAL idle_in_transaction_session_timeout = {1000 * _IDLE_SECONDS}"
            )
            connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({_WRITERS_LOCK})")
        else:
            connection.exec_driver_sql("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ, READ ONLY")
            connection.exec_driver_sql(f"SET LOCAL statement_timeout = {1000 * _STATEMENT_SECONDS}")

    return engine


def _patience(url: URL) -> dict[str, int]:
    """Return the arguments of a connection to PostgreSQL: the items of `_PATIENCE` that the address does not set."""
    if url.get_backend_name() == "sqlite":
        return {}
    return {name: value for name, value in _PATIENCE.items() if name not in url.query}


def _revision(connection: Connection) -> str | int | None:
    """Return the revision of the tables; None if there are no tables. An invalid revision is returned as a text."""
    # version 0.1.0 stored the revision in SQLite's `user_version`
    first = connection.dialect.name == "sqlite" and connection.exec_driver_sql("PRAGMA user_version").scalar()
    if first or not inspect(connection).has_table(facts.name):
        return int(first) if first else None
    found = connection.execute(select(facts.c.value).where(facts.c.key == _REVISION_KEY)).scalar()
    return int(found) if found and re.fullmatch("[0-9]{1,9}", found) else str(found or "lost")


def open_catalogue(
    data_dir: Path, address: str | None = None, wait_seconds: float = BUSY_SECONDS
) -> Catalogue:
    """Open the catalogue of a data directory. The directory and the catalogue are created if they are missing.

    The address is the URL of a PostgreSQL database; by default the catalogue is a SQLite file in the data directory.

    Raises
    ------
    StoreFault
        If the folder cannot be created or written, or the catalogue cannot be used; see `Catalogue`.
    """
    unusable = StoreFault(
        "data_dir",
        str(data_dir),
        "a folder that can be made and written",
        "name another folder with --data-dir, or change its permissions",
        f"The data directory {data_dir} cannot be made or written.",
    )
    try:
        data_dir.parent.mkdir(parents=True, exist_ok=True)
        # only this user may read a new folder; a folder for several users must be created in advance
        data_dir.mkdir(mode=0o700, exist_ok=True)
        (data_dir / "cubes").mkdir(mode=0o700, exist_ok=True)
        if address is None and not (data_dir / SQLITE_FILE).exists():
            # create the file with restricted permissions, which SQLite also gives to its other files
            for name in (SQLITE_FILE, f"{SQLITE_FILE}{_WRITER}"):
                (data_dir / name).touch(mode=0o600)
    except OSError as error:
        raise unusable from error
    if not os.access(data_dir, os.W_OK | os.X_OK):
        raise unusable
    if address is None:
        return Catalogue(URL.create("sqlite", database=str(data_dir / SQLITE_FILE)), wait_seconds)
    return Catalogue(_postgresql_url(address), wait_seconds)


def _postgresql_url(address: str) -> URL:
    try:
        url = make_url(address)
        if url.get_backend_name() == "postgresql":
            # psycopg is the only supported driver, so replace any other driver that the address names
            url = url.set(drivername="postgresql+psycopg")
            url.get_dialect().import_dbapi()
            return url
        found = f"a database of kind {url.get_backend_name()}"
        advice = "leave it out for a SQLite file in the data directory"
    except (ArgumentError, NoSuchModuleError, ValueError):  # ValueError: the port is not a number
        found, advice = "no address of a database", "write postgresql://user:password@host/database"
    except ImportError:
        found = "an address of PostgreSQL, for which the driver is not installed"
        advice = "install damperlab[postgresql]"
    # the address may contain a password, so the message does not repeat it
    told = f"The catalogue's address must be of the form postgresql://…, and this is {found}."
    raise StoreFault("catalogue", found, "postgresql://…", advice, told)
