"""Runs several small studies as one batch. The studies are claimed and finished together, which saves time."""

import logging
import threading
import uuid
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.cube.definition import parse_stored
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.record import BlockOutcome, Record
from damperlab.studies.store.reuse.reuse import Boxes, Overlaps
from damperlab.studies.store.store import Store
from damperlab.worker.cores import core_count
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import code_hash, computing
from damperlab.worker.run.background import Background
from damperlab.worker.run.lease import RENEW_SECONDS, held_owner
from damperlab.worker.worker_process.tasks import run_block

AT_ONCE = 16
"""Largest number of studies in a batch. If the process is killed, at most this many studies must be computed again."""

_log = logging.getLogger(__name__)


def compute_together(store: Store, ids: Sequence[str], stop: Callable[[], bool]) -> None:
    """Compute new studies of one block each in this process, as many at the same time as there are cores.

    A study whose block fails is queued again, for a separate run.

    Parameters
    ----------
    store : Store
        Store that holds the studies.
    ids : sequence of str
        Full ids of the studies. The kernels that the studies need must be compiled already.
    stop : callable
        Returns True if no further study may start.
    """
    identity = computing()["identity"]
    with hold(store, ids, identity) as (owner, records):

        def attempt(task: tuple[Any, ...]) -> BlockOutcome | None:
            try:
                return None if stop() else run_block(*task)
            except Exception:
                return None  # a separate run computes the study again, and reports the error

        with ThreadPoolExecutor(core_count(), "block") as threads:
            outcomes = threads.map(attempt, tasks_of(store, records, identity))
            done = {record.id: end for record, end in zip(records, outcomes, strict=True) if end is not None}
        store.finish(owner, done)


@contextmanager
def hold(store: Store, ids: Sequence[str], identity: str) -> Iterator[tuple[str, list[Record]]]:
    """Hold claims on studies within the context. Afterwards unfinished studies are queued again.

    Parameters
    ----------
    store : Store
        Store that holds the studies.
    ids : sequence of str
        Full ids of the studies.
    identity : str
        Identity of the solver that computes the studies.

    Yields
    ------
    str, list of Record
        Name of the owner of the claims, and the claimed studies.
    """
    with held_owner() as owner:
        runner = threading.current_thread()
        renewing = Background("lease-batch", lambda: store.renew_all(owner), RENEW_SECONDS, runner.is_alive)
        renewing.start(at_once=False)
        try:
            yield owner, store.take(ids, owner, identity)
        finally:
            renewing.close()
            try:
                store.put_back(owner)
            except StoreFault as error:
                # the next runner can take over the claims, because `owner_is_dead` is now true for their owner
                _log.warning("the claims of %s could not be released: %s", owner, error)


def tasks_of(store: Store, records: Sequence[Record], identity: str) -> list[tuple[Any, ...]]:
    """Return the arguments of `run_block` for each study."""
    boxes: dict[str, Boxes] = {}
    tasks: list[tuple[Any, ...]] = []
    for record in records:
        study = parse_stored(record.definition, record.digest)
        block = plan_with_chunk(study, record.chunk, seconds_per_point).block(0)
        family = repr(study.settings())
        if record.reuse and family not in boxes:
            boxes[family] = Boxes(store, record)
        sources = Overlaps(store, record, boxes.get(family)).of(block)
        path = store.cube_path(record.id)
        tasks.append((path, record.digest, block, code_hash(), uuid.uuid4().hex[:12], sources, identity))
    return tasks
