"""Connects to a Dask cluster: a new cluster of local worker processes, or an existing scheduler."""

import asyncio
import logging
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import Any

import dask
from distributed import Client, Nanny, Security, SpecCluster, rpc
from distributed.core import Status
from distributed.system import MEMORY_LIMIT

from damperlab.worker.cluster.certificates import refusal, security
from damperlab.worker.cluster.scheduler import MONITORING, SchedulerProcess
from damperlab.worker.cores import core_count
from damperlab.worker.niceness import stand_back
from damperlab.worker.outcomes import ClusterUnusable, SchedulerLost

SCHEDULER_TIMEOUT_SECONDS = 10.0
"""Longest wait for an answer of an existing scheduler [s]."""
GOODBYE_TIMEOUT = "1s"
"""Longest wait for a connection to a scheduler that has died, in Dask's notation."""
START_TIMEOUT_SECONDS = 120.0
"""Longest wait for the start of local worker processes [s]. On a busy machine, importing numba takes long."""

_log = logging.getLogger(__name__)

ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS",
        "MKL_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "BLIS_NUM_THREADS",
        "NUMEXPR_NUM_THREADS",
        "NUMBA_NUM_THREADS",
    ),
    "1",
)
"""Environment variables of a worker. A kernel keeps one core busy, so libraries must not start further threads."""

_LOCAL_CONFIG = {
    **MONITORING,
    # A nanny restarts its worker. By default, Dask ends a nanny whose worker is not back within 15 s. On a busy machine
    # a restart takes longer, and the cluster would be left without workers.
    "distributed.deploy.lost-worker-timeout": "1 day",
    "distributed.nanny.pre-spawn-environ": {"MALLOC_TRIM_THRESHOLD_": "65536", **ONE_THREAD},
}


@contextmanager
def connect(workers: int | None = None, scheduler: str | None = None) -> Iterator[Client]:
    """Connect to an existing Dask cluster, or start a local cluster for the duration of the context.

    Parameters
    ----------
    workers : int, optional
        Number of worker processes of the local cluster, with one thread each; by default one per core that this process
        may use. The processes listen only on the loopback interface, and end with the context or with this process.
    scheduler : str, optional
        Address of an existing Dask scheduler to use instead of a local cluster, for example "tcp://host:8786". The
        scheduler and its workers continue to run after the context.

    Yields
    ------
    Client
        Client of the cluster. The client is not Dask's default client, so other code does not use it by accident.

    Raises
    ------
    ClusterUnusable
        If both `workers` and `scheduler` are given, the number of workers is below 1, or the scheduler does not answer.
    """
    if scheduler is not None:
        if workers is not None:
            raise ClusterUnusable(
                "workers",
                f"{workers}, together with scheduler {scheduler!r}",
                "one of the two",
                "leave `workers` out: the scheduler's own workers are used",
                "`workers` and `scheduler` cannot be combined.",
            )
        opened = _remote(scheduler)
    else:
        count = core_count() if workers is None else workers
        if count < 1:
            raise ClusterUnusable("workers", str(count), "1 or more", "leave it out to use every core")
        opened = _local(count)
    with opened as client:
        yield client


