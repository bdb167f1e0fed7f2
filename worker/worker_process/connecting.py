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


async def own_host(scheduler: str, told: "asyncio.Future[str]", limit_seconds: float) -> str | None:
    """Wait for a route to the scheduler, and return the address of this machine on that route.

    Without a route, Dask would use the loopback address, and other machines could not reach the worker later.

    Parameters
    ----------
    scheduler : str
        Address of the scheduler.
    told : Future
        Future that is done when the worker is asked to leave.
    limit_seconds : float
        Longest wait [s].

    Returns
    -------
    str or None
        The address. None if the worker was asked to leave, or there was no route within the limit.
    """
    loop = asyncio.get_running_loop()
    parts = urlsplit(scheduler if "://" in scheduler else f"tcp://{scheduler}")
    began, waits = time.monotonic(), False
    while not told.done() and time.monotonic() - began < limit_seconds:
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
        await asyncio.wait([told], timeout=ASK_AGAIN_SECONDS)
    say(f"leaving: there is no route to {scheduler}")
    return None


async def joined(
    worker: Worker, security: Security, told: "asyncio.Future[str]", limit_seconds: float
) -> bool:
    """Wait until the scheduler accepts connections of a worker, and start the worker.

    Parameters
    ----------
    worker : Worker
        The worker, which has not been started yet.
    security : Security
        TLS settings with the worker's certificate.
    told : Future
        Future that is done when the worker is asked to leave.
    limit_seconds : float
        Longest wait [s].

    Returns
    -------
    bool
        Whether the worker has started. False if the worker was asked to leave, or the limit has passed.
    """

    async def join() -> None:
        # if the certificates do not match, Dask would try to connect ten times a second for ever, without a message
        await _let_in(worker.scheduler.address, security)
        await worker.start()

    # Dask alone would wait for ever, even if the worker is asked to leave
    joining = asyncio.ensure_future(join())
    awaited: list[asyncio.Future[Any]] = [joining, told]
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
