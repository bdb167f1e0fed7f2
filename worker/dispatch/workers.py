"""Assigns blocks to workers. Blocks of a lost worker are assigned to other workers.

This module decides which worker gets which block, whether a failed block is tried again, and whether a worker is
excluded. `damperlab.worker.dispatch.window` applies the decisions to a cluster.
"""

from collections import deque
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damperlab.studies.store.files.shelf import ShelfAway
from damperlab.worker.dispatch.worker_state import AGAIN_SECONDS, Attempt, Standings, WorkerState
from damperlab.worker.outcomes import RETRIES, Crashed, Failure, Leaving, Outage, is_full
from damperlab.worker.provenance import WrongCode

BLOCKS_PER_THREAD = 2
"""Number of blocks that a worker has per thread. A second block starts as soon as the first block has ended."""

STUCK_SECONDS, STUCK_TIMES = 600.0, 100.0
"""A block is moved to another worker after the longer of `STUCK_SECONDS` and `STUCK_TIMES` times its expected time."""
LONGER_TIMES = 10.0
"""Factor by which this time grows with each earlier move. So a block that takes long is computed in the end."""


class Workers(Standings):
    """The workers of one study, and the blocks assigned to them.

    Parameters
    ----------
    indices : array of int
        Indices of the blocks to compute, in the order in which they are assigned.
    seconds : array of float, optional
        Expected time of each block of the study [s], by the block's index; by default 1 s for every block.
    """

    def __init__(self, indices: ArrayLike, seconds: NDArray[np.float64] | None = None) -> None:
        super().__init__()
        self.retries = 0
        """Number of repeated attempts to compute a block."""
        self.incidents: list[str] = []
        """Unreported messages about failed or lost blocks. The messages end without a full stop."""
        self._new = deque(np.asarray(indices, dtype=np.int64).tolist())
        self._seconds = seconds
        self._again: deque[Attempt] = deque()
        self._where: dict[str, str] = {}
        # The n-th dict contains the addresses of workers with fewer than n blocks per thread, so no search is needed.
        self._hungry: tuple[dict[str, None], ...] = tuple({} for _ in range(BLOCKS_PER_THREAD))
        # time at which `take_away` first saw each running task
        self._since: dict[str, float] = {}

    @property
    def waiting(self) -> int:
        """Number of unassigned blocks."""
        return len(self._again) + len(self._new)

    @property
    def in_flight(self) -> int:
        """Number of blocks at workers."""
        return len(self._where)

    def see(self, threads: Mapping[str, int], running: Collection[str]) -> list[str]:
        """Update the present workers, and take blocks back from workers that are lost or leave.

        Parameters
        ----------
        threads : mapping
            Number of threads of each present worker, by address.
        running : collection of str
            Addresses of the present workers that accept blocks. The other present workers were asked to leave, or lack
            memory.

        Returns
        -------
        list of str
            Keys of the tasks whose blocks were taken back. The blocks will be given to other workers.
        """
        gone = self.states.keys() - threads.keys()
        lost = [key for address in gone for key in self.vanish(address, alone=len(gone) == 1)]
        for worker in self._meet(threads, running):
            # the leaving worker completes its running blocks
            not_begun = list(worker.held)[worker.threads :]
            for key in not_begun:
                self._again.append(self._take(key))
            lost += not_begun
        return lost

    def take_away(self, now: float) -> list[str]:
        """Take blocks back from workers at which a block runs far too long.

        A block stays at its worker if no other worker is usable, or if the block was moved before. A leaving worker
        loses its block even then, because the worker may never end. Each move multiplies the time limit of a block by
        `LONGER_TIMES`. A worker that is not leaving is excluded, and tested again after `AGAIN_SECONDS`.

        Returns
        -------
        list of str
            Keys of the tasks whose blocks were taken back. The caller must cancel these tasks.
        """
        lost: list[str] = []
        running = {key: one for one in self.states.values() for key in list(one.held)[: one.threads]}
        self._since = {key: self._since.get(key, now) for key in running}
        for key, worker in running.items():
            attempt = worker.held.get(key)
            leaves = worker.standing == "leaving"
            if attempt is None or (attempt.moves and not leaves):
                continue
            seconds = now - self._since[key]
            expected = 1.0 if self._seconds is None else self._seconds[attempt.index]
            if seconds <= max(STUCK_SECONDS, STUCK_TIMES * expected) * LONGER_TIMES**attempt.moves:
                continue
            # checked last, because `_is_alone` iterates over all workers
            if not leaves and self._is_alone(worker):
                continue
            reason = f"block {attempt.index} has been there for {seconds:.0f} s and does not end"
            if leaves:
                self.incidents.append(f"worker {worker.address} leaves, and {reason}")
            else:
                self.leave_out(worker.address, reason, now + AGAIN_SECONDS)
            for each in list(worker.held):
                taken = self._take(each)
                self._again.append(replace(taken.begun(), moves=taken.moves + 1) if each == key else taken)
                lost.append(each)
        return lost

    def vanish(self, address: str, alone: bool = True) -> list[str]:
        """Remove a lost worker, take its blocks back, and return the keys of its tasks.

        If other workers were lost at the same time, `alone` is false. Then their machine or their connection is the likely
        cause, so a block is tried in a separate process only after it was lost twice: that process takes a second to start.
        """
        worker = self.states.pop(address, None)
        if worker is None:
            return []
        self._threads -= worker.threads if worker.usable else 0
        known = worker.standing == "leaving"
        if worker.held and not known:
            self.news.append(
                f"worker {address} is gone; its {len(worker.held)} blocks are computed by others"
            )
        for place, attempt in enumerate(worker.held.values()):
            # only a running block may have caused the loss of the worker
            began = place < worker.threads and not known
            apart = alone or attempt.tries > 0
            self._again.append(attempt.begun(apart) if began else attempt)
            if began:
                self.incidents.append(
                    f"block {attempt.index} was not completed by worker {address}, which is gone"
                )
        for key in worker.held:
            del self._where[key]
        return list(worker.held)

    def admit(self, address: str) -> None:
        """Accept a worker that has passed its test. The worker can then get blocks."""
        super().admit(address)
        for hungry in self._hungry:
            hungry[address] = None

    def assignments(self) -> Iterator[tuple[str, Attempt]]:
        """Yield pairs of a worker's address and a block to send to the worker.

        The caller must call `sent` for each block before it requests the next block.
        """
        trusted = any(one.usable and not one.doubtful for one in self.states.values())
        for depth, hungry in enumerate(self._hungry, 1):
            if not self.waiting or (depth > 1 and self._nears_end):
                return
            for address in list(hungry):
                worker = self.states.get(address)
                if worker is None or not worker.usable:
                    del hungry[address]
                    continue
                if trusted and worker.doubtful:
                    continue
                while len(worker.held) < depth * worker.threads:
                    if not self.waiting or (depth > 1 and self._nears_end):
                        return
                    attempt = self._next_for(worker)
                    if attempt is None:
                        break
                    yield address, attempt
                else:
                    del hungry[address]

    def sent(self, key: str, address: str, attempt: Attempt) -> None:
        """Record the key under which a block was sent to a worker."""
        self.retries += attempt.tries > 0
        self.states[address].held[key] = attempt
        self._where[key] = address

    def at(self, key: str) -> str | None:
        """Return the address of the worker that has a task; None if the task was taken back or its worker is lost."""
        return self._where.get(key)

    def ended(self, key: str) -> None:
        """Record that the block of a task was computed.

        If the block failed at other workers before, those workers are considered the cause of the failures.
        """
        worker = self.states[self._where[key]]
        attempt = self._take(key)
        if worker.standing == "on trial":
            self.trust(worker)
        worker.unreadable = 0
        worker.blamed.clear()
        for address in attempt.avoid - {worker.address}:
            other = self.states.get(address)
            if other is not None and attempt.index in other.blamed:
                self._confirm(other, attempt.index)

    def give_back(self, key: str) -> None:
        """Take back a block that has no result. This does not count as a failure of the block."""
        self._again.append(self._take(key).begun())

    def failed(self, key: str, error: BaseException, now: float) -> Failure | None:
        """Decide how to continue after the task of a block has raised an exception.

        Depending on the exception, the worker is excluded, and the block is tried again or given up.

        Returns
        -------
        Failure or None
            The failure if the block is given up; None if the block will be tried again.

        Raises
        ------
        Outage
            If no worker has space for the study's data.
        """
        worker = self.states[self._where[key]]
        attempt = self._take(key).begun()
        text = f"{type(error).__name__}: {error}"
        self.incidents.append(f"block {attempt.index} was not computed by worker {worker.address}: {text}")
        if isinstance(error, Leaving):
            again = attempt
        elif isinstance(error, WrongCode):
            self.leave_out(worker.address, str(error))
            again = attempt
        elif isinstance(error, OSError):
            again = attempt.elsewhere(worker.address)
            if is_full(error):
                reason = f"there is no room for the study's data ({text})"
                if self._is_alone(worker):
                    self._again.append(again)
                    raise Outage(reason) from error
                # the cause may be a quota or a disk of this worker, so the block is tried at other workers
                self.leave_out(worker.address, reason, now + AGAIN_SECONDS)
            else:
                self._cannot_read(worker, text, now, at_once=isinstance(error, ShelfAway))
        elif isinstance(error, Crashed):
            if attempt.crashes == RETRIES:
                return self._give_up(attempt.index, f"its process died {attempt.crashes + 1} times ({error})")
            again = replace(attempt.elsewhere(worker.address), crashes=attempt.crashes + 1)
        else:
            if attempt.errors == RETRIES:
                return self._give_up(attempt.index, text)
            worker.blamed.add(attempt.index)
            worker.last_error = text
            again = replace(attempt.elsewhere(worker.address), errors=attempt.errors + 1)
        self._again.append(again)
        return None

    def _give_up(self, index: int, message: str) -> Failure:
        """Record that a block is given up, and return its failure."""
        self.incidents.append(f"block {index} is given up: {message}")
        for each in self.states.values():
            each.blamed.discard(index)
        return Failure(index, message)

    def _is_alone(self, worker: WorkerState) -> bool:
        """Return whether no other worker can take over this worker's blocks."""
        return all(one is worker for one in self.usable)

    @property
    def _nears_end(self) -> bool:
        """Whether so few blocks are left that a second block per thread might delay the end of the study."""
        return len(self._new) <= 2 * self._threads

    def _take(self, key: str) -> Attempt:
        address = self._where.pop(key)
        worker = self.states[address]
        attempt = worker.held.pop(key)
        for depth, hungry in enumerate(self._hungry, 1):
            if len(worker.held) < depth * worker.threads:
                hungry[address] = None
        return attempt

    def _next_for(self, worker: WorkerState) -> Attempt | None:
        """Return the next block for a worker; None if there is no block for this worker.

        Blocks that were taken back come first. A block that failed at this worker is chosen only if it has failed at
        all other usable workers too.
        """
        for place, attempt in enumerate(self._again):
            if worker.address not in attempt.avoid or attempt.avoid.issuperset(
                one.address for one in self.usable
            ):
                del self._again[place]
                return attempt
        return Attempt(self._new.popleft()) if self._new else None
