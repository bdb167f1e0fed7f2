"""The store: the catalogue and the cubes of one data directory, as one object."""

import os
import shutil
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

from damperlab.studies.store.catalogue.catalogue import BUSY_SECONDS, SQLITE_FILE, open_catalogue
from damperlab.studies.store.catalogue.home import CUBES, fact, require_catalogue, shelf_of
from damperlab.studies.store.catalogue.quota import Quota
from damperlab.studies.store.cubes import Cubes
from damperlab.studies.store.faults import cannot_use
from damperlab.studies.store.files.folder import open_shelf
from damperlab.studies.store.life_cycle.remarking import Remarking
from damperlab.studies.store.life_cycle.small_studies import SmallBatches
from damperlab.studies.store.life_cycle.submissions import Submissions

_COPIES = 10
"""Attempts to copy the catalogue of a read-only folder while another process writes it."""
_LOG_HEADER_BYTES = 32


class Store(Submissions, Remarking, SmallBatches, Cubes):
    """Studies and their cubes under one data directory.

    Usable from several threads and, with one `Store` each, from several processes. Do not use a `Store` in
    a process that was forked after it was opened.
    """

    _copy: TemporaryDirectory[str] | None = None

    @classmethod
    def open(
        cls,
        data_dir: Path,
        catalogue: str | None = None,
        cubes: str | None = None,
        quota: Quota = Quota(),  # noqa: B008  (it is frozen)
        *,
        wait_seconds: float = BUSY_SECONDS,
    ) -> "Store":
        """Open a data directory, creating it if it is missing.

        Parameters
        ----------
        data_dir : Path
            Folder of the catalogue and the cubes.
        catalogue : str, optional
            Address of a PostgreSQL database for the catalogue; by default it is a SQLite file in the folder.
        cubes : str, optional
            Location of the cubes in an object store, `s3://bucket/prefix`; by default the previous location, which is
            at first the folder.
        quota : Quota
            Limits of the space that studies may take.
        wait_seconds : float
            Longest wait of a change for the write lock of the catalogue.

        Raises
        ------
        StoreFault
            If the folder or the location cannot be used, a newer version made it, or the cubes there belong to
            another catalogue.
        """
        data_dir = Path(data_dir).expanduser().absolute()
        if catalogue is None and cubes is None and is_read_only(data_dir):
            return cls._open_read_only(data_dir, quota)
        if catalogue is None:
            require_catalogue(data_dir)
        opened = open_catalogue(data_dir, catalogue, wait_seconds)
        try:
            shelf = shelf_of(opened, data_dir, cubes)
        except BaseException:
            opened.close()
            raise
        return cls(data_dir, opened, shelf, quota)

    @classmethod
    def _open_read_only(cls, data_dir: Path, quota: Quota) -> "Store":
        """Open a read-only folder through a copy of its catalogue: a database on such a disk cannot be locked."""
        copy = TemporaryDirectory(prefix="damperlab-")
        try:
            for _ in range(_COPIES):
                before = _written(data_dir)
                for suffix in ("", "-wal"):  # the latest changes may be only in SQLite's log
                    file = data_dir / f"{SQLITE_FILE}{suffix}"
                    if file.exists():
                        shutil.copyfile(file, Path(copy.name, file.name))
                # another process with write access may have moved pages from the log into the file meanwhile
                if _written(data_dir) == before:
                    break
            else:
                raise OSError(f"it was written during each of {_COPIES} attempts to copy it")
            opened = open_catalogue(Path(copy.name))
        except OSError as error:
            copy.cleanup()
            raise cannot_use(str(data_dir), error) from error
        except BaseException:
            copy.cleanup()
            raise
        with opened.reading() as connection:
            address = fact(connection, "cubes")
        shelf = open_shelf(f"{address}/{CUBES}" if address else str(data_dir / CUBES))
        store = cls(data_dir, opened, shelf, quota)
        opened.read_only = True
        store._copy = copy
        return store

    def close(self) -> None:
        """Close the catalogue's connections."""
        super().close()
        if self._copy is not None:
            self._copy.cleanup()


def is_read_only(data_dir: Path) -> bool:
    """Whether a folder holds a catalogue and is read-only."""
    return (data_dir / SQLITE_FILE).is_file() and not os.access(data_dir, os.W_OK | os.X_OK)


def _written(data_dir: Path) -> tuple[int, bytes]:
    """Give the time when a SQLite catalogue was last written, and the start of its log, which changes when pages move
    from the log into the file.
    """
    log = data_dir / f"{SQLITE_FILE}-wal"
    with log.open("rb") if log.exists() else BytesIO() as file:
        return (data_dir / SQLITE_FILE).stat().st_mtime_ns, file.read(_LOG_HEADER_BYTES)
