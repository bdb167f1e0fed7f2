"""Files that nobody needs: left by killed attempts, interrupted deletes and exports."""

import math
import socket
import time
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import select

from damperlab.studies.registry import EVERY_VARIABLE
from damperlab.studies.store.chunks import Marks, chunk_place
from damperlab.studies.store.cube import block_grid
from damperlab.studies.store.faults import StudyNotFound, cannot_use
from damperlab.studies.store.folder import Folder
from damperlab.studies.store.rows import ALIVE
from damperlab.studies.store.shelf import Entry, Shelf
from damperlab.studies.store.store import Store
from damperlab.studies.store.tables import studies

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
    StoreFault
        If its files cannot be listed or removed.
    """
    record = store.find(study_id)
    shelf, marks = store.snapshot(record.id)
    grid = block_grid(record.shape, record.chunk)
    swept = Swept()
    try:
        for stray in list(_strays(shelf, grid, marks, _limit(older_than))):
            if not dry_run:
                shelf.remove(stray.key)
            swept += Swept(1, stray.size)
    except OSError as error:
        raise cannot_use(shelf.address, error) from error
    return swept


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
    limit = _limit(older_than)
    try:
        swept = _unowned_cubes(store, limit, dry_run) + _exports(store.data_dir, limit, dry_run)
    except OSError as error:
        raise cannot_use(store.shelf.address, error) from error
    if not dry_run:
        store.bury(limit)
    with store.catalogue.reading() as connection:
        ids = connection.execute(select(studies.c.id).where(ALIVE)).scalars().all()
    for study_id in ids:
        try:
            swept += _sweep_idle(store, study_id, older_than, dry_run)
        except StudyNotFound:
            continue  # deleted meanwhile
    return swept


def _sweep_idle(store: Store, study_id: str, older_than: float, dry_run: bool) -> Swept:
    if not store.abandoned(study_id):
        return Swept()
    found = sweep(store, study_id, older_than, dry_run=True)
    if dry_run or not found.paths:
        return found
    # claimed for as long as it is swept: whoever is at work all the same may mark nothing that goes
    owner = f"gc on {socket.gethostname()}, {uuid.uuid4().hex[:8]}"
    if not store.claim(study_id, owner):
        return Swept()
    try:
        return sweep(store, study_id, older_than)
    finally:
        store.release(study_id, owner)


def _limit(older_than: float) -> float:
    # without an age to compare, no clock counts: a server has its own
    return time.time() - older_than if older_than > 0.0 else math.inf


def _unowned_cubes(store: Store, limit: float, dry_run: bool) -> Swept:
    # a cube is made before its study is committed: listed first, and then the catalogue asked in a turn at writing,
    # which waits for who is about to commit
    names = sorted(store.shelf.shelves())
    with store.catalogue.writing() as connection:
        rows = connection.execute(select(studies.c.id, studies.c.number, studies.c.deleted)).all()
    owned = {
        store.cube_shelf(row.id, row.number).name
        for row in rows
        if row.deleted is None or row.deleted >= limit
    }
    swept = Swept()
    for name in names:
        shelf = store.shelf.at(name)
        entries = [] if name in owned else list(shelf.entries())
        if name not in owned and max((shelf.made(), *(entry.changed for entry in entries))) < limit:
            if not dry_run:
                shelf.clear()
            swept += Swept(1, sum(entry.size for entry in entries))
    return swept


def _exports(data_dir: Path, limit: float, dry_run: bool) -> Swept:
    swept = Swept()
    for path in data_dir.glob("export-*"):
        folder = Folder(path)
        try:
            if path.stat().st_mtime < limit:
                size = sum(entry.size for entry in folder.entries())
                if not dry_run:
                    folder.clear()
                swept += Swept(1, size)
        except FileNotFoundError:
            continue  # ended meanwhile
    return swept


def _strays(shelf: Shelf, grid: tuple[int, ...], marks: Marks, limit: float) -> Iterator[Entry]:
    for entry in shelf.entries():
        variable, slash, name = entry.key.partition("/")
        if slash and (variable not in EVERY_VARIABLE or name == "zarr.json"):
            continue
        if not slash and not variable.endswith(".partial"):
            continue
        file, _, generation = name.partition("~")
        place = chunk_place(f"{variable}/{file}", grid)
        if (place is None or marks.get(place[1]) != generation) and entry.changed < limit:
            yield entry
