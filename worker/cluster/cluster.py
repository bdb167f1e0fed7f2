"""A Dask cluster to compute on: our own worker processes, or an existing scheduler."""

import asyncio
import logging
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

import dask
from distributed import Client, Nanny, Security, SpecCluster, rpc
from distributed.core import Status
from distributed.system import MEMORY_LIMIT

from damperlab.studies.faults import Fault
from damperlab.worker.cluster.certificates import refusal, security
from damperlab.worker.cluster.scheduler import SchedulerProcess
from damperlab.worker.cores import core_count
from damperlab.worker.niceness import stand_back
from damperlab.worker.outcomes import ClusterUnusable, SchedulerLost

SCHEDULER_TIMEOUT_SECONDS = 10.0
"""Longest time until a scheduler, and the first of its workers, must answer."""
GOODBYE_TIMEOUT = "1s"
"""Time for the end of a dead scheduler, in Dask's notation."""
START_TIMEOUT_SECONDS = 120.0
"""Longest start of our own worker processes; a loaded machine imports numba slowly."""

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
"""Environment of a worker. A kernel keeps one core busy, so libraries must not start further threads."""

SCHEDULER_CONFIG = {
    # Dask suspects a block after one death of its worker; the runner, not the scheduler, decides how often to try
    # again.
    "distributed.scheduler.allowed-failures": 0,
}
"""Dask's settings in the process of our own scheduler."""
_LOCAL_CONFIG = {
    # The profiler samples every worker thread 100 times a second for a dashboard that is off.
    "distributed.worker.profile.enabled": False,
    "distributed.nanny.pre-spawn-environ": {"MALLOC_TRIM_THRESHOLD_": "65536", **ONE_THREAD},
}


@contextmanager
def connect(workers: int | None = None, scheduler: str | None = None) -> Iterator[Client]:
    """Connect to a cluster; each study checks which of the workers can compute for it.

    Parameters
    ----------
    workers : int, optional
        Worker processes of our own cluster on the loopback interface, one thread each; by default one per core that
        this process may use. They end with the context in any case, and with this process.
    scheduler : str, optional
        Address of a Dask scheduler to use instead, as in "tcp://host:8786". The scheduler and its workers are left
        running.

    Yields
    ------
    Client
        Not the process's default client, so nothing outside the context uses it.

    Raises
    ------
    ClusterUnusable
        Both `workers` and `scheduler` were given, the number of workers is impossible, or no scheduler answers.
    """
    if scheduler is not None:
        if workers is not None:
            raise ClusterUnusable(
                Fault(
                    "workers",
                    f"{workers}, together with scheduler {scheduler!r}",
                    "one of the two",
                    "leave `workers` out: the scheduler's own workers are used",
                    "`workers` and `scheduler` cannot be combined.",
                )
            )
        opened = _remote(scheduler)
    else:
        count = core_count() if workers is None else workers
        if count < 1:
            raise ClusterUnusable(Fault("workers", str(count), "1 or more", "leave it out to use every core"))
        opened = _local(count)
    with opened as client:
        yield client


def secret() -> Security:
    """Certificates for the cluster of one run, in memory: no process can join or call it without them.

    Returns
    -------
    Security
        Without the package cryptography nothing is encrypted, and a warning is logged.
    """
    if find_spec("cryptography") is None:
        _log.warning(
            "The package cryptography is missing, so the embedded cluster is unprotected: any process of "
            "this machine can reach it. Install damperlab[service] again."
        )
        return Security()
    return Security.temporary()


