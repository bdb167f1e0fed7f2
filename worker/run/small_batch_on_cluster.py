"""Runs several small studies as one batch on a cluster."""

import threading
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress
from typing import Any

from distributed import Client, Future

from damperlab.studies.store.cube.definition import parse_stored
from damperlab.studies.store.record import BlockOutcome, Record
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.preparation import all_ready
from damperlab.worker.dispatch.tasks import sealed
from damperlab.worker.outcomes import Outage, asking_the_cluster
from damperlab.worker.provenance import WrongCode, computing, one_identity
from damperlab.worker.run.small_batch import hold, tasks_of
from damperlab.worker.scenes import scenes
from damperlab.worker.worker_process.tasks import run_block

A_TASK = 8
"""Number of studies in one task."""
POLL_SECONDS = 0.05


def run_small_studies(
    store: Store,
    ids: Sequence[str],
    client_factory: Callable[[], AbstractContextManager[Client]],
    stop: threading.Event,
) -> list[str]:
    """Compute new studies of one block each on a cluster.

    Parameters
    ----------
    store : Store
        Store that holds the studies.
    ids : sequence of str
        Full ids of the studies.
    client_factory : callable
        Returns a context manager that yields a client.
    stop : Event
        Event that another thread sets to end the wait for results.

    Returns
    -------
    list of str
        Ids of the studies that need a separate run, for example because kernels must be compiled or the block failed.
    """
    with client_factory() as client:
        try:
            answers: dict[str, dict[str, str]] = client.run(computing, on_error="ignore")
            identity = one_identity(answers)["identity"] if answers else ""
        except WrongCode:
            identity = ""
        # if kernels are missing, no study is claimed here, because only a separate run reports the compilation
        if not identity or store.trouble() is not None or not _ready(client, [store.find(ids[0])]):
            return list(ids)
        with hold(store, ids, identity) as (owner, records):
            if not records or not _ready(client, records):
                return list(ids)
            tasks = tasks_of(store, records, identity)
            futures = [
                client.submit(*sealed(run_blocks, tasks[start : start + A_TASK]), pure=False)
                for start in range(0, len(tasks), A_TASK)
            ]
            try:
                outcomes = _outcomes(client, futures, stop)
            finally:
                with suppress(Outage), asking_the_cluster(client):
                    client.cancel(futures)
            done = {record.id: end for record, end in zip(records, outcomes, strict=False) if end is not None}
            store.finish(owner, done)
    return [study_id for study_id in ids if study_id not in done]


def run_blocks(several: Sequence[tuple[Any, ...]]) -> list[BlockOutcome | None]:
    """Compute several blocks one after the other in a Dask task. The outcome of a failed block is None."""
    outcomes: list[BlockOutcome | None] = []
    for arguments in several:
        try:
            outcomes.append(run_block(*arguments))
        except Exception:
            outcomes.append(None)  # a separate run computes the study again, and reports the error
    return outcomes


def _ready(client: Client, records: Sequence[Record]) -> bool:
    """Return whether every worker has all kernels that the studies need."""
    wanted = (scenes(parse_stored(record.definition, record.digest)) for record in records)
    return all_ready(client, sorted({scene for some in wanted for scene in some}))


def _outcomes(client: Client, futures: Sequence[Future], stop: threading.Event) -> list[BlockOutcome | None]:
    """Wait for all tasks, and return the outcomes of their blocks. The outcome of a block without a result is None."""
    while not all(future.done() for future in futures):
        if stop.wait(POLL_SECONDS) or client.status != "running":
            break
    found: list[BlockOutcome | None] = []
    for future in futures:
        good = future.done() and future.status == "finished"
        found += future.result() if good else [None] * A_TASK
    return found
