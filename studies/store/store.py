"""The class `Store`, which combines the catalogue and the cubes of a data directory."""

import os
import shutil
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

from damperlab.studies.store.catalogue.catalogue import BUSY_SECONDS, SQLITE_FILE, open_catalogue
from damperlab.studies.store.catalogue.home import CUBES, fact, require_catalogue, shelf_of
from damperlab.studies.store.catalogue.quota import Quota
from damperlab.studies.store.faults import cannot_use
from damperlab.studies.store.files.folder import open_shelf
from damperlab.studies.store.life_cycle.claims import Claims
from damperlab.studies.store.life_cycle.deletion import Deletion
from damperlab.studies.store.life_cycle.submissions import Submissions

_COPIES = 10
"""Number of attempts to copy the catalogue of a read-only folder while another process changes it."""
_LOG_HEADER_BYTES = 32


class Store(Submissions, Deletion, Claims):
    """Studies and their cubes in one data directory.

    Several threads may use one `Store`. Several processes may use the same data directory, each with a separate
    `Store`. A forked process must open a new `Store`.
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
            Data directory, which contains the catalogue and the cubes.
        catalogue : str, optional
            Address of a PostgreSQL database for the catalogue; by default it is a SQLite file in the folder.
        cubes : str, optional
            Location of the cubes in an object store, `s3://bucket/prefix`; by default the location that the catalogue
            has stored, else the data directory.
        quota : Quota
            Limits on the size and the number of studies.
        wait_seconds : float
            Longest time that a change waits for the write lock of the catalogue.

        Raises
        ------
        StoreFault
            If the folder or the location of the cubes cannot be used, if a newer version of damperlab made the
            catalogue, or if the cubes belong to another catalogue.
        """
        data_dir = Path(data_dir).expanduser().absolute()
        holds_catalogue = (data_dir / SQLITE_FILE).is_file()
        read_only = holds_catalogue and not os.access(data_dir, os.W_OK | os.X_OK)
        if catalogue is None and cubes is None and read_only:
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
        """Open a copy of the catalogue of a read-only folder, because the original cannot be locked."""
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
        """Close the connections to the catalogue, and remove the copy of a read-only catalogue."""
        super().close()
        if self._copy is not None:
            self._copy.cleanup()


def _written(data_dir: Path) -> tuple[int, bytes]:
    """Return the time of the last change of the SQLite file, and the header of the write-ahead log."""
    log = data_dir / f"{SQLITE_FILE}-wal"
    with log.open("rb") if log.exists() else BytesIO() as file:
        return (data_dir / SQLITE_FILE).stat().st_mtime_ns, file.read(_LOG_HEADER_BYTES)
