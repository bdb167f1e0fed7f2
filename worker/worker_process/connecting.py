"""Connects a worker to its scheduler."""

import asyncio
import socket
import sys
import time
from contextlib import suppress
from typing import Any
from urllib.parse import urlsplit

from distributed import Security, Worker
from distributed.comm import connect

from damperlab.worker.cluster.certificates import refusal

ASK_AGAIN_SECONDS = 1.0
"""Interval between checks for a route to the scheduler [s]."""
REFUSED_AGAIN_SECONDS = 5.0
"""Time after which a refused worker tries again [s], since the certificates may have been renewed meanwhile."""


async def connected(
    scheduler: str,
    security: Security,
    leave: "asyncio.Future[str]",
    limit_seconds: float,
    memory_limit: str,
    name: str | None,
) -> Worker | None:
    """Start a worker as soon as its scheduler can be reached.

    Parameters
    ----------
    scheduler, security, memory_limit, name
        See `damperlab.worker.worker_process.worker.work`.
    leave : Future
        Future that is done when the worker is asked to leave.
    limit_seconds : float
        Longest wait [s].

    Returns
    -------
    Worker or None
        The started worker. None if the worker was asked to leave, or no scheduler answered within the limit.
    """
    gives_up_at = time.monotonic() + limit_seconds
    while (left := gives_up_at - time.monotonic()) > 0.0:
        host = await _own_host(scheduler, leave, left)
        if host is None:
            return None
        worker = Worker(
            scheduler,
            host=host,
            nthreads=1,
            security=security,
            dashboard=False,
            memory_limit=memory_limit,
            name=name,
        )
        try:
            return worker if await _joined(worker, security, leave, left) else None
        # for example, the scheduler ends meanwhile, or it has not noticed yet that a worker with this name has left
        except (OSError, RuntimeError, ValueError) as error:
            say(f"{scheduler} did not accept this worker: {error}")
            await asyncio.wait([leave], timeout=REFUSED_AGAIN_SECONDS)
    say(f"leaving: no scheduler has answered at {scheduler}")
    return None


async def _own_host(scheduler: str, leave: "asyncio.Future[str]", limit_seconds: float) -> str | None:
    """Wait for a route to the scheduler, and return the address of this machine on that route.

    Without a route, Dask would use the loopback address, and other machines could not reach the worker later.
    """
    loop = asyncio.get_running_loop()
    parts = urlsplit(scheduler if "://" in scheduler else f"tcp://{scheduler}")
    began, waits = time.monotonic(), False
    while not leave.done() and time.monotonic() - began < limit_seconds:
        with suppress(OSError):
            found = await loop.getaddrinfo(parts.hostname, parts.port, type=socket.SOCK_DGRAM)
            family, kind, protocol, _, address = found[0]
            with socket.socket(family, kind, protocol) as probe:
                # a datagram socket sends nothing when it connects
                probe.connect(address)
                return str(probe.getsockname()[0])
        if not waits:
            waits = True
            say(f"there is no route to {scheduler} yet")
        await asyncio.wait([leave], timeout=ASK_AGAIN_SECONDS)
    say(f"leaving: there is no route to {scheduler}")
    return None


async def _joined(
    worker: Worker, security: Security, leave: "asyncio.Future[str]", limit_seconds: float
) -> bool:
    """Start a worker once the scheduler accepts its connections.

    Return False if the worker must leave, or after `limit_seconds`.
    """

    async def join() -> None:
        # if the certificates do not match, Dask would try to connect ten times a second for ever, without a message
        await _let_in(worker.scheduler.address, security)
        await worker.start()

    # Dask alone would wait for ever, even if the worker is asked to leave
    joining = asyncio.ensure_future(join())
    awaited: list[asyncio.Future[Any]] = [joining, leave]
    limit = limit_seconds if limit_seconds < float("inf") else None
    await asyncio.wait(awaited, timeout=limit, return_when=asyncio.FIRST_COMPLETED)
    if not joining.done():
        joining.cancel()
        say(f"leaving: no scheduler has answered at {worker.scheduler.address}")
        return False
    await joining
    return True


async def _let_in(scheduler: str, security: Security) -> None:
    """Wait until a scheduler accepts connections of this worker."""
    said = ""
    while True:
        began = time.monotonic()
        try:
            # each attempt reads the certificates from their files again
            comm = await connect(scheduler, **security.get_connection_args("worker"))
        # ValueError is raised if the other side sends data before the connection is encrypted
        except (OSError, ValueError) as error:
            why = refusal(error) or ("" if isinstance(error, OSError) else str(error))
        else:
            await comm.close()
            return
        if why and why != said:
            say(
                f"{scheduler} does not accept this worker: {why}; it is asked again every "
                f"{REFUSED_AGAIN_SECONDS:g} s"
            )
        said = why or said
        await asyncio.sleep(max(0.0, REFUSED_AGAIN_SECONDS - (time.monotonic() - began)))


def say(what: str) -> None:
    """Write a line to the worker's log."""
    print(f"damperlab worker: {what}", file=sys.stderr, flush=True)
