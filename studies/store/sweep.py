"""Files that nobody needs: left by killed attempts, interrupted deletes and exports."""

import shutil
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import select

from studies.store.chunks import Marks, chunk_place
from studies.store.cube import block_grid
from studies.store.faults import StudyNotFound
from studies.store.store import Store
from studies.store.tables import studies
from studies.variables import VARIABLES

LEFT_ALONE_SECONDS = 3600.0
"""A file younger than this may belong to an attempt or an export that is under way."""


@dataclass(frozen=True)
class Swept:
    """What was removed, or would be.

    Parameters
    ----------
    paths : int
        Files and folders.
    bytes : int
        Their size.
    """

    paths: int = 0
    bytes: int = 0

    def __add__(self, other: "Swept") -> "Swept":
        """Add up."""
        return Swept(self.paths + other.paths, self.bytes + other.bytes)


def sweep(store: Store, study_id: str, older_than: float = 0.0, *, dry_run: bool = False) -> Swept:
    """Remove the files of a study's cube that no done-mark names.

    Only for who holds the study's claim, or where nobody does: an attempt that is under way is not marked yet.

    Parameters
    ----------
    store : Store
        Where the study is.
    study_id : str
        Its whole id.
    older_than : float
        Younger files stay [s].
    dry_run : bool
        Count alone.

    Raises
    ------
    StudyNotFound
        If there is no such study.
    """
    record = store.find(study_id)
    path, marks = store.snapshot(record.id)
    shape = tuple(record.shape)
    limit = time.time() - older_than
    return _remove(_strays(path, block_grid(shape, record.chunk), marks, limit), dry_run)


def collect_garbage(store: Store, older_than: float = LEFT_ALONE_SECONDS, *, dry_run: bool = False) -> Swept:
    """Remove everything under a data directory that nobody needs.

    That are strays of studies that nobody works on, cubes that no study owns, exports that were cut short, and
    the folders of deleted studies. A study that is not deleted loses nothing.

    Parameters
    ----------
    store : Store
        The store.
    older_than : float
        What changed later than this many seconds ago stays.
    dry_run : bool
        Count alone.

    Returns
    -------
    Swept
        What went.
    """
    limit = time.time() - older_than
    # listed before the catalogue is read: a cube is made before its study is committed
    folders = [path for path in (store.data_dir / "cubes").iterdir() if _changed(path) < limit]
    with store.catalogue.reading() as connection:
        rows = connection.execute(
            select(studies.c.id, studies.c.number, studies.c.deleted, studies.c.claim_expires)
        ).all()
    owned = {store.folder(row.id, row.number) for row in rows if row.deleted is None or row.deleted >= limit}
    unused = [path for path in folders if path not in owned]
    unused += [path for path in store.data_dir.glob("export-*") if _changed(path) < limit]
    swept = _remove(unused, dry_run)
    if not dry_run:
        store.bury(limit)
    for row in rows:
        if row.deleted is None and (row.claim_expires or 0.0) < time.time():
            try:
                swept += sweep(store, row.id, older_than, dry_run=dry_run)
            except StudyNotFound:
                continue  # deleted meanwhile
    return swept


def _strays(path: Path, grid: tuple[int, ...], marks: Marks, limit: float) -> Iterator[Path]:
    for variable in VARIABLES:
        folder = path / variable
        if not folder.is_dir():
            continue
        for file in folder.iterdir():
            if file.name == "zarr.json":
                continue
            name, _, generation = file.name.partition("~")
            place = chunk_place(f"{variable}/{name}", grid)
            if (place is None or marks.get(place[1]) != generation) and _changed(file) < limit:
                yield file


def _changed(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except FileNotFoundError:
        return float("inf")  # gone meanwhile


def _remove(paths: Iterator[Path] | list[Path], dry_run: bool) -> Swept:
    swept = Swept()
    for path in paths:
        size = sum(file.stat().st_size for file in path.rglob("*") if file.is_file()) if path.is_dir() else 0
        try:
            size += path.lstat().st_size
            if not dry_run:
                shutil.rmtree(path) if path.is_dir() else path.unlink()
        except FileNotFoundError:
            continue
        swept += Swept(1, size)
    return swept
