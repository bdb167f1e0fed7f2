"""Processing of many small studies together: one transaction claims, marks or ends all of them."""

import json
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

from sqlalchemy import Connection, select, update

from damperlab.studies.store.catalogue.rows import ALIVE, alive_row, change_study
from damperlab.studies.store.catalogue.tables import studies
from damperlab.studies.store.faults import StoreFault, StudyNotFound
from damperlab.studies.store.files.shelf import AT_ONCE
from damperlab.studies.store.life_cycle.blocks import Blocks
from damperlab.studies.store.life_cycle.claims import UNCLAIMED, Claims, claimed
from damperlab.studies.store.record import BlockOutcome, Record


class SmallBatches(Blocks, Claims):
    """The part of a store that processes many single-block studies at once."""

    def claim_all(self, ids: Sequence[str], owner: str, identity: str) -> list[Record]:
        """Claim and start the queued studies that were never started and have no owner.

        The studies must be recorded for `identity`, the identity of the owner's solver and processor; see
        `damperlab.studies.store.solver.identity_of`.
        """
        taken = []
        with self.catalogue.writing() as connection:
            for study_id in ids:
                row = alive_row(connection, study_id)
                if row is None or row.state != "queued" or row.started is not None or self._holds(row):
                    continue
                if json.loads(row.provenance).get("identity") != identity:
                    continue
                change_study(connection, row.number, claimed(owner))
                taken.append(
                    self._change_state(connection, study_id, "running", only_from=("queued",), owner=owner)
                )
        return taken

    def renew_all(self, owner: str) -> None:
        """Renew every claim of an owner."""
        change = update(studies).where(studies.c.claim_owner == owner, ALIVE)
        with self.catalogue.writing() as connection:
            connection.execute(change.values(claimed(owner)))

    def finish_all(self, owner: str, outcomes: Mapping[str, BlockOutcome]) -> None:
        """Set the done-mark of each study's only block. End the studies whose marks could be written into the cubes."""
        with self.catalogue.writing() as connection:
            marked = [
                each for each, outcome in outcomes.items() if self._mark_one(connection, each, outcome, owner)
            ]
        now = time.time()
        with ThreadPoolExecutor(AT_ONCE) as pool:
            kept = list(pool.map(lambda study_id: self._kept(study_id, now), marked))
        with self.catalogue.writing() as connection:
            for study_id, good in zip(marked, kept, strict=True):
                row = alive_row(connection, study_id)
                if good and row is not None and row.claim_owner == owner:
                    self._change_state(
                        connection, study_id, "done", only_from=("running",), owner=owner, now=now
                    )
                    change_study(connection, row.number, UNCLAIMED)

    def release_all(self, owner: str) -> None:
        """Queue the running studies of an owner again, and release all claims of the owner."""
        c = studies.c
        with self.catalogue.writing() as connection:
            rows = connection.execute(select(c.id, c.number).where(c.claim_owner == owner, ALIVE)).all()
            for row in rows:
                self._change_state(connection, row.id, "queued", only_from=("running",), owner=owner)
                change_study(connection, row.number, UNCLAIMED)

    def _mark_one(self, connection: Connection, study_id: str, outcome: BlockOutcome, owner: str) -> bool:
        try:
            return self._mark(connection, study_id, [outcome], owner)
        except StudyNotFound:
            return False  # the study was deleted meanwhile

    def _kept(self, study_id: str, now: float) -> bool:
        try:
            self._keep_marks(study_id, "done", None, now)
        except StoreFault:
            return False  # the study was deleted, or the disk is full; then the next run ends the study
        return True
