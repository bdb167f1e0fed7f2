"""Computes answers to requests in separate processes. A process is ended at its limits, or when the client has left."""

import contextlib
import ctypes
import logging
import resource
import signal
import sys
import time
from collections.abc import Awaitable, Callable
from typing import TypeVar, TypeVarTuple

from anyio import (
    BrokenWorkerProcess,
    CapacityLimiter,
    create_task_group,
    fail_after,
    move_on_after,
    to_process,
)
from starlette.requests import ClientDisconnect, Request

from damperlab.service.problems import RETRY_SECONDS, Problem
from damperlab.service.security.caller import counted_under
from damperlab.service.work.turns import TooManyWaiting, Turns
from damperlab.studies.faults import Fault, counted
from damperlab.worker.niceness import stand_back

WAITING = 64
"""Largest number of waiting requests of one caller."""

Result = TypeVar("Result")
Arguments = TypeVarTuple("Arguments")

_log = logging.getLogger("damperlab.work")
_PR_SET_PDEATHSIG = 1


class Work:
    """Processes that compute answers to requests. The processes stay alive between requests, with all modules imported.

    Parameters
    ----------
    at_once : int
        Largest number of processes that one caller may use. One further process is left for other callers.
    seconds : float
        Largest processor time of one request [s].
    wait_seconds : float
        Longest time from the start of a computation to its result [s]. A longer time means that the machine is busy.
    memory_bytes : int
        Largest memory of one process.
    """

    def __init__(self, at_once: int, seconds: float, wait_seconds: float, memory_bytes: int) -> None:
        self._turns = Turns(at_once + 1, WAITING, at_once)
        self._limiter = CapacityLimiter(at_once + 1)
        self._seconds = seconds
        self._wait_seconds = wait_seconds
        self._memory_bytes = memory_bytes

    async def run(
        self,
        request: Request,
        function: Callable[[*Arguments], Result],
        *arguments: *Arguments,
        shares: int = 1,
    ) -> Result:
        """Call a function in a process for a request whose body has been read.

        Parameters
        ----------
        request : Request
            The request. If its client disconnects, the computation is ended.
        function : callable
            Function that can be imported by name; the function, the arguments and the result are pickled.
        *arguments
            Arguments of the function.
        shares : int
            Factor by which the time limits are multiplied.

        Raises
        ------
        Problem
            422 if the computation would take more time or memory than a request may take; 429 if the caller has too
            many waiting requests; 503 if the machine is too busy.
        ClientDisconnect
            If the client leaves; the computation then ends.
        """
        who = counted_under(request.scope)
        seconds = shares * self._seconds

        async def work() -> Result:
            async with self._turns.turn(who):
                with move_on_after(shares * self._wait_seconds):
                    return await to_process.run_sync(
                        bounded,
                        seconds,
                        self._memory_bytes,
                        function,
                        arguments,
                        cancellable=True,
                        limiter=self._limiter,
                    )
            _log.warning("work for %s was ended: the machine is too busy", request.scope.get("request_id"))
            raise self._too_busy()

        try:
            return await while_there(request, work)
        except TooManyWaiting:
            fault = Fault(
                "requests",
                f"{WAITING} that wait",
                "fewer",
                f"try again in {RETRY_SECONDS} s",
                f"{WAITING} of your requests already wait to be computed, the most allowed.",
            )
            headers = {"Retry-After": str(RETRY_SECONDS)}
            raise Problem(
                429, "too-many-waiting", "Too many of your requests are already waiting.", (fault,), headers
            ) from None
        except BrokenWorkerProcess:
            # the system ends a process at the limit of processor time, or if memory is short
            _log.warning("work for %s was ended at its limit", request.scope.get("request_id"))
            found = f"more than {seconds:g} s of processor time, or more memory than the machine has"
            raise self._too_much(found, seconds) from None
        except MemoryError:
            found = f"more than {counted(self._memory_bytes >> 20, 'MiB')} of memory"
            raise self._too_much(found, seconds) from None

    def _too_much(self, found: str, seconds: float) -> Problem:
        fault = Fault(
            "request",
            found,
            f"at most {seconds:g} s of processor time and {self._memory_bytes >> 20} MiB for one request",
            "ask for less (fewer cycles or starts, a less stiff contact, a part of the grid), or compute it on the command "
            "line, which has no limit",
            f"The request took {found}; one request may take {seconds:g} s of processor time and "
            f"{self._memory_bytes >> 20} MiB.",
        )
        return Problem(422, "work-limit", "The computation exceeds the limits of a request.", (fault,))

    def _too_busy(self) -> Problem:
        waited = f"{self._wait_seconds:g} s"
        fault = Fault(
            "request",
            f"no answer after {waited}",
            f"an answer within {waited}",
            f"try again in {RETRY_SECONDS} s, or when less is being computed",
            f"The request has had less than {self._seconds:g} s of processor time in {waited}: the machine "
            "is busy, or its disk "
            "does not answer.",
        )
        headers = {"Retry-After": str(RETRY_SECONDS)}
        return Problem(503, "too-busy", "The machine is too busy to compute this.", (fault,), headers)

    async def start(self, prepare: Callable[[], None]) -> None:
        """Start one process, and let it import the solver in advance.

        Parameters
        ----------
        prepare : callable
            Function that imports the needed modules; it must be importable by name.
        """
        with contextlib.suppress(BrokenWorkerProcess, TimeoutError, OSError), fail_after(self._seconds):
            await to_process.run_sync(_begin, prepare, cancellable=True, limiter=self._limiter)


async def while_there(request: Request, work: Callable[[], Awaitable[Result]]) -> Result:
    """Await some work and return its result. If the client leaves before the work has ended, the work is cancelled.

    Raises
    ------
    ClientDisconnect
        If the client has left.
    """
    results: list[Result] = []
    errors: list[Exception] = []
    async with create_task_group() as group:

        async def do() -> None:
            try:
                results.append(await work())
            except Exception as error:
                errors.append(error)
            group.cancel_scope.cancel()

        group.start_soon(do)
        while (await request.receive())["type"] != "http.disconnect":
            pass
        group.cancel_scope.cancel()
    if errors:
        raise errors[0]
    if not results:
        raise ClientDisconnect
    return results[0]


def bounded(
    seconds: float,
    memory_bytes: int,
    function: Callable[[*Arguments], Result],
    arguments: tuple[*Arguments],
) -> Result:
    """Call a function in this process with limits of time and memory, which the operating system enforces."""
    _stand_back()
    used = time.process_time()
    _, most = resource.getrlimit(resource.RLIMIT_CPU)
    wanted = int(used + seconds) + 2
    resource.setrlimit(resource.RLIMIT_CPU, (wanted if most < 0 else min(wanted, most), most))
    _, most = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (memory_bytes if most < 0 else min(memory_bytes, most), most))
    try:
        return function(*arguments)
    finally:
        # remove the limit until the next request, so that imports between requests have no limit
        _, most = resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (most, most))


_stood_back = False


def _stand_back() -> None:
    """Lower the priority of this process, and let the system kill this process when the service ends."""
    global _stood_back
    if _stood_back:
        return
    _stood_back = True
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the service handles Ctrl-C, and ends this process
    stand_back()
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _begin(prepare: Callable[[], None]) -> None:
    _stand_back()
    prepare()
