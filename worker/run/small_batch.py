"""A batch of small studies that start and end together, so that they share overhead."""

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
"""Studies of a design that start and end together. If the process is killed, at most this many are computed again."""

_log = logging.getLogger(__name__)


def compute_together(store: Store, ids: Sequence[str], stop: Callable[[], bool]) -> None:
    """Compute new studies of one block each, one on each core of this machine.

    An unusual study, for example one with a failing block, stays queued for a run of its own.

    Parameters
    ----------
    store : Store
        Their store.
    ids : sequence of str
        Their complete ids; their kernels are compiled.
    stop : callable
        Whether to start no further one.
    """
    identity = computing()["identity"]
    with hold(store, ids, identity) as (owner, records):

        def attempt(task: tuple[Any, ...]) -> BlockOutcome | None:
            try:
                return None if stop() else run_block(*task)
            except Exception:
                return None  # in a run of its own, the study is tried again and reports its error

        with ThreadPoolExecutor(core_count(), "block") as threads:
            outcomes = threads.map(attempt, tasks_of(store, records, identity))
            done = {record.id: end for record, end in zip(records, outcomes, strict=True) if end is not None}
        store.finish(owner, done)


@contextmanager
def hold(store: Store, ids: Sequence[str], identity: str) -> Iterator[tuple[str, list[Record]]]:
    """Claim studies within the context; unfinished ones are queued again."""
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
                # the next owner takes over the claims of a dead one
                _log.warning("the claims of %s could not be released: %s", owner, error)


def tasks_of(store: Store, records: Sequence[Record], identity: str) -> list[tuple[Any, ...]]:
    """Give the arguments of `run_block` for each study."""
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
