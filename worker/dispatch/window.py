"""A bounded number of blocks at the workers of a cluster, each tested before its first block."""

import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from math import inf

from distributed import CancelledError, Client, Future, KilledWorker

from damperlab.studies.plan import Block
from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.dispatch.backlog import Backlog
from damperlab.worker.dispatch.examiner import Examiner
from damperlab.worker.dispatch.tasks import ANSWER_SECONDS, FETCH_SECONDS, Call, Tasks
from damperlab.worker.dispatch.workers import Workers
from damperlab.worker.outcomes import Failure, Outage
from damperlab.worker.worker_process.block_process import call_apart

LOOK_SECONDS = 1.0
"""Interval between checks of the present workers."""
WAIT_SECONDS = 120.0
"""Default wait of a study while no worker can compute."""

Ended = BlockOutcome | Failure
"""The end of a block."""


class Window:
    """Sends blocks to workers of a cluster that have room, and returns the results.

    Parameters
    ----------
    client : Client
        Of the cluster.
    task : callable
        Gives the call that computes the block of the given index under the given task key.
    backlog : Backlog
        The blocks.
    wait_seconds : float
        Longest wait while no worker can compute [s].
    priority : int
        Of two blocks that wait at a worker, the one with the higher priority starts first.
    """

    def __init__(
        self,
        client: Client,
        task: Callable[[int, str], Call],
        backlog: Backlog,
        *,
        wait_seconds: float = WAIT_SECONDS,
        priority: int = 0,
    ) -> None:
        self.workers = Workers(backlog)
        self._tasks = Tasks(client, priority)
        self._examiner = Examiner(self.workers, self._tasks)
        self._task = task
        self._wait_seconds = wait_seconds
        self._flying: dict[str, Future] = {}
        self._looked = -inf
        self._able = time.monotonic()

    @property
    def empty(self) -> bool:
        """Whether no block is at the cluster and none waits."""
        return not self._flying and not self.workers.waiting

    @property
    def idle(self) -> bool:
        """Whether no block is at the cluster."""
        return not self._flying

    @property
    def stranded(self) -> str | None:
        """Reason why no block is computed, if workers are missing; None while a block is computed."""
        return None if self._flying or self.workers.usable else self.workers.words()

    @property
    def gives_up_at(self) -> float:
        """End of the wait for workers while none can compute, by the monotonic clock [s]."""
        return self._able + self._wait_seconds

    def assemble(
        self,
        cube_path: str,
        digest: str,
        code: str,
        identity: str,
        canary: Block | None,
        truth: str,
        look_on: Callable[[], bool],
    ) -> dict[str, str] | None:
        """Test the present workers, and use those that agree. Later workers are tested in the same way.

        Parameters
        ----------
        cube_path, digest, code : str
            As for `damperlab.worker.worker_process.tasks.run_block`.
        identity : str
            Solver of the study; empty if the study has not started, to use the most frequent one.
        canary : Block, optional
            Points that every worker computes; None the first time, when kernels are still to be compiled.
        truth : str
            Their stored bits; empty if they are not stored, to use the answer of a majority of the workers.
        look_on : callable
            Called between checks; False ends the wait.

        Returns
        -------
        dict of str or None
            `computing()` of the workers; None if `look_on` ended the wait.

        Raises
        ------
        Outage
            No worker could compute for the given time.
        """
        self._examiner.prepare(cube_path, digest, code, canary)
        # compiling does not count as waiting: the first check after it comes minutes after the previous one
        self._able = time.monotonic()
        # present workers are tested immediately, even if the previous check was just now
        self._looked = -inf
        while True:
            answers = self._examiner.gather(self._look, look_on)
            facts = None if answers is None else self._examiner.settle(answers, identity, truth)
            if answers is None or facts is not None:
                return facts

    def fill(self) -> None:
        """Send blocks until every thread has enough.

        Raises
        ------
        Outage
            The scheduler does not answer, or no worker could compute for the given time.
        """
        self._look()
        for address, attempt in self.workers.assignments():
            key = self._tasks.key("block")
            call = self._task(attempt.index, key)
            self._flying[key] = self._tasks.send(key, address, (call_apart, *call) if attempt.apart else call)
            self.workers.sent(key, address, attempt)

    def collect(self, wait_seconds: float) -> Iterator[Ended]:
        """Return the blocks that have ended since the last call.

        Parameters
        ----------
        wait_seconds : float
            Longest wait for the first block, and for the call as a whole [s]. Further blocks are left to the next call,
            so that a large cluster receives new blocks meanwhile.

        Yields
        ------
        BlockOutcome or Failure
            In the order of their end. A block that will be tried again is not included.

        Raises
        ------
        Outage
            The scheduler is lost, or there is no room for the study's data.
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
        """Send no more blocks, drop those that have not started, and return those that end within a time.

        Parameters
        ----------
        grace_seconds : float
            Longest time for running blocks [s].

        Yields
        ------
        BlockOutcome or Failure
            As `collect` does.
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
        """Drop every block still at the cluster."""
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
            # the worker may be gone, so the present workers are checked; if it is present, the result is fetched again
            self._tasks.require_scheduler()
            self._flying[key] = future
            self._tasks.again(key)
            self._looked = -inf
            return None
        # whatever the library reports, the result was lost with its worker before it was fetched, or the block never
        # started
        except (Exception, CancelledError):
            self._tasks.require_scheduler()
            self.workers.give_back(key)
            return None
        self.workers.ended(key)
        return outcome

    def _drop_lost(self, keys: list[str]) -> None:
        """Drop tasks whose blocks were given to others."""
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
        # a worker that compiles before it answers does not count as missing
        if self.workers.able or self._examiner.compiles:
            self._able = now
        elif now - self._able > self._wait_seconds:
            raise Outage(f"no worker could compute for {self._wait_seconds:g} s: {self.workers.words()}")
