"""Removal of files that interrupted computations, deletions, submissions and exports have left.

A block's file is removed if the block's done-mark names another file. A cube is removed if its study was deleted. A
cube that has neither a study nor results is removed after `ORPHAN_SECONDS`. All other files are listed and kept.
"""

import math
import socket
import time
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy import Row, select, update

from damperlab.studies.design.shelf import Shelf as Designs
from damperlab.studies.store.catalogue.home import is_of_block, parse_cube_name
from damperlab.studies.store.catalogue.rows import ALIVE, NEVER_ENTERED, last_number, pieces, study_row
from damperlab.studies.store.catalogue.rowsum import is_sound
from damperlab.studies.store.catalogue.tables import done_blocks, studies
from damperlab.studies.store.cube.block_file import Marks, block_key, parse_block_key
from damperlab.studies.store.cube.description import DESCRIPTION, describe_cube
from damperlab.studies.store.faults import StoreFault, StudyNotFound, using
from damperlab.studies.store.files.folder import Folder
from damperlab.studies.store.files.shelf import Entry, Shelf
from damperlab.studies.store.store import Store

LEFT_ALONE_SECONDS = 3600.0
"""Age below which a file is kept [s], because a running computation or export may need the file."""

ORPHAN_SECONDS = 7 * 86_400.0
"""Age below which a cube without a study is kept [s], so that `rebuild` can still add a lost study."""


@dataclass(frozen=True)
class Swept:
    """Files that were removed; after a dry run, files that would be removed.

    Parameters
    ----------
    bytes : int
        Total size of the removed files.
    what : tuple of str
        A text for each removed file or folder, with the reason.
    unknown : tuple of str
        A text for each file or folder that was kept because its use is unknown.
    """

    bytes: int = 0
    what: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()

    @property
    def paths(self) -> int:
        """Number of removed files and folders."""
        return len(self.what)

    def __add__(self, other: "Swept") -> "Swept":
        """Combine the results of two sweeps."""
        return Swept(self.bytes + other.bytes, self.what + other.what, self.unknown + other.unknown)


def sweep(store: Store, study_id: str, older_than: float = 0.0, *, dry_run: bool = False) -> Swept:
    """Remove incomplete and superseded files of a study's blocks. The done-mark of a block names the valid file.

    If the study has a claim, only the owner of the claim may call this function. Files that were written less than
    `older_than` seconds ago are kept. A dry run reports the files without removing them.

    Raises
    ------
    StudyNotFound
        If there is no such study.
    StoreFault
        If the files cannot be listed or removed.
    """
    record = store.find(study_id)
    shelf, marks = store.snapshot(record.id)
    swept = Swept()
    with using(shelf.address):
        strays = list(_strays(shelf, marks, _limit(older_than)))
        # if the row of a done-mark is damaged, its generation may be wrong, so the files of the block are kept
        doubted = _damaged_marks(store, record.id, {block for _, block in strays if block is not None})
        for stray in (entry for entry, block in strays if block not in doubted):
            if not dry_run:
                shelf.remove(stray.key)
            what = f"remove {shelf.name}/{stray.key}: superseded, or half written"
            swept += Swept(stray.size, (what,))
    return swept


def collect_garbage(
    store: Store,
    older_than: float = LEFT_ALONE_SECONDS,
    *,
    orphan_seconds: float = ORPHAN_SECONDS,
    dry_run: bool = False,
) -> Swept:
    """Remove all unused files of a store. No valid file of an existing study is removed.

    Unused files are superseded files of studies without a claim, cubes of deleted studies, and interrupted exports. A
    cube without results is unused, too, if it has had no study for `orphan_seconds`. Files that were written less than
    `older_than` seconds ago are kept. A dry run reports the files without removing them.

    Returns
    -------
    Swept
        The removed files, and the files that were kept because their use is unknown.
    """
    limit = _limit(older_than)
    with using(store.shelf.address):
        swept = _unowned_cubes(store, limit, _limit(orphan_seconds), dry_run)
        swept += remove_exports(store.data_dir, older_than, dry_run=dry_run)
    if not dry_run:
        store.bury(_passed(limit))
        Designs(store.data_dir).bury()
    with store.catalogue.reading() as connection:
        ids = connection.execute(select(studies.c.id).where(ALIVE)).scalars().all()
    for study_id in ids:
        try:
            swept += _sweep_idle(store, study_id, older_than, dry_run)
        except StudyNotFound:
            continue  # the study was deleted meanwhile
    return swept


def _sweep_idle(store: Store, study_id: str, older_than: float, dry_run: bool) -> Swept:
    if not store.abandoned(study_id):
        return Swept()
    found = sweep(store, study_id, older_than, dry_run=True)
    if dry_run or not found.paths:
        return found
    # claim the study during the sweep, so that no worker marks a file that is being removed
    owner = f"gc on {socket.gethostname()}, {uuid.uuid4().hex[:8]}"
    if not store.claim(study_id, owner):
        return Swept()
    try:
        return sweep(store, study_id, older_than)
    finally:
        store.release(study_id, owner)


def _limit(older_than: float) -> float:
    # for an age of 0, set no limit: the clock of a server may be ahead, so that a file seems newer than now
    return time.time() - older_than if older_than > 0.0 else math.inf


def _passed(limit: float) -> float:
    """Return the time before which a study must have left the trash for its cube to be removed. This time is never
    later than now.
    """
    return min(limit, time.time())


