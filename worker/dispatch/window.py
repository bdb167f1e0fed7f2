"""Keeps a limited number of blocks at the workers of a cluster. Each worker is tested before its first block."""

import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from math import inf

import numpy as np
from distributed import CancelledError, Client, Future, KilledWorker
from numpy.typing import ArrayLike, NDArray

from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.dispatch.examiner import Examiner
from damperlab.worker.dispatch.tasks import ANSWER_SECONDS, FETCH_SECONDS, Call, Tasks
from damperlab.worker.dispatch.workers import Workers
from damperlab.worker.outcomes import Failure, Outage
from damperlab.worker.worker_process.block_process import call_apart

LOOK_SECONDS = 1.0
"""Interval between checks of the present workers [s]."""
WAIT_SECONDS = 120.0
"""Default longest wait while no worker can compute [s]."""

Ended = BlockOutcome | Failure
"""Result of a block that will not be tried again."""


class Window:
    """Sends blocks to the workers of a cluster, and collects the results. Each worker gets only a few blocks at a time.

    Parameters
    ----------
    client : Client
        Client of the cluster.
    task : callable
        Called with the index of a block and a task key. It returns a tuple of the function that computes the block, and
        the arguments of this function.
    indices : array of int
        Indices of the blocks to compute, in the order in which they start.
    seconds : array of float, optional
        Expected time of each block of the study [s], by the block's index; by default 1 s for every block.
    wait_seconds : float
        Longest wait while no worker can compute [s].
    priority : int
        Priority of the blocks. If several blocks wait at a worker, the block with the highest priority starts first.
    """

    def __init__(
        self,
        client: Client,
        task: Callable[[int, str], Call],
        indices: ArrayLike,
        seconds: NDArray[np.float64] | None = None,
        *,
        wait_seconds: float = WAIT_SECONDS,
        priority: int = 0,
    ) -> None:
        self.workers = Workers(indices, seconds)
        self._tasks = Tasks(client, priority)
        self._examiner = Examiner(self.workers, self._tasks)
        self._task = task
        self._wait_seconds = wait_seconds
        self._flying: dict[str, Future] = {}
        self._looked = -inf
        self._able = time.monotonic()

    @property
    def empty(self) -> bool:
        """Whether no block is at a worker and no block waits for a worker."""
        return not self._flying and not self.workers.waiting

    @property
    def stranded(self) -> str | None:
        """Reason why no worker can compute; None if a block is at a worker or a worker can take blocks."""
        return None if self._flying or self.workers.usable else self.workers.words()

    @property
    def gives_up_at(self) -> float:
        """Time of the monotonic clock at which the wait for a usable worker ends [s]."""
        return self._able + self._wait_seconds

    def assemble(
        self, examination: Call, identity: str, truth: str, look_on: Callable[[], bool]
    ) -> dict[str, str] | None:
        """Test the present workers, and accept those that have the study's solver and compute the same bits.

        Workers that join later are tested in the same way. The test is the function
        `damperlab.worker.worker_process.examination.examine` with its arguments. `identity` and `truth` are
        passed to `Examiner.settle`.

        Returns
        -------
        dict of str or None
            Result of `computing()` at the accepted workers. None if `look_on` returned False between two checks.

        Raises
        ------
        Outage
            If no worker could compute for `wait_seconds`.
        """
        self._examiner.prepare(examination)
        # the wait starts anew, so that minutes of compilation since the last check do not count as waiting
        self._able = time.monotonic()
        # the present workers are checked immediately, even if the previous check was just now
        self._looked = -inf
        while True:
            answers = self._examiner.gather(self._look, look_on)
            facts = None if answers is None else self._examiner.settle(answers, identity, truth)
            if answers is None or facts is not None:
                return facts

    def fill(self) -> None:
        """Send blocks to all workers that can take more blocks.

        Raises
        ------
        Outage
            If the scheduler does not answer, or no worker could compute for `wait_seconds`.
        """
        self._look()
        for address, attempt in self.workers.assignments():
            key = self._tasks.key("block")
            call = self._task(attempt.index, key)
            self._flying[key] = self._tasks.send(key, address, (call_apart, *call) if attempt.apart else call)
            self.workers.sent(key, address, attempt)

    def collect(self, wait_seconds: float) -> Iterator[Ended]:
        """Yield the results of the blocks that have ended since the last call, in the order in which they ended.

        A block that will be tried again is not included. The first result is awaited for at most `wait_seconds`. After
        this time, the remaining results are left to the next call.

        Raises
        ------
        Outage
            If the connection to the scheduler is lost, or there is no space for the study's data.
        """
        for key in self._tasks.ended(wait_seconds):
            if key in self._flying:
                ended = self._end(key, self._flying.pop(key))
                if ended is not None:
                    yield ended
                if self._looked < 0.0:
                    return
            elif heard := self._examiner.heard(key):
                self._examiner.judge(*heard)

    def drain(self, grace_seconds: float) -> Iterator[Ended]:
        """Cancel the blocks that have not started, and yield the results of running blocks that end in time.

        Blocks that have not ended after `grace_seconds` are cancelled.
        """
        deadline = time.monotonic() + grace_seconds
        waiting = [key for one in self.workers.states.values() for key in list(one.held)[one.threads :]]
        self._drop(waiting)
        while self._flying and (left := deadline - time.monotonic()) > 0.0:
            yield from self.collect(min(left, 1.0))
            with suppress(Outage):
                self._look(examine=False)
        self.close()

    def close(self) -> None:
        """Cancel all blocks and tests that are still at workers."""
        self._drop(list(self._flying))
        self._examiner.close()

    def _drop(self, keys: list[str]) -> None:
        futures = []
        for key in keys:
            if key in self._flying:
                futures.append(self._flying.pop(key))
                if self.workers.at(key) is not None:
                    self.workers.give_back(key)
        self._tasks.drop(futures, "the block is not wanted there")

    def _end(self, key: str, future: Future) -> Ended | None:
        address = self.workers.at(key)
        if address is None:
            return None
        if future.status == "error":
            error = future.exception(timeout=ANSWER_SECONDS)
            if isinstance(error, KilledWorker):
                self._drop_lost(self.workers.vanish(address))
                return None
            return self.workers.failed(key, error, time.monotonic())
        try:
            outcome: BlockOutcome = future.result(timeout=FETCH_SECONDS)
        except TimeoutError:
            # the worker may be gone, so the next step checks which workers are present, then fetches the result again
            self._tasks.require_scheduler()
            self._flying[key] = future
            self._tasks.again(key)
            self._looked = -inf
            return None
        # any other exception means that the worker was lost before its result was fetched, or the block never started
        except (Exception, CancelledError):
            self._tasks.require_scheduler()
            self.workers.give_back(key)
            return None
        self.workers.ended(key)
        return outcome

    def _drop_lost(self, keys: list[str]) -> None:
        """Cancel tasks whose blocks were given to other workers."""
        self._tasks.drop([self._flying.pop(key) for key in keys if key in self._flying], "others compute it")

    def _look(self, examine: bool = True) -> None:
        now = time.monotonic()
        if now - self._looked < LOOK_SECONDS:
            return
        self._looked = now
        threads, running = self._tasks.workers()
        self._drop_lost(self.workers.see(threads, running))
        self._drop_lost(self.workers.take_away(now))
        self._examiner.forget(threads)
        if examine:
            self._examiner.ask(now)
        # while a worker compiles kernels for its test, the study does not count as waiting
        if self.workers.able or self._examiner.compiles:
            self._able = now
        elif now - self._able > self._wait_seconds:
            raise Outage(f"no worker could compute for {self._wait_seconds:g} s: {self.workers.words()}")
