"""The main loop of a worker process. Before the worker exits, it completes or gives back its running block."""

import asyncio
import math
import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

import dask
from distributed import Security, Worker
from distributed.core import Status

from damperlab.worker.cluster.cluster import ONE_THREAD
from damperlab.worker.cluster.scheduler import MONITORING
from damperlab.worker.worker_process.connecting import connected, say
from damperlab.worker.worker_process.examination import show_alive

LOOK_SECONDS = 0.2
"""Interval between checks for a reason to leave, and between checks of the remaining work [s]."""


@dataclass(frozen=True)
class Terms:
    """Conditions under which a worker leaves its cluster.

    Parameters
    ----------
    leave_within_s : float
        Longest time from the request to leave until the worker has ended [s]. A block that still runs after this time
        is given back.
    lifetime_s : float, optional
        Longest time from the start of the worker until it has left [s], for example the time limit of its
        batch job.
    notice : Path, optional
        File whose existence makes the worker leave. A program can create it before the machine shuts down.
    leave_idle_s : float, optional
        Time without a block, or without an answer of a scheduler, after which the worker leaves [s].
    alive : Path, optional
        File that the worker touches after each successful self-check. If a self-check fails, the worker leaves.
    """

    leave_within_s: float = 25.0
    lifetime_s: float | None = None
    notice: Path | None = None
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
    leave: asyncio.Future[str] = loop.create_future()

    def ask_to_leave(reason: str) -> None:
        if leave.done():
            # a second request to leave ends the process immediately
            os._exit(1)
        leave.set_result(reason)

    wrong: list[str] = []

    def give_up(reason: str) -> None:
        wrong.append(reason)
        if not leave.done():
            leave.set_result(reason)

    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, ask_to_leave, signal.Signals(number).name)
    # The task runs until the event loop ends. A worker that waits for a scheduler must touch the file, too.
    beside = []
    if terms.alive is not None:
        beside.append(asyncio.ensure_future(show_alive(terms.alive, give_up)))
    began = time.monotonic()
    reason = ""
    while not reason:
        worker = await connected(scheduler, security, leave, _patience(terms, began), memory_limit, name)
        if worker is None:
            return 0 if leave.done() and not wrong else 1
        async with worker:
            reason = await _until_asked(worker, leave, terms, began)
            if reason:
                await _leave(worker, reason, terms.leave_within_s)
            else:
                say(f"the scheduler at {scheduler} is lost; waiting for it to come back")
    return 1 if wrong else 0


def _patience(terms: Terms, began: float) -> float:
    """Return the longest time to wait for a scheduler from now on [s]."""
    lifetime = math.inf if terms.lifetime_s is None else began + terms.lifetime_s - time.monotonic()
    return max(0.0, min(lifetime, math.inf if terms.leave_idle_s is None else terms.leave_idle_s))


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


async def _until_asked(worker: Worker, leave: "asyncio.Future[str]", terms: Terms, began: float) -> str:
    """Wait until the worker must leave, and return the reason. Return an empty string if the scheduler is lost."""
    ends = None if terms.lifetime_s is None else began + max(0.0, terms.lifetime_s - terms.leave_within_s)
    busy = time.monotonic()
    while worker.status not in (Status.closing, Status.closed, Status.failed):
        done, _ = await asyncio.wait([leave], timeout=LOOK_SECONDS)
        if done:
            return leave.result()
        if ends is not None and time.monotonic() >= ends:
            return f"its lifetime of {terms.lifetime_s:g} s ends"
        if terms.notice is not None and terms.notice.exists():
            return f"the file {terms.notice} exists"
        if worker.state.tasks:
            busy = time.monotonic()
        elif terms.leave_idle_s is not None and time.monotonic() - busy > terms.leave_idle_s:
            return f"no block has come for {terms.leave_idle_s:g} s"
    return ""


def serve_worker(
    scheduler: str, security: Security, terms: Terms, memory_limit: str = "auto", name: str | None = None
) -> None:
    """Run a worker until it is asked to leave, then end the process; see `work`."""
    os.environ.update(ONE_THREAD)
    with dask.config.set({**MONITORING, "distributed.comm.timeouts.connect": "10s"}):
        status = asyncio.run(work(scheduler, security, terms, memory_limit, name))
    # the interpreter could not end normally while a kernel still runs in a thread
    os._exit(status)
