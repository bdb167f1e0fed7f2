"""The workers of a study: each is judged separately, and the blocks of a lost worker go to the others.

This is only the policy: which worker gets which block, what happens after a failed block, and what follows for its
worker. `damperlab.worker.dispatch.window` applies it to a cluster, and tests apply it to a model of a cluster of any
size.
"""

from collections import deque
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

from damperlab.studies.store.files.shelf import ShelfAway
from damperlab.worker.dispatch.backlog import Attempt, Backlog
from damperlab.worker.dispatch.worker_state import AGAIN_SECONDS, Patience, Standings, WorkerState
from damperlab.worker.outcomes import RETRIES, Crashed, Failure, Leaving, Outage, is_full
from damperlab.worker.provenance import WrongCode

BLOCKS_PER_THREAD = 2
"""Blocks at a worker per thread: one runs and one waits, so that no thread is idle while a result is sent."""


class Workers(Standings):
    """The workers of one study, and their blocks.

    Parameters
    ----------
    backlog : Backlog
        The unassigned blocks.
    """

    def __init__(self, backlog: Backlog) -> None:
        super().__init__()
        self.retries = 0
        """Number of blocks that were started again."""
        self.incidents: list[str] = []
        """Events of blocks, a sentence each without its full stop; the reader empties the list."""
        self._backlog = backlog
        self._again: deque[Attempt] = deque()
        self._where: dict[str, str] = {}
        # workers that have room, by the number of blocks per thread that they lack: few of thousands have room
        self._hungry: tuple[dict[str, None], ...] = tuple({} for _ in range(BLOCKS_PER_THREAD))
        self._patience = Patience()

    @property
    def waiting(self) -> int:
        """Number of unassigned blocks."""
        return len(self._again) + self._backlog.left

    @property
    def in_flight(self) -> int:
        """Blocks at workers."""
        return len(self._where)

    def see(self, threads: Mapping[str, int], running: Collection[str]) -> list[str]:
        """Update the present workers.

        Parameters
        ----------
        threads : mapping
            Number of threads of each present worker, by address.
        running : collection of str
            Workers that accept blocks; the others were asked to leave, or lack memory.

        Returns
        -------
        list of str
            Keys of tasks that will not be computed at their worker; their blocks are given to others.
        """
        lost = [key for address in self.states.keys() - threads.keys() for key in self.vanish(address)]
        for worker in self._meet(threads, running):
            # it completes its running blocks
            not_begun = list(worker.held)[worker.threads :]
            for key in not_begun:
                self._again.append(self._take(key))
            lost += not_begun
        return lost

    def take_away(self, now: float) -> list[str]:
        """Give each block that runs far too long to another worker, once. Its present worker is excluded until it
        passes a test.

        Parameters
        ----------
        now : float
            Time by the caller's clock [s].

        Returns
        -------
        list of str
            Keys of tasks whose results are no longer wanted.
        """
        lost: list[str] = []
        for worker, key, seconds in self._patience.overdue(self.states.values(), self._backlog.expected, now):
            attempt = worker.held.get(key)
            if attempt is None or attempt.moved or self._is_alone(worker):
                continue
            reason = f"block {attempt.index} has been there for {seconds:.0f} s and does not end"
            self.leave_out(worker.address, reason, now + AGAIN_SECONDS)
            for each in list(worker.held):
                taken = self._take(each)
                self._again.append(replace(taken.begun(), moved=True) if each == key else taken)
                lost.append(each)
        return lost

    def vanish(self, address: str) -> list[str]:
        """Remove a lost worker; give the keys of its tasks."""
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
            # the blocks that waited behind it were lost too, but did not cause this
            began = place < worker.threads and not known
            self._again.append(attempt.begun(apart=True) if began else attempt)
            if began:
                self.incidents.append(
                    f"block {attempt.index} was computed by worker {address}, which is gone"
                )
        for key in worker.held:
            del self._where[key]
        return list(worker.held)

    def admit(self, address: str) -> None:
        """Let a worker compute."""
        super().admit(address)
        for hungry in self._hungry:
            hungry[address] = None

    def assignments(self) -> Iterator[tuple[str, Attempt]]:
        """Give the blocks to send now, each with its worker. Call `sent` for each before the next."""
        trusted = any(one.usable and not one.against.doubtful for one in self.states.values())
        for depth, hungry in enumerate(self._hungry, 1):
            if not self.waiting or (depth > 1 and self._nears_end):
                return
            for address in list(hungry):
                worker = self.states.get(address)
                if worker is None or not worker.usable:
                    del hungry[address]
                    continue
                if trusted and worker.against.doubtful:
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
        """Give the worker of a task; None if it is lost."""
        return self._where.get(key)

    def ended(self, key: str) -> None:
        """Record that a block was computed, by its key. Earlier failures of it are then the fault of the workers at
        which it failed.
        """
        worker = self.states[self._where[key]]
        attempt = self._take(key)
        if worker.standing == "on trial":
            self.trust(worker)
        worker.against.unreadable = 0
        worker.against.blamed.clear()
        for address in attempt.avoid - {worker.address}:
            other = self.states.get(address)
            if other is not None and attempt.index in other.against.blamed:
                self._confirm(other, attempt.index)

    def give_back(self, key: str, apart: bool = False) -> None:
        """Record that a block was not computed, for a reason that is not its fault."""
        self._again.append(self._take(key).begun(apart))

    def failed(self, key: str, error: BaseException, now: float) -> Failure | None:
        """Decide what caused an exception: the worker, the block, or the study's data.

        Parameters
        ----------
        key : str
            Key of the task.
        error : BaseException
            The exception.
        now : float
            Time by the caller's clock [s].

        Returns
        -------
        Failure or None
            None if the block is tried again.

        Raises
        ------
        Outage
            There is no room for the study's data at any worker.
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
                # it may be a quota or a separate disk; the other workers show whether all are affected
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
            worker.against.blamed.add(attempt.index)
            worker.against.last_error = text
            again = replace(attempt.elsewhere(worker.address), errors=attempt.errors + 1)
        self._again.append(again)
        return None

    def _give_up(self, index: int, message: str) -> Failure:
        """Give up a block."""
        self.incidents.append(f"block {index} is given up: {message}")
        for each in self.states.values():
            each.against.blamed.discard(index)
        return Failure(index, message)

    def _is_alone(self, worker: WorkerState) -> bool:
        """Whether no other worker could take over this worker's blocks."""
        return all(one is worker for one in self.usable)

    @property
    def _nears_end(self) -> bool:
        """Whether so few blocks wait that a block queued behind another may be the last to end."""
        return self._backlog.left <= self._threads

    def _take(self, key: str) -> Attempt:
        address = self._where.pop(key)
        worker = self.states[address]
        attempt = worker.held.pop(key)
        for depth, hungry in enumerate(self._hungry, 1):
            if len(worker.held) < depth * worker.threads:
                hungry[address] = None
        return attempt

    def _next_for(self, worker: WorkerState) -> Attempt | None:
        """Choose a block for a worker: returned blocks first, but no block that failed there if another worker can
        compute it.
        """
        for place, attempt in enumerate(self._again):
            if worker.address not in attempt.avoid or attempt.avoid.issuperset(
                one.address for one in self.usable
            ):
                del self._again[place]
                return attempt
        index = self._backlog.take()
        return None if index is None else Attempt(index)
