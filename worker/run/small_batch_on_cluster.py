"""A batch of small studies run together on a cluster."""

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
    """Compute new studies of one block each, and return the ids of those that need a separate run.

    These are the unusual ones: their kernels must be compiled, they belong to another solver, or their block fails.

    Parameters
    ----------
    store : Store
        Where they were submitted.
    ids : sequence of str
        Their complete ids.
    client_factory : callable
        Makes a context that gives a client.
    stop : Event
        Set it from another thread: the wait then ends.
    """
    with client_factory() as client:
        try:
            answers: dict[str, dict[str, str]] = client.run(computing, on_error="ignore")
            identity = one_identity(answers)["identity"] if answers else ""
        except WrongCode:
            identity = ""
        # checked before any study is claimed, so that a study that waits for the compiler reports this
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
    """Compute one block after the other, as a Dask task. Its value has None for each block that failed."""
    outcomes: list[BlockOutcome | None] = []
    for arguments in several:
        try:
            outcomes.append(run_block(*arguments))
        except Exception:
            outcomes.append(None)  # in a run of its own, the study is tried again and reports its error
    return outcomes


def _ready(client: Client, records: Sequence[Record]) -> bool:
    """Whether the workers have every kernel that some studies need."""
    wanted = (scenes(parse_stored(record.definition, record.digest)) for record in records)
    return all_ready(client, sorted({scene for some in wanted for scene in some}))


def _outcomes(client: Client, futures: Sequence[Future], stop: threading.Event) -> list[BlockOutcome | None]:
    """Wait for all tasks; the outcome is None for those that failed, were lost or are no longer wanted."""
    while not all(future.done() for future in futures):
        if stop.wait(POLL_SECONDS) or client.status != "running":
            break
    found: list[BlockOutcome | None] = []
    for future in futures:
        good = future.done() and future.status == "finished"
        found += future.result() if good else [None] * A_TASK
    return found
