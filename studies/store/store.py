"""The store: the catalogue and the cubes of one data directory, behind one door."""

import json
import math
import shutil
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from sqlalchemy import Connection, Row, delete, func, insert, select, update

from studies.definition import Study
from studies.digest import family_digest
from studies.faults import Fault, describe, listing
from studies.plan import Plan
from studies.store.catalogue import Catalogue, open_catalogue
from studies.store.chunks import Marks
from studies.store.cube import block_grid, create_cube, open_cube
from studies.store.faults import KeyTaken, RevisionGone, StoreFault, StudyBusy, StudyNotFound
from studies.store.record import STATES, BlockOutcome, Page, Record
from studies.store.rows import (
    ALIVE,
    alive_row,
    claim_owner,
    cursor_of,
    marks_of,
    number_before,
    record_of,
    study_row,
    unknown_study,
)
from studies.store.tables import done_blocks, events, keys, studies

CLAIM_SECONDS = 60.0
"""How long a claim holds without being renewed [s]."""

PAGE_LIMIT = 1000
"""Most records on one page."""

RESERVE_BYTES = 16 * 2**20
"""Room on the disk that no block is begun without."""

_AT_ONCE = 500  # values in one statement
_MARKS_KEPT = 16  # studies whose marks are remembered


class Store:
    """Studies and their cubes under one data directory.

    Safe to use from several threads and, through one `Store` each, from several processes. Do not carry one
    across a fork.

    Parameters
    ----------
    data_dir : Path
        The data directory; see `Store.open`.
    catalogue : Catalogue
        Its catalogue.
    """

    def __init__(self, data_dir: Path, catalogue: Catalogue) -> None:
        self.data_dir = data_dir
        self.catalogue = catalogue
        self._marks: dict[int, tuple[int, Marks]] = {}

    @classmethod
    def open(cls, data_dir: Path, catalogue: str | None = None) -> "Store":
        """Open a data directory, making it where it is missing; what an interrupted delete left is removed.

        Parameters
        ----------
        data_dir : Path
            Folder of the cubes.
        catalogue : str, optional
            Address of a PostgreSQL database for the catalogue; by default it is a SQLite file in the folder.

        Raises
        ------
        StoreFault
            If the folder cannot be used, or a newer version made it.
        """
        data_dir = Path(data_dir).expanduser().absolute()
        store = cls(data_dir, open_catalogue(data_dir, catalogue))
        store.bury()
        return store

    def close(self) -> None:
        """Close the catalogue's connections."""
        self.catalogue.close()

    # studies

    def submit(
        self,
        study: Study,
        plan: Plan,
        provenance: dict[str, str],
        *,
        reuse: bool = True,
        key: str | None = None,
    ) -> tuple[Record, bool]:
        """Keep a study and make its empty cube, unless the same definition is there already.

        Parameters
        ----------
        study, plan : Study, Plan
            What is asked, and how its grid is cut.
        provenance : dict of str
            See `studies.store.provenance.provenance`.
        reuse : bool
            Whether points that earlier studies hold may be taken from them.
        key : str, optional
            A name that the caller gave this submission; it stands for this definition from now on.

        Returns
        -------
        record : Record
            The study's record, new or found.
        created : bool
            Whether it is new. Of any number of processes that submit one definition at once, one makes it.

        Raises
        ------
        StoreFault
            If the cube cannot be written.
        KeyTaken
            If the key was given to another definition before.
        """
        if plan.count != math.prod(block_grid(study.shape, plan.chunk)):
            raise ValueError(f"a plan of {plan.count} blocks does not cut {study.shape} by {plan.chunk}")
        study_id = study.digest[:12]
        # seen without a turn at writing first: the same study is asked for again and again
        if key is None:
            with self.catalogue.reading() as connection:
                row = alive_row(connection, study_id)
            if row is not None:
                return record_of(row), False
        with self.catalogue.writing() as connection:
            if key is not None:
                _take_key(connection, key, study.digest)
            row = alive_row(connection, study_id)
            if row is not None:
                return record_of(row), False
            number = connection.execute(
                insert(studies).values(
                    id=study_id,
                    digest=study.digest,
                    name=study.name,
                    state="queued",
                    definition=json.dumps(study.document()),
                    provenance=json.dumps(provenance),
                    shape=json.dumps(study.shape),
                    chunk=json.dumps(plan.chunk),
                    points_total=study.points,
                    blocks_total=plan.count,
                    family=family_digest(study, provenance),
                    reuse=reuse,
                    created=time.time(),
                )
            ).inserted_primary_key[0]  # type: ignore[index]
            path = self.folder(study_id, number)
            try:
                # made before the commit: who sees the study finds its cube
                create_cube(path, study, plan.chunk, provenance)
            except BaseException as error:
                shutil.rmtree(path, ignore_errors=True)
                if isinstance(error, OSError):
                    raise self._disk_fault(path, error) from error
                raise
            _log(connection, study_id, "submitted")
            return record_of(study_row(connection, study_id)), True

    def find(self, ref: str) -> Record:
        """Look a study up by its id, a prefix of it that no other id has, or its name (the newest so named).

        Raises
        ------
        StudyNotFound
            If none is found, or a prefix fits several.
        """
        # no database takes half characters, and one no NUL; a command line or an address may hold them
        ref = _sayable(ref)
        with self.catalogue.reading() as connection:
            row = alive_row(connection, ref)
            if row is not None:
                return record_of(row)
            newest = select(studies).where(ALIVE).order_by(studies.c.number.desc())
            starts = func.substr(studies.c.id, 1, len(ref)) == ref.lower()
            fits = connection.execute(newest.where(starts).limit(4)).all() if ref else []
            if len(fits) == 1:
                return record_of(fits[0])
            named = connection.execute(newest.where(studies.c.name == ref).limit(1)).one_or_none()
            if named is not None:
                return record_of(named)
            if fits:
                several = ", ".join(f"{row.id} ({row.name})" for row in fits[:3])
                raise StudyNotFound(
                    Fault(
                        "study",
                        describe(ref),
                        f"one study; this fits {several}",
                        "write more digits of the id",
                    )
                )
            raise unknown_study(connection, ref)

    def page(
        self,
        limit: int = 50,
        cursor: str | None = None,
        state: str | None = None,
        name: str | None = None,
    ) -> Page:
        """Give one page of records, newest first.

        Parameters
        ----------
        limit : int
            Most records on the page, 1 to `PAGE_LIMIT`.
        cursor : str, optional
            The cursor of the page before. Studies that come meanwhile do not shift the pages.
        state : str, optional
            Only studies in this state.
        name : str, optional
            Only studies whose name holds this text; ASCII letters fit in either case.

        Raises
        ------
        StoreFault
            If an argument is not allowed.
        """
        if not 1 <= limit <= PAGE_LIMIT:
            raise StoreFault(Fault("limit", str(limit), f"1 to {PAGE_LIMIT}", "ask page by page"))
        if state is not None and state not in STATES:
            raise StoreFault(Fault("state", describe(state), listing(STATES), "leave it out for every state"))
        query = select(studies).where(ALIVE)
        if cursor is not None:
            query = query.where(studies.c.number < number_before(cursor))
        if state is not None:
            query = query.where(studies.c.state == state)
        if name:
            query = query.where(studies.c.name.icontains(_sayable(name), autoescape=True))
        query = query.order_by(studies.c.number.desc()).limit(limit + 1)
        with self.catalogue.reading() as connection:
            rows = connection.execute(query).all()
        more = len(rows) > limit
        return Page(tuple(map(record_of, rows[:limit])), cursor_of(rows[limit - 1].number) if more else None)

    def set_state(
        self,
        study_id: str,
        state: str,
        message: str | None = None,
        *,
        only_from: tuple[str, ...] = STATES,
    ) -> Record:
        """Put a study into a state.

        Parameters
        ----------
        study_id : str
            The whole id.
        state : str
            One of `STATES`.
        message : str, optional
            Kept with the study; None keeps the one that is there, an empty one removes it.
        only_from : tuple of str
            Nothing changes unless the study is in one of these states; the record that comes back says
            which it is in.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        """
        if state not in STATES:
            raise ValueError(f"{state!r} is none of {STATES}")
        now = time.time()
        with self.catalogue.writing() as connection:
            row = study_row(connection, study_id)
            if row.state not in only_from:
                return record_of(row)
            change: dict[str, Any] = {"state": state}
            if message is not None:
                change["message"] = message or None
            if state == "running":
                change |= {"started": row.started or now, "finished": None}
                change |= {"run_began": now, "run_points": row.points_done, "last_mark": None}
            elif state == "queued":
                change["finished"] = None
            elif row.state != state:
                change["finished"] = now
            connection.execute(update(studies).where(studies.c.number == row.number).values(change))
            if row.state != state:
                _log(connection, study_id, f"{row.state} to {state}" + (f": {message}" if message else ""))
            return record_of(study_row(connection, study_id))

    def events(self, study_id: str) -> list[tuple[float, str]]:
        """Give what has happened to a study, oldest first: seconds since 1970, and what."""
        query = select(events.c.at, events.c.what).where(events.c.study == study_id).order_by(events.c.number)
        with self.catalogue.reading() as connection:
            return [(at, what) for at, what in connection.execute(query)]

    def delete(self, study_id: str) -> None:
        """Forget a study and remove its cube.

        The study is gone once its tombstone is committed; should the process die then, the next `open`
        removes the files.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        StudyBusy
            If somebody works on it and it was not cancelled.
        """
        with self.catalogue.writing() as connection:
            row = study_row(connection, study_id)
            if row.state != "cancelled":
                _require_free(row, "delete")
            connection.execute(
                update(studies).where(studies.c.number == row.number).values(deleted=time.time())
            )
            _log(connection, study_id, "deleted")
        self.bury()

    # blocks

    def pending(self, study_id: str) -> np.ndarray:
        """Give the indices of the blocks without a done-mark, ascending, int64."""
        with self.catalogue.reading() as connection:
            row = study_row(connection, study_id)
            done = np.zeros(row.blocks_total, bool)
            done[np.fromiter(marks_of(connection, row.number), np.int64)] = True
            return np.flatnonzero(~done)

    def mark(self, study_id: str, outcome: BlockOutcome) -> None:
        """Set the done-mark of a block whose region is on the disk; a block that has one keeps its first.

        With this transaction every reader that looks from now on sees the block, whole and in this generation.

        Raises
        ------
        StudyNotFound
            If the study is gone.
        """
        now = time.time()
        with self.catalogue.writing() as connection:
            row = study_row(connection, study_id)
            if not 0 <= outcome.index < row.blocks_total:
                raise ValueError(f"block {outcome.index} of {row.blocks_total}")
            here = (done_blocks.c.study == row.number) & (done_blocks.c.block == outcome.index)
            if connection.execute(select(done_blocks.c.block).where(here)).first() is not None:
                return
            values = {
                "study": row.number,
                "block": outcome.index,
                "points": outcome.points,
                "failed": outcome.failed,
                "reused": outcome.reused,
                "seconds": outcome.seconds,
                "kernel_seconds": outcome.kernel_seconds,
                "message": outcome.message,
                "at": now,
                "generation": outcome.generation,
                "checksum": outcome.checksum,
                "revision": row.revision + 1,
            }
            connection.execute(insert(done_blocks).values(values))
            c = studies.c
            change: dict[Any, Any] = {
                c.points_done: c.points_done + outcome.points,
                c.points_failed: c.points_failed + outcome.failed,
                c.points_reused: c.points_reused + outcome.reused,
                c.blocks_done: c.blocks_done + 1,
                c.seconds: c.seconds + outcome.seconds,
                c.kernel_seconds: c.kernel_seconds + outcome.kernel_seconds,
                c.revision: c.revision + 1,
                c.last_mark: now,
            }
            if outcome.message is not None:
                change[c.message] = func.coalesce(c.message, f"block {outcome.index}: {outcome.message}")
            connection.execute(update(studies).where(c.number == row.number).values(change))

    def forget(self, study_id: str, blocks: Sequence[int], why: str) -> Record:
        """Take done-marks back, all in one transaction: the blocks read as not computed and can be run again.

        Parameters
        ----------
        study_id : str
            The whole id.
        blocks : sequence of int
            Indices of blocks; those without a mark count for nothing.
        why : str
            Kept among the study's events.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        StudyBusy
            If somebody works on it.
        """
        b, c = done_blocks.c, studies.c
        with self.catalogue.writing() as connection:
            row = study_row(connection, study_id)
            _require_free(row, "take blocks back from")
            for start in range(0, len(blocks), _AT_ONCE):
                piece = [int(index) for index in blocks[start : start + _AT_ONCE]]
                connection.execute(delete(done_blocks).where(b.study == row.number, b.block.in_(piece)))
            sums = connection.execute(
                select(
                    func.count(),
                    *(
                        func.coalesce(func.sum(column), 0)
                        for column in (b.points, b.failed, b.reused, b.seconds, b.kernel_seconds)
                    ),
                ).where(b.study == row.number)
            ).one()
            names = (
                c.blocks_done,
                c.points_done,
                c.points_failed,
                c.points_reused,
                c.seconds,
                c.kernel_seconds,
            )
            change: dict[Any, Any] = dict(zip(names, sums, strict=True))
            change |= {
                c.revision: row.revision + 1,
                c.taken_back: row.revision + 1,
                c.state: "queued",
                c.finished: None,
            }
            connection.execute(update(studies).where(c.number == row.number).values(change))
            _log(connection, study_id, f"{row.blocks_done - sums[0]} blocks taken back: {why}")
            return record_of(study_row(connection, study_id))

    # claims

    def claim(self, study_id: str, owner: str, seconds: float = CLAIM_SECONDS) -> bool:
        """Take a study to work on; False while another owner's claim holds.

        Parameters
        ----------
        study_id, owner : str
            The study, and a name that no other runner has.
        seconds : float
            The claim ends by itself unless it is renewed within this time [s].
        """
        now = time.time()
        free = (
            studies.c.claim_owner.is_(None)
            | (studies.c.claim_owner == owner)
            | (studies.c.claim_expires < now)
        )
        return self._set_claim(study_id, free, owner, now + seconds)

    def renew(self, study_id: str, owner: str, seconds: float = CLAIM_SECONDS) -> bool:
        """Hold a claim for longer; False if it went to somebody else, and then the work must stop."""
        return self._set_claim(study_id, studies.c.claim_owner == owner, owner, time.time() + seconds)

    def release(self, study_id: str, owner: str) -> None:
        """Give a claim up; nothing happens if it is somebody else's."""
        self._set_claim(study_id, studies.c.claim_owner == owner, None, None)

    def _set_claim(self, study_id: str, condition: Any, owner: str | None, expires: float | None) -> bool:
        change = update(studies).where(studies.c.id == study_id, ALIVE, condition)
        with self.catalogue.writing() as connection:
            return connection.execute(change.values(claim_owner=owner, claim_expires=expires)).rowcount == 1

    # cubes

    def cube_path(self, study_id: str) -> str:
        """Give the folder of a study's cube; `xarray.open_zarr` opens it, but knows nothing of done-marks."""
        with self.catalogue.reading() as connection:
            return str(self.folder(study_id, study_row(connection, study_id).number))

    def cube(self, study_id: str) -> xr.Dataset:
        """Open a study's cube as it is now: lazy, and every block wholly there or wholly not computed.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        StoreFault
            If its files are gone.
        """
        path, marks = self.snapshot(study_id)
        try:
            return open_cube(path, marks)
        except OSError as error:
            raise self._disk_fault(path, error) from error

    def snapshot(self, study_id: str, revision: int | None = None) -> tuple[Path, Marks]:
        """Give a cube's folder, and the generation of every block that is done.

        Parameters
        ----------
        study_id : str
            The whole id.
        revision : int, optional
            Only blocks that were done by then; now by default.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        RevisionGone
            If there was no such revision, or blocks were taken back since.
        """
        with self.catalogue.reading() as connection:
            row = study_row(connection, study_id)
            path = self.folder(study_id, row.number)
            if revision is not None and not row.taken_back <= revision <= row.revision:
                raise RevisionGone(
                    Fault(
                        "revision",
                        str(revision),
                        f"{row.taken_back} to {row.revision}",
                        "open the study anew: its blocks were computed again",
                    )
                )
            if revision is not None and revision != row.revision:
                return path, marks_of(connection, row.number, revision)
            kept = self._marks.get(row.number)
            if kept is None or kept[0] != row.revision:
                # one entry per study, each taken and put as a whole: threads need no lock
                kept = self._marks[row.number] = row.revision, marks_of(connection, row.number)
                while len(self._marks) > _MARKS_KEPT:
                    self._marks.pop(next(iter(self._marks)), None)
        return path, kept[1]

    def folder(self, study_id: str, number: int) -> Path:
        """Give the folder of a cube by its study's id and number."""
        return self.data_dir / "cubes" / f"{study_id}-{number}.zarr"

    def number(self, connection: Connection, study_id: str) -> int:
        """Give the number by which the other tables know a study; raise `StudyNotFound` if there is none."""
        return int(study_row(connection, study_id).number)

    def bury(self, before: float = math.inf) -> None:
        """Remove the files of studies that were deleted before a time, in seconds since 1970.

        A tombstone's row goes last, so that a removal that was cut short is found again.
        """
        with self.catalogue.reading() as connection:
            rows = connection.execute(select(studies).where(studies.c.deleted < before)).all()
        for row in rows:
            path = self.folder(row.id, row.number)
            shutil.rmtree(path, ignore_errors=True)
            if not path.exists():
                with self.catalogue.writing() as connection:
                    connection.execute(delete(studies).where(studies.c.number == row.number))

    def trouble(self) -> str | None:
        """Say why no more can be written, in words; None while there is room.

        Some room is kept free, so that the catalogue can still say what happened when the cubes have filled the disk.
        """
        try:
            free = shutil.disk_usage(self.data_dir).free
        except OSError as error:
            return f"the data directory cannot be used ({error})"
        if free < RESERVE_BYTES:
            return (
                f"the disk of {self.data_dir} is full: {free / 1e6:.3g} MB are free, "
                f"{RESERVE_BYTES / 1e6:.3g} MB are kept for the catalogue; make room"
            )
        return None

    def _disk_fault(self, path: Path, error: OSError) -> StoreFault:
        return StoreFault(
            Fault(
                str(path),
                str(error),
                "a cube that can be read and written",
                "check the disk's free space and the folder's permissions; a cube that is lost can be "
                "computed again after `damperlab delete`",
            )
        )


def _require_free(row: Row[Any], what: str) -> None:
    owner = claim_owner(row)
    if owner is not None:
        raise StudyBusy(
            Fault(
                "study",
                f"{row.id} is {row.state}, worked on by {owner}",
                f"a study that nobody works on, to {what} it",
                f"cancel it first: damperlab cancel {row.id}",
            )
        )


def _take_key(connection: Connection, key: str, digest: str) -> None:
    known = connection.execute(select(keys.c.digest).where(keys.c.key == key)).scalar()
    if known is None:
        connection.execute(insert(keys).values(key=key, digest=digest, at=time.time()))
    elif known != digest:
        raise KeyTaken(
            Fault(
                "Idempotency-Key",
                f"{describe(key)}, given to study {known[:12]} before",
                "a key of its own for each study",
                "send the same definition as before, or another key",
            )
        )


def _log(connection: Connection, study_id: str, what: str) -> None:
    connection.execute(insert(events).values(study=study_id, at=time.time(), what=what))


def _sayable(text: str) -> str:
    return text.encode(errors="replace").decode().replace("\0", "?")
