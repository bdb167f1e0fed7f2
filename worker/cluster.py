"""A Dask cluster to compute on: worker processes of our own, or a scheduler that is there already."""

import asyncio
import logging
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import dask
from distributed import Client, LocalCluster, rpc
from distributed.system import MEMORY_LIMIT

from damperlab.studies.faults import Fault
from damperlab.worker.outcomes import ClusterUnusable
from damperlab.worker.provenance import identity

SCHEDULER_TIMEOUT_SECONDS = 10.0
"""How long a scheduler, and the first of its workers, may take to answer."""
START_TIMEOUT_SECONDS = 120.0
"""How long worker processes of our own may take to start; a loaded machine imports numba slowly."""

_ONE_THREAD = dict.fromkeys(
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

_LOCAL_CONFIG = {
    # One death makes a block suspect: the runner, not the scheduler, decides how often to try again.
    "distributed.scheduler.allowed-failures": 0,
    # The profiler samples every worker thread 100 times a second for a dashboard that is off.
    "distributed.worker.profile.enabled": False,
    "distributed.nanny.pre-spawn-environ": {"MALLOC_TRIM_THRESHOLD_": "65536", **_ONE_THREAD},
}


def core_count() -> int:
    """Cores that this process may use.

    Returns
    -------
    int
        At least 1; bounded by the process's affinity where the system has one.
    """
    cores = os.cpu_count() or 1
    if sys.platform == "linux":
        cores = min(cores, len(os.sched_getaffinity(0)))
    return max(1, cores)


@contextmanager
def connect(workers: int | None = None, scheduler: str | None = None) -> Iterator[Client]:
    """Client of a cluster in which every worker holds this code.

    Parameters
    ----------
    workers : int, optional
        Worker processes of an own cluster on the loopback interface, one thread each; by default one per core
        that this process may use. They end with the context, however it is left, and with this process.
    scheduler : str, optional
        Address of a Dask scheduler to use instead, as in "tcp://host:8786". It and its workers stay.

    Yields
    ------
    Client
        Not the process's default client: nothing outside the context picks it up.

    Raises
    ------
    ClusterUnusable
        Both or an impossible number were given, no scheduler or worker answers, or a worker holds other code.
    """
    if scheduler is not None:
        if workers is not None:
            raise ClusterUnusable(
                Fault(
                    "workers",
                    f"{workers}, together with scheduler {scheduler!r}",
                    "one of the two",
                    "leave `workers` out: the scheduler's own workers are used",
                )
            )
        opened = _remote(scheduler)
    else:
        count = core_count() if workers is None else workers
        if count < 1:
            raise ClusterUnusable(Fault("workers", str(count), "1 or more", "leave it out to use every core"))
        opened = _local(count)
    with opened as client:
        check_workers(client)
        yield client


def check_workers(client: Client) -> None:
    """Refuse a cluster in which a worker holds other code than this process.

    Parameters
    ----------
    client : Client
        Connected.

    Raises
    ------
    ClusterUnusable
        Naming the first odd worker, what it holds and what is expected.
    """
    mine = identity()
    try:
        answers: dict[str, Any] = client.run(identity, on_error="return")
    except (OSError, TimeoutError) as error:
        raise _lost(error) from error
    for address, answer in sorted(answers.items()):
        if isinstance(answer, BaseException):
            found = f"worker {address} cannot import it ({type(answer).__name__}: {answer})"
        elif (answer["version"], answer["sources"]) != (mine["version"], mine["sources"]):
            found = (
                f"worker {address} on {answer['host']} holds version {answer['version']} "
                f"with sources {answer['sources'][:12]}"
            )
        else:
            continue
        raise ClusterUnusable(
            Fault(
                "scheduler",
                found,
                f"version {mine['version']} with sources {mine['sources'][:12]} on every worker",
                "install the same damperlab there and restart the worker",
            )
        )


def dask_setup(worker: object) -> None:
    """Dask's hook as our own workers start: leave Ctrl-C to the coordinator.

    A terminal sends SIGINT to the whole process group. The coordinator then lets running blocks finish;
    workers that took it too would drop them, each with a traceback.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _local(count: int) -> Iterator[Client]:
    with (
        dask.config.set(_LOCAL_CONFIG),
        # Empty at first: an interrupt while the processes start then meets a cluster that the context closes.
        LocalCluster(
            n_workers=0,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            memory_limit=MEMORY_LIMIT // count,
            silence_logs=logging.CRITICAL,
            scheduler_kwargs={"dashboard": False, "dashboard_address": "127.0.0.1:0"},
            preload=["damperlab.worker.cluster"],
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        cluster.scale(count)
        client.wait_for_workers(count, timeout=START_TIMEOUT_SECONDS)
        yield client


@contextmanager
def _remote(address: str) -> Iterator[Client]:
    allowed = "the address of a running Dask scheduler, as in tcp://host:8786"
    try:
        asyncio.run(_probe(address))
    # Dask raises all kinds for an address that is none and for a server that is no scheduler.
    except Exception as error:
        raise ClusterUnusable(
            Fault(
                "scheduler",
                f"{address!r} ({str(error) or f'no answer within {SCHEDULER_TIMEOUT_SECONDS:g} s'})",
                allowed,
                "start one with `dask scheduler`, or leave `scheduler` out to compute on this machine",
            )
        ) from error
    try:
        opened = Client(address, timeout=SCHEDULER_TIMEOUT_SECONDS, set_as_default=False)
    except (OSError, TimeoutError) as error:
        raise _lost(error) from error
    with opened as client:
        try:
            client.wait_for_workers(1, timeout=SCHEDULER_TIMEOUT_SECONDS)
        except TimeoutError as error:
            raise ClusterUnusable(
                Fault(
                    "scheduler",
                    f"{address!r}, which has no workers",
                    allowed,
                    f"start one with `dask worker {address}` where damperlab is installed",
                )
            ) from error
        yield client


def _lost(error: Exception) -> ClusterUnusable:
    return ClusterUnusable(
        Fault(
            "scheduler",
            f"one that went away while it was asked ({error})",
            "a running Dask scheduler",
            "nothing need be done where it comes back; else start one with `dask scheduler`",
        )
    )


async def _probe(address: str) -> None:
    # A Client that finds no scheduler leaves its threads behind; this asks first and leaves nothing.
    async with rpc(address, timeout=SCHEDULER_TIMEOUT_SECONDS) as remote:
        answer = await asyncio.wait_for(remote.identity(), SCHEDULER_TIMEOUT_SECONDS)
    if answer["type"] != "Scheduler":
        raise ValueError(f"it is a Dask {answer['type'].lower()}")
