"""The store: the catalogue and the cubes of one data directory, behind one door."""

import json
import shutil
import time
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from sqlalchemy import delete, func, insert, select, update
from sqlalchemy.dialects import sqlite

from studies.definition import Study
from studies.faults import Fault, describe, listing
from studies.plan import Plan
from studies.store.catalogue import Catalogue, done_blocks, open_catalogue, studies
from studies.store.cube import block_grid, create_cube, open_cube
from studies.store.faults import StoreFault, StudyBusy, StudyNotFound
from studies.store.record import STATES, BlockOutcome, Page, Record
from studies.store.rows import (
    ALIVE,
    alive_row,
    claim_owner,
    cursor_of,
    done_flags,
    number_before,
    record_of,
    study_row,
    unknown_study,
)

CLAIM_SECONDS = 60.0
"""How long a claim holds without being renewed [s]."""

PAGE_LIMIT = 1000
"""Most records on one page."""


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
        self._catalogue = catalogue

    @classmethod
    def open(cls, data_dir: Path) -> "Store":
        """Open a data directory, making it where it is missing; what an interrupted delete left is removed.

        Raises
        ------
        StoreFault
            If the folder cannot be used, or a newer version made it.
        """
        data_dir = Path(data_dir).expanduser().absolute()
        store = cls(data_dir, open_catalogue(data_dir))
        store._sweep()
        return store

    def close(self) -> None:
        """Close the catalogue's connections."""
        self._catalogue.close()

    # studies

    def submit(self, study: Study, plan: Plan, provenance: dict[str, str]) -> tuple[Record, bool]:
        """Keep a study and make its empty cube, unless the same definition is there already.

        Parameters
        ----------
        study, plan : Study, Plan
            What is asked, and how its grid is cut.
        provenance : dict of str
            See `studies.store.provenance.provenance`.

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
        """
        if plan.count != prod(block_grid(study.shape, plan.chunk)):
            raise ValueError(f"a plan of {plan.count} blocks does not cut {study.shape} by {plan.chunk}")
        study_id = study.digest[:12]
        # seen without a turn at writing first: the same study is asked for again and again
        with self._catalogue.reading() as connection:
            row = alive_row(connection, study_id)
        if row is not None:
            return record_of(row), False
        with self._catalogue.writing() as connection:
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
                    created=time.time(),
                )
            ).inserted_primary_key[0]  # type: ignore[index]
            path = self._path(study_id, number)
            try:
                # made before the commit: who sees the study finds its cube
                create_cube(path, study, plan, provenance)
            except BaseException as error:
                shutil.rmtree(path, ignore_errors=True)
                if isinstance(error, OSError):
                    raise self._disk_fault(path, error) from error
                raise
            return record_of(study_row(connection, study_id)), True

    def find(self, ref: str) -> Record:
        """Look a study up by its id, a prefix of it that no other id has, or its name (the newest so named).

        Raises
        ------
        StudyNotFound
            If none is found, or a prefix fits several.
        """
        # SQLite takes no half characters, which a command line may hold
        ref = ref.encode(errors="replace").decode()
        with self._catalogue.reading() as connection:
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
            text = name.encode(errors="replace").decode()
            query = query.where(func.instr(func.lower(studies.c.name), func.lower(text)) > 0)
        query = query.order_by(studies.c.number.desc()).limit(limit + 1)
        with self._catalogue.reading() as connection:
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
        with self._catalogue.writing() as connection:
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
            return record_of(study_row(connection, study_id))

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
        with self._catalogue.writing() as connection:
            row = study_row(connection, study_id)
            owner = claim_owner(row)
            if owner is not None and row.state != "cancelled":
                raise StudyBusy(
                    Fault(
                        "study",
                        f"{study_id} is {row.state}, worked on by {owner}",
                        "a study that nobody works on",
                        f"cancel it first: damperlab cancel {study_id}",
                    )
                )
            connection.execute(
                update(studies).where(studies.c.number == row.number).values(deleted=time.time())
            )
        self._sweep()

    # blocks

    def pending(self, study_id: str) -> np.ndarray:
        """Give the indices of the blocks without a done-mark, ascending, int64."""
        with self._catalogue.reading() as connection:
            return np.flatnonzero(~done_flags(connection, study_row(connection, study_id)))

    def mark(self, study_id: str, outcome: BlockOutcome) -> None:
        """Set the done-mark of a block whose region is on the disk; a block that has one keeps its first.

        Raises
        ------
        StudyNotFound
            If the study is gone.
        """
        now = time.time()
        with self._catalogue.writing() as connection:
            row = study_row(connection, study_id)
            if not 0 <= outcome.index < row.blocks_total:
                raise ValueError(f"block {outcome.index} of {row.blocks_total}")
            values = {
                "study": row.number,
                "block": outcome.index,
                "points": outcome.points,
                "failed": outcome.failed,
                "seconds": outcome.seconds,
                "kernel_seconds": outcome.kernel_seconds,
                "message": outcome.message,
                "at": now,
            }
            added = connection.execute(sqlite.insert(done_blocks).values(values).on_conflict_do_nothing())
            if added.rowcount == 0:
                return
            c = studies.c
            change: dict[Any, Any] = {
                c.points_done: c.points_done + outcome.points,
                c.points_failed: c.points_failed + outcome.failed,
                c.blocks_done: c.blocks_done + 1,
                c.seconds: c.seconds + outcome.seconds,
                c.kernel_seconds: c.kernel_seconds + outcome.kernel_seconds,
                c.last_mark: now,
            }
            if outcome.message is not None:
                change[c.message] = func.coalesce(c.message, f"block {outcome.index}: {outcome.message}")
            connection.execute(update(studies).where(c.number == row.number).values(change))

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
        with self._catalogue.writing() as connection:
            return connection.execute(change.values(claim_owner=owner, claim_expires=expires)).rowcount == 1

    # cubes

    def cube_path(self, study_id: str) -> str:
        """Give the folder of a study's cube; `xarray.open_zarr` opens it, but knows nothing of done-marks."""
        with self._catalogue.reading() as connection:
            return str(self._path(study_id, study_row(connection, study_id).number))

    def cube(self, study_id: str) -> xr.Dataset:
        """Open a study's cube as it is now: lazy, and every block wholly there or wholly not computed.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        StoreFault
            If its files are gone.
        """
        with self._catalogue.reading() as connection:
            row = study_row(connection, study_id)
            done = None if row.blocks_done == row.blocks_total else done_flags(connection, row)
        path = self._path(study_id, row.number)
        try:
            return open_cube(path, done)
        except OSError as error:
            raise self._disk_fault(path, error) from error

    def _path(self, study_id: str, number: int) -> Path:
        return self.data_dir / "cubes" / f"{study_id}-{number}.zarr"

    def _sweep(self) -> None:
        # a tombstone's row goes last, so that a removal that was cut short is found again
        with self._catalogue.reading() as connection:
            rows = connection.execute(select(studies).where(~ALIVE)).all()
        for row in rows:
            path = self._path(row.id, row.number)
            shutil.rmtree(path, ignore_errors=True)
            if not path.exists():
                with self._catalogue.writing() as connection:
                    connection.execute(delete(studies).where(studies.c.number == row.number))

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
