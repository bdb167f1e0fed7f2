"""Runs several small studies as one batch, in this process or on a cluster.

The studies are claimed and finished together, which saves time.
"""

import threading
import uuid
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, suppress
from typing import TYPE_CHECKING, Any

from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.cube.definition import parse_stored
from damperlab.studies.store.record import BlockOutcome, Record
from damperlab.studies.store.reuse import Boxes, Overlaps
from damperlab.studies.store.store import Store
from damperlab.worker.cores import core_count
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.outcomes import Outage, asking_the_cluster
from damperlab.worker.provenance import WrongCode, code_hash, computing, one_identity
from damperlab.worker.run.lease import new_owner, renewed, renewer
from damperlab.worker.scenes import scenes
from damperlab.worker.worker_process.tasks import run_block

if TYPE_CHECKING:
    from distributed import Client, Future

AT_ONCE = 16
"""Largest number of studies in a batch. If the process is killed, at most this many studies must be computed again."""

A_TASK = 8
"""Number of blocks in one task."""
POLL_SECONDS = 0.05
"""Interval between checks whether the tasks have ended [s]."""


def compute_together(store: Store, ids: Sequence[str], stop: Callable[[], bool]) -> set[str]:
    """Compute new studies in this process, as many blocks at the same time as there are cores.

    The kernels that the studies need must be compiled already. If `stop` returns True, no further block starts. A study
    of which a block fails is queued again, for a separate run. The function returns the ids of the studies that are
    done.
    """
    identity = computing()["identity"]
    with _hold(store, ids, identity) as (owner, records):

        def attempt(task: tuple[Any, ...]) -> BlockOutcome | None:
            return None if stop() else _attempted(task)

        with ThreadPoolExecutor(core_count(), "block") as threads:
            outcomes = list(threads.map(attempt, _tasks_of(store, records, identity)))
        return store.finish_all(owner, _complete(records, outcomes))


def compute_together_on_cluster(
    store: Store,
    ids: Sequence[str],
    client_factory: "Callable[[], AbstractContextManager[Client]]",
    stop: threading.Event,
) -> list[str]:
    """Compute new studies on a cluster.

    The wait for results ends when another thread sets `stop`. The function returns the ids of the studies that need a
    separate run, for example because kernels must be compiled or the block failed.
    """
    # imported here, because studies that this process computes need no cluster library
    from damperlab.worker.dispatch.tasks import sealed

    with client_factory() as client:
        try:
            answers: dict[str, dict[str, str]] = client.run(computing, on_error="ignore")
            identity = one_identity(answers)["identity"] if answers else ""
        except WrongCode:
            identity = ""
        # if kernels are missing, no study is claimed here, because only a separate run reports the compilation
        if not identity or store.trouble() is not None or not _ready(client, [store.find(ids[0])]):
            return list(ids)
        with _hold(store, ids, identity) as (owner, records):
            if not records or not _ready(client, records):
                return list(ids)
            tasks = _tasks_of(store, records, identity)
            futures = [
                client.submit(*sealed(run_blocks, tasks[start : start + A_TASK]), pure=False)
                for start in range(0, len(tasks), A_TASK)
            ]
            try:
                outcomes = _outcomes(client, futures, stop)
            finally:
                with suppress(Outage), asking_the_cluster(client):
                    client.cancel(futures)
            done = _complete(records, outcomes)
            store.finish_all(owner, done)
    return [study_id for study_id in ids if study_id not in done]


@contextmanager
def _hold(store: Store, ids: Sequence[str], identity: str) -> Iterator[tuple[str, list[Record]]]:
    """Hold claims on studies within the context. Afterwards unfinished studies are queued again.

    The context yields the name of the owner of the claims, and the claimed studies.
    """
    owner = new_owner()
    renewing = renewer("lease-batch", lambda: store.renew_all(owner))
    with renewed(owner, renewing, lambda: store.release_all(owner)):
        yield owner, store.claim_all(ids, owner, identity)


def _complete(
    records: Sequence[Record], outcomes: Sequence[BlockOutcome | None]
) -> dict[str, list[BlockOutcome]]:
    """Return the outcomes of the studies all of whose blocks succeeded, by the id of the study.

    `outcomes` has an entry for each block, in the order of the tasks; None for a failed block.
    """
    found: dict[str, list[BlockOutcome]] = {}
    place = 0
    for record in records:
        ends = [end for end in outcomes[place : place + record.blocks_total] if end is not None]
        if len(ends) == record.blocks_total:
            found[record.id] = ends
        place += record.blocks_total
    return found


def _tasks_of(store: Store, records: Sequence[Record], identity: str) -> list[tuple[Any, ...]]:
    """Return the arguments of `run_block` for each block, study by study."""
    boxes: dict[str, Boxes] = {}
    tasks: list[tuple[Any, ...]] = []
    for record in records:
        study = parse_stored(record.definition, record.digest)
        plan = plan_with_chunk(study, record.chunk, seconds_per_point)
        family = repr(study.settings())
        if record.reuse and family not in boxes:
            boxes[family] = Boxes(store, record)
        overlaps = Overlaps(store, record, boxes.get(family))
        path = store.cube_path(record.id)
        for block in map(plan.block, range(plan.count)):
            generation, sources = uuid.uuid4().hex[:12], overlaps.of(block)
            tasks.append((path, record.digest, block, code_hash(), generation, sources, identity))
    return tasks


def run_blocks(tasks: Sequence[tuple[Any, ...]]) -> list[BlockOutcome | None]:
    """Compute several blocks one after the other in a Dask task. The outcome of a failed block is None."""
    return [_attempted(task) for task in tasks]


def _attempted(task: tuple[Any, ...]) -> BlockOutcome | None:
    try:
        return run_block(*task)
    except Exception:
        return None  # a separate run computes the study again, and reports the error


def _ready(client: "Client", records: Sequence[Record]) -> bool:
    """Return whether every worker has all kernels that the studies need."""
    from damperlab.worker.run.on_cluster import all_ready

    wanted = (scenes(parse_stored(record.definition, record.digest)) for record in records)
    return all_ready(client, sorted({scene for some in wanted for scene in some}))


def _outcomes(
    client: "Client", futures: "Sequence[Future]", stop: threading.Event
) -> list[BlockOutcome | None]:
    """Wait for all tasks, and return the outcomes of their blocks. The outcome of a block without a result is None."""
    while not all(future.done() for future in futures):
        if stop.wait(POLL_SECONDS) or client.status != "running":
            break
    found: list[BlockOutcome | None] = []
    for future in futures:
        good = future.done() and future.status == "finished"
        found += future.result() if good else [None] * A_TASK
    return found
