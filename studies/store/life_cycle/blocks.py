"""Setting and invalidation of the done-marks of blocks."""

import json
import time
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from sqlalchemy import Connection, Row, delete, func, insert, select

from damperlab.studies.faults import counted
from damperlab.studies.store.catalogue.rows import (
    SUMS,
    change_studies,
    claim_owner,
    log_event,
    lost_marks,
    marks_of,
    pieces,
    record_of,
    require_free,
    study_row,
    sums_of_marks,
)
from damperlab.studies.store.catalogue.tables import done_blocks, studies
from damperlab.studies.store.cube.block_file import BLOCKS
from damperlab.studies.store.faults import NothingToDo, StoreFault, catalogue_damaged, using
from damperlab.studies.store.life_cycle.manifest import MARKS, put_off_marks
from damperlab.studies.store.life_cycle.states import States
from damperlab.studies.store.record import BlockOutcome, Record
from damperlab.studies.vocabulary import ENDED


class Blocks(States):
    """The part of a store that sets and invalidates done-marks."""

    def pending(self, study_id: str) -> np.ndarray:
        """Return the indices of the blocks without a done-mark, as an ascending array of int64.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        CatalogueDamaged
            If done-marks are lost.
        """
        with self.catalogue.reading() as connection:
            row = study_row(connection, study_id)
            done = np.zeros(row.blocks_total, bool)
            marks = marks_of(connection, row)
            done[np.fromiter(marks, np.int64)] = True
        lost = lost_marks(row, len(marks))
        if lost is not None:
            raise catalogue_damaged(study_id, lost)
        return np.flatnonzero(~done)

    def mark(self, study_id: str, *outcomes: BlockOutcome, owner: str | None = None) -> bool:
        """Set the done-marks of blocks whose files are on the disk. A block that already has a mark keeps this mark.

        Either all blocks are marked, or none. If `owner` is given and another owner has the claim on the study, no
        block is marked, and the method returns False.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        """
        with self.catalogue.writing() as connection:
            return self._mark(connection, study_id, outcomes, owner)

    def _mark(
        self, connection: Connection, study_id: str, outcomes: Sequence[BlockOutcome], owner: str | None
    ) -> bool:
        now = time.time()
        b, c = done_blocks.c, studies.c
        row = study_row(connection, study_id)
        if owner is not None and row.claim_owner != owner:
            return False
        fresh = {outcome.index: outcome for outcome in reversed(outcomes)}
        for index in fresh:
            if not 0 <= index < row.blocks_total:
                raise ValueError(f"block {index} of {row.blocks_total}")
        for some in pieces(outcome.index for outcome in outcomes):
            known = select(b.block).where(b.study == row.number, b.block.in_(some))
            for index in connection.execute(known).scalars():
                del fresh[index]
        if not fresh:
            return True
        # a cube must never contain results of two solvers; workers check this, too
        identity = json.loads(row.provenance).get("identity", "")
        strangers = {outcome.identity for outcome in fresh.values()} - {"", identity}
        if strangers:
            raise ValueError(
                f"blocks computed by {sorted(strangers)} in a cube of {identity or 'no identity'}"
            )
        added = list(fresh.values())
        # the columns of a done-mark have the names of the outcome's fields, except for the index
        marks = [
            {name: value for name, value in vars(outcome).items() if name != "index"}
            | {"study": row.number, "block": outcome.index, "at": now, "revision": row.revision + 1 + place}
            for place, outcome in enumerate(added)
        ]
        connection.execute(insert(done_blocks), marks)
        change: dict[str, Any] = {
            name: c[name] + sum(getattr(outcome, column) for outcome in added)
            for name, column in SUMS.items()
        }
        count = len(added)
        change |= {"blocks_done": c.blocks_done + count, "revision": c.revision + count, "last_mark": now}
        failure = next((outcome for outcome in added if outcome.message is not None), None)
        if failure is not None:
            change["message"] = func.coalesce(c.message, f"block {failure.index}: {failure.message}")
        change_studies(connection, [row.number], change)
        return True

    def retry(self, study_id: str) -> Record:
        """Invalidate the done-marks of failed blocks and queue the study, so that these blocks are computed again.

        A block fails as a whole if, for example, a worker dies. Points that failed numerically are not computed again.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        StudyBusy
            If a process works on the study.
        NothingToDo
            If no block failed, or another solver computed the study.
        TooManyUnfinished
            If the limit of waiting and running studies is reached.
        """
        record, blocks = self.find(study_id), self.given_up(study_id)
        if not blocks or record.outdated:
            raise _nothing_to_retry(record)
        self.forget(study_id, blocks, "to be tried again", in_turn=True)
        return self.set_state(study_id, "queued", "")

    def given_up(self, study_id: str) -> Sequence[int]:
        """Return the indices of the blocks that failed as a whole; raise `StudyNotFound` if there is no such study."""
        b = done_blocks.c
        with self.catalogue.reading() as connection:
            number = study_row(connection, study_id).number
            failed = select(b.block).where(b.study == number, b.message.is_not(None)).order_by(b.block)
            return connection.execute(failed).scalars().all()

    def forget(
        self,
        study_id: str,
        blocks: Sequence[int],
        why: str,
        *,
        in_turn: bool = False,
        owner: str | None = None,
    ) -> Record:
        """Invalidate the done-marks of blocks in one transaction, so that the blocks can be computed again.

        Blocks without a done-mark are ignored. The reason is recorded among the study's events. If the owner of the
        claim calls this method, the study's state is not changed; otherwise the study is queued.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        StudyBusy
            If another process works on the study.
        TooManyUnfinished
            If `in_turn` is set, the study has ended, and queuing it again would exceed the limit of waiting and running
            studies.
        """

        def look(connection: Connection) -> Row[Any]:
            row = study_row(connection, study_id)
            if owner is None or claim_owner(row) != owner:
                require_free(row, "invalidate blocks of")
            if in_turn:
                self._require_turn(connection, row)
            return row

        with self.catalogue.reading() as connection:
            row = look(connection)
        if row.state in ENDED:
            # tell other processes that the list is missing on purpose, also if this process is killed
            with self.catalogue.writing() as connection:
                put_off_marks(connection, study_id)
        shelf = self.cube_shelf(study_id, row.number)
        try:
            with using(shelf.address):
                # first remove the list of marks in the cube, so that the list never names an invalidated block
                shelf.remove(MARKS)
                # create the folder of the blocks again, because the folder may have been lost
                shelf.fill({}, (BLOCKS,))
            with self.catalogue.writing() as connection:
                return self._take_back(connection, look(connection), blocks, why, queue=owner is None)
        finally:
            # another process may have claimed the study meanwhile, or written the list again
            if row.state in ENDED:
                with suppress(StoreFault):
                    self.settle_marks(study_id)

    def _take_back(
        self, connection: Connection, row: Row[Any], blocks: Sequence[int], why: str, *, queue: bool
    ) -> Record:
        b = done_blocks.c
        for some in pieces(map(int, blocks)):
            connection.execute(delete(done_blocks).where(b.study == row.number, b.block.in_(some)))
        sums = sums_of_marks(connection, row.number)
        change: dict[str, Any] = {**sums, "revision": row.revision + 1, "taken_back": row.revision + 1}
        if queue:
            change |= {"state": "queued", "finished": None}
        change_studies(connection, [row.number], change)
        log_event(connection, row.id, f"{row.blocks_done - sums['blocks_done']} blocks invalidated: {why}")
        return record_of(study_row(connection, row.id))


def _nothing_to_retry(record: Record) -> NothingToDo:
    if record.outdated:
        found = "whose blocks another solver computed"
        told = f"The blocks of study {record.id} were computed by another solver, so they cannot be retried with this one."
        advice = f"compute the study again with `damperlab recompute {record.id}`"
    elif record.points_failed:
        found = f"whose {record.points_failed} failed points failed numerically"
        told = (
            f"Study {record.id} has {counted(record.points_failed, 'point')} that failed numerically and would "
            "fail again with the same solver. No block failed as a whole."
        )
        advice = "change `steady` or the range of the axes"
    else:
        found, advice = "in which no block failed", "to compute missing blocks, continue the study"
        told = f"Study {record.id} has no block that failed."
    allowed = "a study with blocks that failed as a whole"
    return NothingToDo("study", f"{record.id}, {found}", allowed, advice, told)