def dask_setup(worker: object) -> None:
    """Set up a worker of a local cluster: lower its priority, and let it ignore SIGINT.

    Dask calls this function when the worker starts. The lower priority prevents delays of the scheduler, the
    coordinator and the service. A terminal sends SIGINT to all processes. The coordinator then lets running blocks
    finish, but a worker that handled the signal would drop its block.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    stand_back()


@contextmanager
def _local(count: int) -> Iterator[Client]:
    shown = Security.temporary()  # the certificates exist only in memory
    worker = {
        "nthreads": 1,
        "host": "127.0.0.1",
        "protocol": "tls",
        "security": shown,
        "memory_limit": MEMORY_LIMIT // count,
        "silence_logs": logging.CRITICAL,
        "dashboard": False,
        "preload": ["damperlab.worker.cluster.cluster"],
    }
    with (
        dask.config.set(_LOCAL_CONFIG),
        without_workers(shown, worker) as cluster,
        closed_where_lost(cluster),
        _told_where_lost(cluster),
        Client(cluster, security=shown, set_as_default=False) as client,
    ):
        cluster.scale(count)
        client.wait_for_workers(count, timeout=START_TIMEOUT_SECONDS)
        cluster.sync(_watched, cluster)
        yield client


def without_workers(
    shown: Security, worker: dict[str, Any] | None = None, host: str = "127.0.0.1"
) -> SpecCluster:
    """Start a scheduler without workers. If Ctrl-C interrupts the later start of workers, the cluster is closed.

    The thread of the cluster blocks SIGINT, and the workers that the thread starts inherit this. Otherwise, Ctrl-C in
    a terminal would end a worker that still loads its modules. `dask_setup` makes a worker ignore SIGINT only after
    this.

    Parameters
    ----------
    shown : Security
        Certificates of the cluster.
    worker : dict, optional
        Options of the workers that the cluster starts when it is scaled; by default it starts none.
    host : str
        Name or address at which the scheduler listens.
    """
    resource_tracker.ensure_running()  # the thread that starts the tracker would unblock SIGINT
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        return SpecCluster(
            workers={},
            worker=worker and {"cls": Nanny, "options": worker},
            scheduler={"cls": SchedulerProcess, "options": {"security": shown, "host": host}},
            security=shown,
            silence_logs=logging.CRITICAL,
        )
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)


async def _watched(cluster: SpecCluster) -> None:
    """Wait until each worker is registered at its nanny, so that a nanny restarts any worker that ends."""
    await cluster


@contextmanager
def closed_where_lost(cluster: SpecCluster) -> Iterator[None]:
    """Close the cluster at the end of the context if its scheduler has died.

    Without this context, `SpecCluster` would raise an error before it closes the workers.
    """
    try:
        yield
    finally:
        if cluster.scheduler.lost:
            cluster.scheduler.status = Status.failed
            with dask.config.set({"distributed.comm.timeouts.connect": GOODBYE_TIMEOUT}):
                cluster.close()


@contextmanager
def _told_where_lost(cluster: SpecCluster) -> Iterator[None]:
    """Raise `SchedulerLost` instead of one of Dask's various errors if the scheduler has died."""
    try:
        yield
    except (OSError, TimeoutError, ValueError) as error:
        if cluster.scheduler.is_lost_within(1.0):
            raise SchedulerLost from error
        raise


@contextmanager
def _remote(address: str) -> Iterator[Client]:
    try:
        shown = security(address=address)
        asyncio.run(_probe(address, shown))
    # For an invalid address, and for a server that is no scheduler, Dask raises exceptions of various classes.
    except ClusterUnusable:
        raise
    except Exception as error:
        why = refusal(error) or str(error) or f"no answer within {SCHEDULER_TIMEOUT_SECONDS:g} s"
        raise ClusterUnusable(
            "scheduler",
            f"{address!r} ({why})",
            "the address of a running Dask scheduler, as in tcp://host:8786",
            "start one with `dask scheduler`; set DAMPERLAB_CLUSTER_TLS if it requires certificates; or "
            "leave `scheduler` out to compute on this machine",
            f"No Dask scheduler can be used at {address}: {why}.",
        ) from error
    # Dask would log a traceback for a lost connection, although an exception reports the loss
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    try:
        opened = Client(address, security=shown, timeout=SCHEDULER_TIMEOUT_SECONDS, set_as_default=False)
    # ValueError is raised if a connection ends before it is encrypted
    except (OSError, TimeoutError, ValueError) as error:
        raise ClusterUnusable(
            "scheduler",
            f"one that was lost during the request ({error})",
            "a running Dask scheduler",
            "wait if it is about to come back; otherwise start one with `dask scheduler`",
            f"The scheduler was lost during the request ({error}).",
        ) from error
    with opened as client:
        yield client


async def _probe(address: str, shown: Security) -> None:
    # The address is checked before a Client is made, because a Client without a scheduler leaves threads behind.
    arguments = shown.get_connection_args("client")
    async with rpc(address, timeout=SCHEDULER_TIMEOUT_SECONDS, connection_args=arguments) as remote:
        answer = await asyncio.wait_for(remote.identity(), SCHEDULER_TIMEOUT_SECONDS)
    if answer["type"] != "Scheduler":
        raise ValueError(f"it is a Dask {answer['type'].lower()}")