def _unowned_cubes(store: Store, limit: float, orphan_limit: float, dry_run: bool) -> Swept:
    # list the cubes before reading the catalogue: a submission reserves a number before it creates the cube
    names = sorted(store.shelf.shelves())
    with store.catalogue.reading() as connection:
        columns = studies.c.id, studies.c.number, studies.c.deleted, NEVER_ENTERED.label("reserved")
        rows = connection.execute(select(*columns)).all()
        last = last_number(connection)
    known = {row.number: row for row in rows}
    alive = {row.id for row in rows if row.deleted is None}
    swept = Swept()
    for name in names:
        parsed = parse_cube_name(name)
        row = known.get(parsed[1]) if parsed else None
        if parsed and row is not None:
            before = limit if row.id == parsed[0] else orphan_limit
            swept += _unowned_cube(store, name, row, before, dry_run, has_study=parsed[0] in alive)
        elif parsed and parsed[1] > last:
            swept += _left(store, name, "the catalogue has never assigned its number")
        else:
            swept += _left(store, name, "its number is unknown")
    return swept


def _unowned_cube(
    store: Store, name: str, row: Row[Any], before: float, dry_run: bool, *, has_study: bool
) -> Swept:
    """Remove a cube that has no study and was last changed before the time `before`.

    `row` is the catalogue's row with the serial number of the cube. `has_study` is true if the catalogue has the study
    under any serial number.
    """
    study_id = name.rpartition("-")[0]
    deleted = row.id == study_id
    if (deleted or row.reserved) and (row.deleted is None or row.deleted >= _passed(before)):
        return Swept()
    if not _row_is_sound(store, row.number):
        return _left(
            store, name, "its row in the catalogue is damaged; `damperlab store rebuild` makes it again"
        )
    shelf = store.shelf.at(name)
    entries = list(shelf.entries())
    if not entries and not shelf.made():
        return Swept()  # an empty prefix, which a server may still list
    if not deleted and any(map(is_of_block, entries)):
        owner = f"study {row.id}" if row.id else "no study"
        return _left(store, name, f"it holds results, and its number belongs to {owner}")
    if not (deleted or row.reserved or has_study) and _describes(shelf, study_id):
        return _left(store, name, "the catalogue has lost its study; `damperlab store rebuild` adds it")
    if max((shelf.made(), *(entry.changed for entry in entries))) >= before:
        return Swept()
    if row.reserved and not dry_run and not _take_back(store, row.number):
        return Swept()  # the study was entered meanwhile
    if not dry_run:
        shelf.clear()
    why = (
        "its study was deleted"
        if deleted
        else "its study was never entered"
        if row.reserved
        else f"its number belongs to study {row.id}, and it holds no result"
    )
    return Swept(sum(entry.size for entry in entries), (f"remove {name}: {why}",))


def _left(store: Store, name: str, why: str) -> Swept:
    return Swept(unknown=(f"{store.shelf.address}/{name}: {why}",))


def _describes(shelf: Shelf, study_id: str) -> bool:
    """Whether a cube contains the definition of the study, so that `rebuild` can enter the study again."""
    try:
        return describe_cube(shelf.get(DESCRIPTION)).digest[:12] == study_id.partition("-")[0]
    except (FileNotFoundError, StoreFault, ValueError):
        return False


def _take_back(store: Store, number: int) -> bool:
    """Withdraw a reserved serial number. Return False if a study already has this serial number."""
    change = update(studies).where(studies.c.number == number, NEVER_ENTERED).values(state="cancelled")
    with store.catalogue.writing() as connection:
        return connection.execute(change).rowcount == 1


def _row_is_sound(store: Store, number: int) -> bool:
    with store.catalogue.reading() as connection:
        row = connection.execute(select(studies).where(studies.c.number == number)).one_or_none()
    return row is not None and is_sound(studies, row)


def remove_exports(data_dir: Path, older_than: float = LEFT_ALONE_SECONDS, *, dry_run: bool = False) -> Swept:
    """Remove folders of interrupted exports that were last changed more than `older_than` seconds ago."""
    swept = Swept()
    for folder in (Folder(path) for path in data_dir.glob("export-*/")):
        if folder.made() < _limit(older_than):
            size = sum(entry.size for entry in folder.entries())
            if not dry_run:
                folder.clear()
            swept += Swept(size, (f"remove {folder.name}: an export that was cut short",))
    return swept


def _damaged_marks(store: Store, study_id: str, blocks: set[int]) -> set[int]:
    """Return the blocks whose done-marks in the catalogue are damaged."""
    found: set[int] = set()
    with store.catalogue.reading() as connection:
        number = study_row(connection, study_id).number
        for some in pieces(sorted(blocks)):
            place = done_blocks.c.block.in_(some)
            rows = connection.execute(select(done_blocks).where(done_blocks.c.study == number, place)).all()
            found |= {row.block for row in rows if not is_sound(done_blocks, row)}
    return found


def _strays(shelf: Shelf, marks: Marks, limit: float) -> Iterator[tuple[Entry, int | None]]:
    """Yield each unused file of a cube, and the index of its block if the file is superseded, else None.

    A file is superseded if the done-mark of its block names another file that exists. If the named file does
    not exist, the catalogue may be an older copy, so the other files of the block are not superseded.
    """
    entries = list(shelf.entries())
    there = {entry.key for entry in entries}
    for entry in entries:
        block = parse_block_key(entry.key)
        named = marks.get(block[0]) if block else None
        superseded = (
            block is not None
            and named is not None
            and named != block[1]
            and block_key(block[0], named) in there
        )
        if (entry.key.endswith(".partial") or superseded) and entry.changed < limit:
            yield entry, block[0] if superseded and block else None
