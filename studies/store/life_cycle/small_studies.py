"""Many small studies together: claimed, marked and ended in one transaction."""

import json
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

from sqlalchemy import Connection, select, update

from damperlab.studies.store.catalogue.rows import ALIVE, alive_row
from damperlab.studies.store.catalogue.tables import studies
from damperlab.studies.store.faults import StoreFault, StudyNotFound
from damperlab.studies.store.files.shelf import AT_ONCE
from damperlab.studies.store.life_cycle.blocks import Blocks
from damperlab.studies.store.life_cycle.claims import CLAIM_SECONDS, Claims
from damperlab.studies.store.record import BlockOutcome, Record


class SmallBatches(Blocks, Claims):
    """Studies of one block that one owner computes together."""

    def take(self, ids: Sequence[str], owner: str, identity: str) -> list[Record]:
        """Claim and start those of the studies that wait, were never started, and are recorded for this solver and
        processor.

        Parameters
        ----------
        ids : sequence of str
            Whole ids.
        owner : str
            Owner of the claims.
        identity : str
            Identity of the owner's solver, see `damperlab.studies.store.solver.identity_of`.
        """
        taken = []
        now = time.time()
        with self.catalogue.writing() as connection:
            for study_id in ids:
                row = alive_row(connection, study_id)
                if row is None or row.state != "queued" or row.started is not None or self._holds(row):
                    continue
                if json.loads(row.provenance).get("identity") != identity:
                    continue
                self._set_claim(connection, row.number, owner, now + CLAIM_SECONDS)
                taken.append(
                    self._change_state(connection, study_id, "running", None, ("queued",), owner, now)
                )
        return taken

    def renew_all(self, owner: str) -> None:
        """Renew every claim of an owner."""
        change = update(studies).where(studies.c.claim_owner == owner, ALIVE)
        with self.catalogue.writing() as connection:
            connection.execute(change.values(claim_expires=time.time() + CLAIM_SECONDS))

    def finish(self, owner: str, outcomes: Mapping[str, BlockOutcome]) -> None:
        """Mark the one block of each study, and end the study. If its cube cannot store the marks, the next run ends it."""
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
                    self._change_state(connection, study_id, "done", None, ("running",), owner, now)
                    self._set_claim(connection, row.number, None, None)

    def put_back(self, owner: str) -> list[str]:
        """Queue the unfinished studies of an owner, and release its claims; give their ids."""
        c = studies.c
        with self.catalogue.writing() as connection:
            rows = connection.execute(select(c.id, c.number).where(c.claim_owner == owner, ALIVE)).all()
            for row in rows:
                self._change_state(connection, row.id, "queued", None, ("running",), owner, time.time())
                self._set_claim(connection, row.number, None, None)
        return [row.id for row in rows]

    def _mark_one(self, connection: Connection, study_id: str, outcome: BlockOutcome, owner: str) -> bool:
        try:
            return self._mark(connection, study_id, [outcome], owner)
        except StudyNotFound:
            return False  # deleted meanwhile

    def _kept(self, study_id: str, now: float) -> bool:
        try:
            self._keep_marks(study_id, "done", None, now)
        except StoreFault:
            return False  # deleted, or the disk is full; in the latter case it keeps its mark, and the next run ends it
        return True
