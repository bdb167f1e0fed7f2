"""Studies come and go: submitted once however often they are asked for, deleted by a tombstone first."""

import json
import math
import time
from contextlib import suppress

from sqlalchemy import Connection, delete, func, insert, select, update

from damperlab.studies.digest import family_digest
from damperlab.studies.faults import Fault, describe
from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Plan
from damperlab.studies.store.base import StoreBase
from damperlab.studies.store.claims import require_free
from damperlab.studies.store.cube import block_grid, bytes_per_point, create_cube
from damperlab.studies.store.faults import KeyTaken, cannot_use
from damperlab.studies.store.record import Record
from damperlab.studies.store.rows import alive_row, log_event, record_of, study_row
from damperlab.studies.store.tables import done_blocks, keys, studies


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
                    name=study.name,
                    state="queued",
                    definition=json.dumps(study.document()),
                    provenance=json.dumps(provenance),
                    shape=json.dumps(study.shape),
                    chunk=json.dumps(plan.chunk),
                    points_total=study.points,
                    bytes_total=wanted,
                    blocks_total=plan.count,
                    family=family_digest(study, provenance),
                    reuse=reuse,
                    created=now,
                    revision=revision,
                    taken_back=revision,
                )
            ).inserted_primary_key[0]  # type: ignore[index]
            shelf = self.cube_shelf(study_id, number)
            try:
                # made before the commit: who sees the study finds its cube
                create_cube(shelf, study, plan.chunk, provenance, reuse=reuse, created=now)
            except BaseException as error:
                with suppress(OSError):
                    shelf.clear()
                if isinstance(error, OSError):
                    raise cannot_use(shelf.address, error) from error
                raise
            log_event(connection, study_id, "submitted")
            return record_of(study_row(connection, study_id)), True

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
                require_free(row, "delete")
            connection.execute(
                update(studies).where(studies.c.number == row.number).values(deleted=time.time())
            )
            log_event(connection, study_id, "deleted")
        self.bury()

    def bury(self, before: float = math.inf) -> None:
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
            try:
                self.cube_shelf(row.id, row.number).clear()
            except OSError:
                continue  # found again
            with self.catalogue.writing() as connection:
                connection.execute(delete(done_blocks).where(done_blocks.c.study == row.number))
                empty = {"name": "", "message": None, "definition": "", "provenance": "", "family": ""}
                connection.execute(update(studies).where(c.number == row.number).values(empty))


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
