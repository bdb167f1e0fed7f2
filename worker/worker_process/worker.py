"""The main loop of a worker process. Before the worker exits, it completes or gives back its running block."""

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
"""Interval between checks for a reason to leave, and between checks of the remaining work [s]."""
ASK_SECONDS = 5.0
"""Interval between requests to `Terms.notice_url` [s]. Clouds announce the end of a machine at least 30 s before."""
ANSWER_SECONDS = 2.0
"""Longest wait for the answer to a request to `Terms.notice_url` [s]."""
_NOT_YET = (b"false", b"none", b"")


@dataclass(frozen=True)
class Terms:
    """Conditions under which a worker leaves its cluster.

    Parameters
    ----------
    leave_within_s : float
        Longest time from the request to leave until the worker has ended [s]. A block that still runs after this time
        is given back.
    lifetime_s : float, optional
        Longest time from the start of the worker until it has left [s], for example the time of its job in a batch
        system.
    notice : Path, optional
        File whose existence makes the worker leave. A program that detects the end of the machine can create the file.
    notice_url : str, optional
        Web address that announces the end of the machine, see `announced`. The announcement makes the worker leave.
    leave_idle_s : float, optional
        Time without a block, or without an answer of a scheduler, after which the worker leaves [s].
    alive : Path, optional
        File that the worker touches after each successful self-check. If a self-check fails, the worker leaves.
    """

    leave_within_s: float = 25.0
    lifetime_s: float | None = None
    notice: Path | None = None
    notice_url: str | None = None
    leave_idle_s: float | None = None
    alive: Path | None = None


async def work(scheduler: str, security: Security, terms: Terms, memory_limit: str, name: str | None) -> int:
    """Run a worker until it is asked to leave. If the scheduler is lost, wait until it comes back.

    Parameters
    ----------
    scheduler : str
        Address of the scheduler.
    security : Security
        TLS settings with this worker's certificate.
    terms : Terms
        Conditions under which the worker leaves.
    memory_limit : str
        Memory limit in Dask's notation, for example "auto", "4GB", or "0" for no limit.
    name : str, optional
        Name of the worker.

    Returns
    -------
    int
        Exit status: 0 if the worker left on request, 1 if no scheduler answered in time or a self-check failed.
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

    # the self-checks begin before a scheduler is found, because a waiting worker must touch the file too
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
    """Return the longest time to wait for a scheduler from now on [s]."""
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
    """Return a started worker; None if the worker must leave, or no scheduler answers in time."""
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
        # for example, the scheduler ends meanwhile, or it has not noticed yet that a worker with this name has left
        except (OSError, RuntimeError, ValueError) as error:
            say(f"{scheduler} did not accept this worker: {error}")
            await asyncio.wait([told], timeout=REFUSED_AGAIN_SECONDS)
    say(f"leaving: no scheduler has answered at {scheduler}")
    return None


async def _leave(worker: Worker, reason: str, seconds: float) -> None:
    """Accept no more blocks, complete the running block or give it back, and close the worker within a time limit."""
    deadline = time.monotonic() + seconds
    say(f"leaving ({reason}): no more blocks, gone within {seconds:g} s")
    # with this status, the scheduler knows that this worker accepts no more tasks
    worker.status = Status.closing_gracefully
    # wait until the running blocks have ended and every result has been fetched
    while worker.state.tasks and time.monotonic() < deadline:
        await asyncio.sleep(LOOK_SECONDS)
    given_back = sum(1 for task in worker.state.executing if str(task.key).startswith("block-"))
    say(f"left; {given_back} blocks given back")
    await worker.close(timeout=2, executor_wait=False, reason=reason)


@asynccontextmanager
async def _asking(url: str | None, told: "asyncio.Future[str]") -> AsyncIterator[None]:
    """Within the context, set the result of `told` when a web address announces the end of the machine."""

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
    """Wait until the worker must leave, and return the reason. Return an empty string if the scheduler is lost."""
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
    """Return an error message if a string is no valid address for `Terms.notice_url`; None if it is valid."""
    try:
        parts = urlsplit(url)
        usable = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
    except ValueError:
        usable = False
    return None if usable else f"{url!r} is not an address of the form http://169.254.169.254/…"


def announced(url: str) -> bool:
    """Ask a web address whether this machine is about to end.

    Redirects are not followed, and no proxy is used.

    Parameters
    ----------
    url : str
        Address of the cloud provider's service for such notices.

    Returns
    -------
    bool
        Whether the status of the answer is 200 and the body is a notice. An empty body, FALSE or NONE is no notice.
    """
    parts = urlsplit(url)
    kind = HTTPSConnection if parts.scheme == "https" else HTTPConnection
    connection = kind(str(parts.hostname), parts.port, timeout=ANSWER_SECONDS)
    path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
    try:
        # Google's service refuses requests without this header
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
    """Run a worker until it is asked to leave, then end the process; see `work`."""
    os.environ.update(ONE_THREAD)
    settings = {"distributed.worker.profile.enabled": False, "distributed.comm.timeouts.connect": "10s"}
    with dask.config.set(settings):
        status = asyncio.run(work(scheduler, security, terms, memory_limit, name))
    # the interpreter could not end normally while a kernel still runs in a thread
    os._exit(status)
