"""Connects a worker to its scheduler: finds the address at which it can be reached, and waits to be accepted."""

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
"""Interval between checks for a route to the scheduler."""
REFUSED_AGAIN_SECONDS = 5.0
"""Time after which a refused worker tries again, since the certificates of either side may have been renewed."""


async def own_host(scheduler: str, told: "asyncio.Future[str]", limit_seconds: float) -> str | None:
    """Give this machine's address on the route to the scheduler, once there is one; None if the wait is over.

    Without a route, the library would use the loopback address, at which nobody could reach the worker later.

    Parameters
    ----------
    scheduler : str
        Its address.
    told : Future
        Future that is done once the worker is asked to leave.
    limit_seconds : float
        Longest wait [s].
    """
    loop = asyncio.get_running_loop()
    parts = urlsplit(scheduler if "://" in scheduler else f"tcp://{scheduler}")
    began, waits = time.monotonic(), False
    while not told.done() and time.monotonic() - began < limit_seconds:
        with suppress(OSError):
            found = await loop.getaddrinfo(parts.hostname, parts.port, type=socket.SOCK_DGRAM)
            family, kind, protocol, _, address = found[0]
            with socket.socket(family, kind, protocol) as probe:
                # nothing is sent
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
    """Start a worker once its scheduler accepts it; False if the wait ends before that.

    Parameters
    ----------
    worker : Worker
        Not started yet.
    security : Security
        Its certificate.
    told, limit_seconds : Future, float
        As for `own_host`.
    """

    async def join() -> None:
        # if certificates do not match, the library would try ten times a second forever without reporting it
        await _let_in(worker.scheduler.address, security)
        await worker.start()

    # the library would wait forever, without noticing a request to leave
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
    """Wait until a scheduler accepts this worker."""
    said = ""
    while True:
        began = time.monotonic()
        try:
            # the certificates are read again at each attempt
            comm = await connect(scheduler, **security.get_connection_args("worker"))
        # the other side causes a value error if it sends before encryption has begun
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
