"""Access to the cubes of a store, and the check of the free space on the disk."""

import os
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from sqlalchemy import Row

from damperlab.studies.store.catalogue.catalogue import Catalogue
from damperlab.studies.store.catalogue.home import cube_name, disk_gone
from damperlab.studies.store.catalogue.quota import Quota, Usage, usage_of
from damperlab.studies.store.catalogue.rows import lost_marks, marks_of, study_row
from damperlab.studies.store.cube.block_file import Marks, block_key
from damperlab.studies.store.faults import BlockDamaged, RevisionGone, catalogue_damaged, using
from damperlab.studies.store.files.shelf import Shelf

if TYPE_CHECKING:
    import xarray as xr

RESERVE_BYTES = 16 * 2**20
"""Number of free bytes that the disk must have before a block is started."""

RESERVE_FILES = 64
"""Number of free inodes that the disk must have before a block is started."""

TRIES = 5
"""Largest number of attempts to read a study while its blocks are invalidated."""

Result = TypeVar("Result")

_MARKS_KEPT = 16  # number of studies whose marks are cached


class Cubes:
    """The catalogue and the cubes of a data directory. This is the base class of all parts of a store.

    Parameters
    ----------
    data_dir : Path
        The data directory; see `Store.open`.
    catalogue : Catalogue
        Catalogue of the store.
    shelf : Shelf
        Storage location of the cubes.
    quota : Quota
        Quota of all studies.
    """

    def __init__(self, data_dir: Path, catalogue: Catalogue, shelf: Shelf, quota: Quota) -> None:
        self.data_dir = data_dir
        self.catalogue = catalogue
        self.shelf = shelf
        self.quota = quota
        self._marks: dict[int, tuple[int, Marks]] = {}
        self._marks_lock = threading.Lock()
        # for every claimed study: the latest renewal, and the monotonic time when this process first saw the renewal
        self._renewals: dict[int, tuple[tuple[str, float], float]] = {}

    def close(self) -> None:
        """Close the connections to the catalogue."""
        self.catalogue.close()

    def cube_shelf(self, study_id: str, number: int) -> Shelf:
        """Return the storage location of a study's cube, given the id and the number of the study."""
        return self.shelf.at(cube_name(study_id, number))

    def find_cube(self, study_id: str) -> Shelf:
        """Return the storage location of a study's cube; raise `StudyNotFound` if there is no such study."""
        with self.catalogue.reading() as connection:
            return self.cube_shelf(study_id, study_row(connection, study_id).number)

    def cube_path(self, study_id: str) -> str:
        """Return the address with which a worker can open a study's cube."""
        return self.find_cube(study_id).address

    def cube(self, study_id: str) -> "xr.Dataset":
        """Open a study's cube lazily. Points of blocks that are not done yet are shown as not computed.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        StoreFault
            If done-marks are missing, or the description or a coordinate is lost, damaged or unreadable.
        """
        # imported here, because importing xarray takes half of a command's start-up time
        from damperlab.studies.store.cube.opened import open_cube

        row, shelf, marks = self._snapshot(study_id)
        # the study may have been renamed after the description of the cube was written
        return open_cube(shelf, marks).assign_attrs(title=row.name)

    def snapshot(self, study_id: str, revision: int | None = None) -> tuple[Shelf, Marks]:
        """Return the storage location of a cube, and the generation of every block that was done at a revision.

        By default, the current revision is used.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        RevisionGone
            If the revision never existed, or blocks have been invalidated since this revision.
        CatalogueDamaged
            If done-marks are missing.
        """
        _, shelf, marks = self._snapshot(study_id, revision)
        return shelf, marks

    def _snapshot(self, study_id: str, revision: int | None = None) -> tuple[Row[Any], Shelf, Marks]:
        with self.catalogue.reading() as connection:
            row = study_row(connection, study_id)
            shelf = self.cube_shelf(study_id, row.number)
            if revision is not None and not row.taken_back <= revision <= row.revision:
                raise RevisionGone(
                    "revision",
                    str(revision),
                    f"{row.taken_back} to {row.revision}",
                    "open the study again",
                    f"Revision {revision} is no longer available: some blocks of the study were computed again since.",
                )
            if revision is not None and revision != row.revision:
                return row, shelf, marks_of(connection, row, upto=revision)
            kept = self._marks.get(row.number)
            if kept is None or kept[0] != row.revision:
                if kept is not None and kept[0] >= row.taken_back:
                    newer = marks_of(connection, row, after=kept[0])
                    kept = row.revision, {**kept[1], **newer}
                else:
                    kept = row.revision, marks_of(connection, row)
                with self._marks_lock:
                    self._marks[row.number] = kept
                    while len(self._marks) > _MARKS_KEPT:
                        del self._marks[next(iter(self._marks))]
            lost = lost_marks(row, len(kept[1]))
            if lost is not None:
                with self._marks_lock:
                    self._marks.pop(row.number, None)
                raise catalogue_damaged(study_id, lost)
        return row, shelf, kept[1]

    def steadily(self, study_ids: Sequence[str], read: Callable[[], Result]) -> Result:
        """Call a function that reads studies. If blocks of these studies are invalidated meanwhile, call it again.

        The files of invalidated blocks are removed when the blocks are done again, so a reader may miss a file.

        Raises
        ------
        StudyNotFound
            If a study does not exist, or was deleted meanwhile.
        BlockDamaged
            If the function raises this error, and no block was invalidated.
        """
        for _ in range(TRIES - 1):
            before = [self._invalidated(each) for each in study_ids]
            try:
                return read()
            except BlockDamaged:
                if [self._invalidated(each) for each in study_ids] == before:
                    raise
        return read()

    def _invalidated(self, study_id: str) -> tuple[int, int]:
        """Return the number of a study, and the revision at which its blocks were last invalidated."""
        with self.catalogue.reading() as connection:
            row = study_row(connection, study_id)
        return row.number, row.taken_back

    def lost_blocks(self, study_id: str) -> list[int]:
        """Return the indices of the blocks that have a done-mark but no file, ascending. No file is read.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        StoreFault
            If done-marks are missing, or the files cannot be listed.
        """
        shelf, marks = self.snapshot(study_id)
        if not marks:
            return []
        with using(shelf.address):
            there = {entry.key for entry in shelf.entries() if entry.size}
        return sorted(
            index for index, generation in marks.items() if block_key(index, generation) not in there
        )

    def trouble(self) -> str | None:
        """Return the reason why results cannot be written, for example a full disk; None if results can be written.

        A disk with less free space than `RESERVE_BYTES` is reported as full.
        """
        gone = disk_gone(self.shelf)
        if gone is not None:
            return gone
        for place in dict.fromkeys((self.data_dir, self.data_dir / "cubes")):
            try:
                room = os.statvfs(place)
            except OSError as error:
                return f"{place} cannot be used ({error})"
            if not os.access(place, os.W_OK | os.X_OK):
                return f"{place} cannot be written; change its permissions, or how its disk is mounted"
            free = room.f_bavail * room.f_frsize
            if free < RESERVE_BYTES:
                return (
                    f"the disk of {place} is full: {free / 1e6:.3g} MB are free, "
                    f"{RESERVE_BYTES / 1e6:.3g} MB are kept for the catalogue; make room"
                )
            if room.f_files and room.f_favail < RESERVE_FILES:  # some file systems report no inodes
                return f"the disk of {place} is full: room for {room.f_favail} more files; remove some"
        return None

    def usage(self) -> Usage:
        """Return the number of points and bytes of all studies, as the quota counts them."""
        with self.catalogue.reading() as connection:
            return usage_of(connection)
