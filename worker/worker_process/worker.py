"""A worker process that leaves cleanly: when asked to leave, it takes no more blocks, completes or returns its block,
and exits.
"""

import asyncio
import math
import os
import signal
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from http.client import HTTPConnection, HTTPException, HTTPSConnection
from pathlib import Path
from urllib.parse import urlsplit

import dask
from distributed import Security, Worker
from distributed.core import Status

from damperlab.worker.cluster.cluster import ONE_THREAD
from damperlab.worker.worker_process.connecting import REFUSED_AGAIN_SECONDS, joined, own_host, say
from damperlab.worker.worker_process.self_check import show_alive

LOOK_SECONDS = 0.2
"""Interval between checks for a notice and of the remaining work."""
ASK_SECONDS = 5.0
"""Interval between requests for a notice from an address: notices come 30 to 120 s before the machine ends."""
ANSWER_SECONDS = 2.0
"""Longest time of a request for a notice."""
_NOT_YET = (b"false", b"none", b"")


@dataclass(frozen=True)
class Terms:
    """Conditions for leaving.

    Parameters
    ----------
    leave_within_s : float
        Longest time from the request to leave until the worker is gone [s]; a block that still runs then is returned.
    lifetime_s : float, optional
        It leaves before this time has passed [s], for example before a batch system ends it.
    notice : Path, optional
        It leaves once this file exists, which for example the watcher of a spot market creates.
    notice_url : str, optional
        It leaves once this address announces the end of the machine, see `announced`; empty for no address.
    leave_idle_s : float, optional
        It leaves after this time without a block, or without a scheduler that answers [s].
    alive : Path, optional
        Every few seconds it computes points with known values and then touches this file; if the values are wrong, it
        leaves.
    """

    leave_within_s: float = 25.0
    lifetime_s: float | None = None
    notice: Path | None = None
    notice_url: str | None = None
    leave_idle_s: float | None = None
    alive: Path | None = None


async def work(scheduler: str, security: Security, terms: Terms, memory_limit: str, name: str | None) -> int:
    """Work for a scheduler until asked to leave. If the scheduler is lost, wait for it and continue.

    Parameters
    ----------
    scheduler : str
        Its address.
    security : Security
        This worker's certificate.
    terms : Terms
        Conditions for leaving.
    memory_limit : str
        In Dask's notation: "auto", "4GB", "0" for none.
    name : str, optional
        Its name.

    Returns
    -------
    int
        Exit status: 0 if it left on request, 1 if no scheduler answered in time, or its results are wrong.
    """
    loop = asyncio.get_running_loop()
    told: asyncio.Future[str] = loop.create_future()

    def tell(reason: str) -> None:
        if told.done():
            # a second request to leave ends the process immediately
            os._exit(1)
        told.set_result(reason)

    wrong: list[str] = []

    def give_up(reason: str) -> None:
        wrong.append(reason)
        if not told.done():
            told.set_result(reason)

    # started before a scheduler is found, because a waiting worker is alive too
    showing = None if terms.alive is None else asyncio.ensure_future(show_alive(terms.alive, give_up))
    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, tell, signal.Signals(number).name)
    began = time.monotonic()
    async with _asking(terms.notice_url, told):
        reason = ""
        while not reason:
            worker = await _connected(scheduler, security, told, _patience(terms, began), memory_limit, name)
            if worker is None:
                return 0 if told.done() and not wrong else 1
            async with worker:
                reason = await _until_told(worker, told, terms, began)
                if reason:
                    await _leave(worker, reason, terms.leave_within_s)
                else:
                    say(f"the scheduler at {scheduler} is lost; waiting for it to come back")
    if showing is not None:
        showing.cancel()
    return 1 if wrong else 0


def _patience(terms: Terms, began: float) -> float:
    """Give the remaining wait for a scheduler [s]."""
    lifetime = math.inf if terms.lifetime_s is None else began + terms.lifetime_s - time.monotonic()
    return max(0.0, min(lifetime, math.inf if terms.leave_idle_s is None else terms.leave_idle_s))


