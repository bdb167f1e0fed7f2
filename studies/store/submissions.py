"""Studies come and go: submitted once however often they are asked for, deleted by a tombstone first."""

import json
import math
import time
from collections.abc import Callable, Mapping
from contextlib import suppress

from sqlalchemy import Connection, delete, func, insert, select, update

from damperlab.studies.digest import family_digest
from damperlab.studies.faults import Fault, describe
from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Plan
from damperlab.studies.store.base import StoreBase
from damperlab.studies.store.box import box_of
from damperlab.studies.store.chunks import damaged
from damperlab.studies.store.claims import require_free
from damperlab.studies.store.cube import block_grid, bytes_per_point, create_cube, restore_metadata
from damperlab.studies.store.definition import parse_stored, with_attachments
from damperlab.studies.store.faults import KeyTaken, NothingToDo, cannot_use
from damperlab.studies.store.record import Record
from damperlab.studies.store.rows import log_event, newest_row, record_of, study_row
from damperlab.studies.store.rowsum import require_row
from damperlab.studies.store.submitter import signed
from damperlab.studies.store.tables import done_blocks, keys, studies

_AT_ONCE = 5000  # marks that are removed in one transaction


class Submissions(StoreBase):
    """How studies enter a store and leave it."""

    def submit(
        self,
        study: AnyStudy,
        plan: Plan,
        provenance: dict[str, str],
        *,
        reuse: bool = True,
        key: str | None = None,
    ) -> tuple[Record, bool]:
        """Keep a study and make its empty cube, unless the same definition is there already.

        Parameters
        ----------
        study, plan : AnyStudy, Plan
            What is asked, and how its grid is cut.
        provenance : dict of str
            See `damperlab.studies.store.provenance.provenance`.
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
        QuotaReached
            If the study would take more than is left.
        KeyTaken
            If the key was given to another definition before.
        """
        if plan.count != math.prod(block_grid(study.shape, plan.chunk)):
            raise ValueError(f"a plan of {plan.count} blocks does not cut {study.shape} by {plan.chunk}")
        # seen without a turn at writing first: the same study is asked for again and again
        if key is None:
            with self.catalogue.reading() as connection:
                row = newest_row(connection, study.digest)
            if row is not None:
                return record_of(row), False
        with self.catalogue.writing() as connection:
            if key is not None:
                _take_key(connection, key, study.digest)
            row = newest_row(connection, study.digest)
            if row is not None:
                return record_of(row), False
            return self._enter(connection, study, plan.chunk, provenance, 1, reuse), True

    def recompute(self, study_id: str, provenance: dict[str, str]) -> tuple[Record, bool]:
        """Enter a study once more, to be computed by today's solver beside what is there.

        Parameters
        ----------
        study_id : str
            The whole id of any version.
        provenance : dict of str
            Of today's solver.

        Returns
        -------
        record : Record
            The new version, or the newest one where that is today's solver's, or waits for it, already.
        created : bool
            Whether it is new.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        NothingToDo
            If the study is complete and of today's solver, or has no results yet.
        StoreFault, QuotaReached
            As for `submit`.
        """
        with self.catalogue.writing() as connection:
            older = record_of(study_row(connection, study_id))
            if not older.blocks_done or (older.state == "done" and not older.outdated):
                raise _nothing_to_recompute(older)
            row = newest_row(connection, older.digest)
            newest = record_of(row) if row is not None else older
            if newest.id != older.id and not newest.outdated:
                return newest, False
            shelf = self.cube_shelf(study_id, self.number(connection, study_id))
            try:
                study = with_attachments(parse_stored(older.definition, older.digest), shelf)
            except (OSError, ValueError) as error:
                raise damaged(shelf, None, "a ground-motion record", str(error)) from error
            version = newest.version + 1
            return self._enter(connection, study, older.chunk, provenance, version, older.reuse), True

    def _enter(
        self,
        connection: Connection,
        study: AnyStudy,
        chunk: tuple[int, ...],
        provenance: dict[str, str],
        version: int,
        reuse: bool,
    ) -> Record:
        provenance = signed(provenance)
        study_id = study.digest[:12] + (f"-{version}" if version > 1 else "")
        wanted = study.points * bytes_per_point(study)
        self.quota.require(connection, study.points, wanted)
        # a reader that keeps to a revision of a study that was deleted must not find it in the new one
        ever = select(func.coalesce(func.max(studies.c.revision) + 1, 0)).where(studies.c.id == study_id)
        revision = connection.execute(ever).scalar_one()
        now = time.time()
        number = connection.execute(
            insert(studies).values(
                id=study_id,
                digest=study.digest,
                version=version,
                name=study.name,
                state="queued",
                definition=json.dumps(study.document()),
                provenance=json.dumps(provenance),
                shape=json.dumps(study.shape),
                chunk=json.dumps(chunk),
                points_total=study.points,
                bytes_total=wanted,
                blocks_total=math.prod(block_grid(study.shape, chunk)),
                family=family_digest(study, provenance),
                box=json.dumps(box_of(study)),
                reuse=reuse,
                created=now,
                revision=revision,
                taken_back=revision,
            )
        ).inserted_primary_key[0]  # type: ignore[index]
        shelf = self.cube_shelf(study_id, number)
        try:
            # made before the commit: who sees the study finds its cube
            create_cube(shelf, study, chunk, provenance, reuse=reuse, created=now)
        except BaseException as error:
            with suppress(OSError):
                shelf.clear()
            if isinstance(error, OSError):
                raise cannot_use(shelf.address, error) from error
            raise
        log_event(connection, study_id, "submitted" if version == 1 else f"entered as version {version}")
        return record_of(study_row(connection, study_id))

    def begin(self, study_id: str, facts: Mapping[str, str], owner: str | None = None) -> Record:
        """Record what computes a study, before its first block: one cube, one solver on one kind of processor.

        A study that waited while the solver changed holds nothing of the older one yet, and is simply recorded anew.

        Parameters
        ----------
        study_id : str
            The whole id.
        facts : mapping of str
            What the workers say; `identity` is what counts.
        owner : str, optional
            Who claims to work on the study; nothing changes where the claim is somebody else's.

        Returns
        -------
        Record
            As it is then. Where blocks are done its provenance is what it was, and the caller compares.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        StoreFault
            If the cube cannot be written.
        """
        with self.catalogue.writing() as connection:
            row = study_row(connection, study_id)
            record = record_of(row)
            known = record.provenance.get("identity") == facts["identity"]
            if known or row.blocks_done or owner not in (None, row.claim_owner):
                return record
            provenance = {**record.provenance, **facts}
            study = parse_stored(record.definition, record.digest)
            shelf = self.cube_shelf(study_id, row.number)
            try:
                # before the commit: should the process die in between, it is done again
                restore_metadata(
                    shelf, study, record.chunk, provenance, reuse=record.reuse, created=row.created
                )
            except OSError as error:
                raise cannot_use(shelf.address, error) from error
            change = {"provenance": json.dumps(provenance), "family": family_digest(study, provenance)}
            connection.execute(update(studies).where(studies.c.number == row.number).values(change))
            log_event(connection, study_id, f"to be computed by solver {facts['identity']}")
            return record_of(study_row(connection, study_id))

    def delete(self, study_id: str) -> None:
        """Forget a study; `bury` removes its files afterwards, which may take long.

        The study is gone once its tombstone is committed. Whoever calls `bury` next, in this process or another,
        removes the files: a service in the background, `damperlab delete` and `damperlab gc` as they run.

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
                require_free(row, "delete")
            connection.execute(
                update(studies).where(studies.c.number == row.number).values(deleted=time.time())
            )
            log_event(connection, study_id, "deleted")

    def bury(self, before: float = math.inf, stop: Callable[[], bool] = lambda: False) -> None:
        """Remove the files of studies that were deleted before a time, in seconds since 1970.

        A tombstone loses its marks and its definition last, so that a removal that was cut short is found again;
        an empty row stays, which keeps the study's number and revisions from coming again.
        """
        c = studies.c
        with self.catalogue.reading() as connection:
            rows = connection.execute(
                select(c.id, c.number).where(c.deleted < before, c.definition != "")
            ).all()
        for row in rows:
            if stop():
                return
            try:
                self.cube_shelf(row.id, row.number).clear()
            except OSError:
                continue  # found again
            while self._forget_marks(row.number):
                pass
            with self.catalogue.writing() as connection:
                empty = {"name": "", "message": None, "definition": "", "provenance": "", "family": ""}
                connection.execute(update(studies).where(c.number == row.number).values(empty))

    def _forget_marks(self, number: int) -> bool:
        """Remove some marks of a study that was deleted, and say whether there may be more: others want to write too."""
        b = done_blocks.c
        with self.catalogue.writing() as connection:
            some = select(b.block).where(b.study == number).order_by(b.block).limit(_AT_ONCE)
            last = connection.execute(select(func.max(some.subquery().c.block))).scalar()
            if last is None:
                return False
            connection.execute(delete(done_blocks).where(b.study == number, b.block <= last))
            return True


def _nothing_to_recompute(record: Record) -> NothingToDo:
    if not record.blocks_done:
        found, advice = f"{record.id}, which has no results yet", f"damperlab resume {record.id}"
    else:
        found = f"{record.id}, which is of today's solver: it would give the same bits"
        advice = "nothing need be done; `damperlab verify` checks that the results are as they were written"
    return NothingToDo(Fault("study", found, "a study whose results are of another solver", advice))


def _take_key(connection: Connection, key: str, digest: str) -> None:
    row = connection.execute(select(keys).where(keys.c.key == key)).one_or_none()
    if row is not None:
        require_row(keys, row, row.digest[:12])
    known = None if row is None else row.digest
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