def dask_setup(worker: object) -> None:
    """Set up a worker of our own; Dask calls this when it starts. It runs at lower priority than the answering
    process, and leaves Ctrl-C to the coordinator.

    Scheduler, coordinator and service need little time, but without delay. A terminal sends SIGINT to the whole process
    group. The coordinator then lets running blocks finish; workers that handled it too would drop them, each with a
    traceback.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    stand_back()


@contextmanager
def _local(count: int) -> Iterator[Client]:
    shown = secret()
    worker = {
        "nthreads": 1,
        "host": "127.0.0.1",
        "protocol": "tls" if shown.require_encryption else "tcp",
        "security": shown,
        "memory_limit": MEMORY_LIMIT // count,
        "silence_logs": logging.CRITICAL,
        "dashboard": False,
        "preload": ["damperlab.worker.cluster.cluster"],
    }
    with (
        dask.config.set(_LOCAL_CONFIG),
        # The cluster starts empty, so that an interrupt while its processes start finds a cluster that the context
        # closes.
        SpecCluster(
            workers={},
            worker={"cls": Nanny, "options": worker},
            scheduler={
                "cls": SchedulerProcess,
                "options": {"security": shown, "config": SCHEDULER_CONFIG},
            },
            security=shown,
            silence_logs=logging.CRITICAL,
        ) as cluster,
        closed_where_lost(cluster),
        _told_where_lost(cluster),
        Client(cluster, security=shown, set_as_default=False) as client,
    ):
        cluster.scale(count)
        client.wait_for_workers(count, timeout=START_TIMEOUT_SECONDS)
        cluster.sync(_watched, cluster)
        yield client


async def _watched(cluster: SpecCluster) -> None:
    """Wait until every worker's watcher has registered it, since a worker that ends before is never restarted."""
    await cluster


@contextmanager
def closed_where_lost(cluster: SpecCluster) -> Iterator[None]:
    """Close a cluster whose scheduler has died; the library would first ask the scheduler, and stop half-way."""
    try:
        yield
    finally:
        if cluster.scheduler.lost:
            cluster.scheduler.status = Status.failed
            with dask.config.set({"distributed.comm.timeouts.connect": GOODBYE_TIMEOUT}):
                cluster.close()


@contextmanager
def _told_where_lost(cluster: SpecCluster) -> Iterator[None]:
    """Raise `SchedulerLost` if the scheduler has died, whatever error the library raises.

    For example, a connection that ends before it is encrypted is a ValueError.
    """
    try:
        yield
    except (OSError, TimeoutError, ValueError) as error:
        if cluster.scheduler.is_lost_within(1.0):
            raise SchedulerLost from error
        raise


@contextmanager
def _remote(address: str) -> Iterator[Client]:
    allowed = "the address of a running Dask scheduler, as in tcp://host:8786"
    try:
        shown = security(address=address)
        asyncio.run(_probe(address, shown))
    # Dask raises various exceptions for an invalid address and for a server that is no scheduler.
    except ClusterUnusable:
        raise
    except Exception as error:
        why = refusal(error) or str(error) or f"no answer within {SCHEDULER_TIMEOUT_SECONDS:g} s"
        raise ClusterUnusable(
            Fault(
                "scheduler",
                f"{address!r} ({why})",
                allowed,
                "start one with `dask scheduler`; set DAMPERLAB_CLUSTER_TLS if it requires certificates; or "
                "leave `scheduler` out to compute on this machine",
                f"No Dask scheduler can be used at {address}: {why}.",
            )
        ) from error
    # the library would log a traceback for a lost connection, which an exception reports
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    try:
        opened = Client(address, security=shown, timeout=SCHEDULER_TIMEOUT_SECONDS, set_as_default=False)
    except (
        OSError,
        TimeoutError,
        ValueError,
    ) as error:  # the last of these is raised if a connection ends before it is encrypted
        raise _lost(error) from error
    with opened as client:
        yield client


def _lost(error: Exception) -> ClusterUnusable:
    return ClusterUnusable(
        Fault(
            "scheduler",
            f"one that was lost during the request ({error})",
            "a running Dask scheduler",
            "wait if it is about to come back; otherwise start one with `dask scheduler`",
            f"The scheduler was lost during the request ({error}).",
        )
    )


async def _probe(address: str, shown: Security) -> None:
    # A Client that finds no scheduler leaves threads behind, so the address is checked first.
    arguments = shown.get_connection_args("client")
    async with rpc(address, timeout=SCHEDULER_TIMEOUT_SECONDS, connection_args=arguments) as remote:
        answer = await asyncio.wait_for(remote.identity(), SCHEDULER_TIMEOUT_SECONDS)
    if answer["type"] != "Scheduler":
        raise ValueError(f"it is a Dask {answer['type'].lower()}")