async def _connected(
    scheduler: str,
    security: Security,
    told: "asyncio.Future[str]",
    limit_seconds: float,
    memory_limit: str,
    name: str | None,
) -> Worker | None:
    """Give a worker that its scheduler has accepted; None if that fails."""
    gives_up_at = time.monotonic() + limit_seconds
    while (left := gives_up_at - time.monotonic()) > 0.0:
        host = await own_host(scheduler, told, left)
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
            return worker if await joined(worker, security, told, left) else None
        # for example if the scheduler ends meanwhile, or has not yet noticed that a worker of this name has gone
        except (OSError, RuntimeError, ValueError) as error:
            say(f"{scheduler} did not accept this worker: {error}")
            await asyncio.wait([told], timeout=REFUSED_AGAIN_SECONDS)
    say(f"leaving: no scheduler has answered at {scheduler}")
    return None


async def _leave(worker: Worker, reason: str, seconds: float) -> None:
    """Take no more blocks, complete or return the running one, and exit within a time."""
    deadline = time.monotonic() + seconds
    say(f"leaving ({reason}): no more blocks, gone within {seconds:g} s")
    # the scheduler then reports that this worker takes no more tasks
    worker.status = Status.closing_gracefully
    # wait for running blocks, and until every result has been fetched
    while worker.state.tasks and time.monotonic() < deadline:
        await asyncio.sleep(LOOK_SECONDS)
    given_back = sum(1 for task in worker.state.executing if str(task.key).startswith("block-"))
    say(f"left; {given_back} blocks given back")
    await worker.close(timeout=2, executor_wait=False, reason=reason)


@asynccontextmanager
async def _asking(url: str | None, told: "asyncio.Future[str]") -> AsyncIterator[None]:
    """Ask an address for a notice, as long as the context lasts."""

    async def ask(url: str) -> None:
        while not told.done():
            if await asyncio.to_thread(announced, url) and not told.done():
                told.set_result(f"{url} announces the end of this machine")
            await asyncio.sleep(ASK_SECONDS)

    asking = None if url is None else asyncio.ensure_future(ask(url))
    try:
        yield
    finally:
        if asking is not None:
            asking.cancel()


async def _until_told(worker: Worker, told: "asyncio.Future[str]", terms: Terms, began: float) -> str:
    """Wait; give the reason for leaving, or empty if the scheduler was lost."""
    ends = None if terms.lifetime_s is None else began + max(0.0, terms.lifetime_s - terms.leave_within_s)
    busy = time.monotonic()
    while worker.status not in (Status.closing, Status.closed, Status.failed):
        done, _ = await asyncio.wait([told], timeout=LOOK_SECONDS)
        if done:
            return told.result()
        if ends is not None and time.monotonic() >= ends:
            return f"its lifetime of {terms.lifetime_s:g} s ends"
        if terms.notice is not None and terms.notice.exists():
            return f"the file {terms.notice} exists"
        if worker.state.tasks:
            busy = time.monotonic()
        elif terms.leave_idle_s is not None and time.monotonic() - busy > terms.leave_idle_s:
            return f"no block has come for {terms.leave_idle_s:g} s"
    return ""


def faulty(url: str) -> str | None:
    """Describe the fault of an address for notices; None if it is valid."""
    try:
        parts = urlsplit(url)
        usable = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
    except ValueError:
        usable = False
    return None if usable else f"{url!r} is not an address of the form http://169.254.169.254/…"


def announced(url: str) -> bool:
    """Ask whether this machine is about to be ended.

    Parameters
    ----------
    url : str
        The address answers 200 in this case, and another status before. An answer 200 with an empty body, FALSE or NONE
        is not a notice either. Redirects are not followed, and no proxy is used.

    Returns
    -------
    bool
        False also if nobody answers, since a notice is optional.
    """
    parts = urlsplit(url)
    kind = HTTPSConnection if parts.scheme == "https" else HTTPConnection
    connection = kind(str(parts.hostname), parts.port, timeout=ANSWER_SECONDS)
    path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
    try:
        # Google's address refuses requests without this header
        connection.request("GET", path, headers={"Metadata-Flavor": "Google"})
        answer = connection.getresponse()
        return answer.status == 200 and answer.read(64).strip().lower() not in _NOT_YET
    except (OSError, HTTPException):
        return False
    finally:
        connection.close()


def serve_worker(
    scheduler: str, security: Security, terms: Terms, memory_limit: str = "auto", name: str | None = None
) -> None:
    """Work until asked to leave, then end the process; see `work`."""
    os.environ.update(ONE_THREAD)
    settings = {"distributed.worker.profile.enabled": False, "distributed.comm.timeouts.connect": "10s"}
    with dask.config.set(settings):
        status = asyncio.run(work(scheduler, security, terms, memory_limit, name))
    # a kernel that still runs in its thread would prevent the interpreter from ending
    os._exit(status)
