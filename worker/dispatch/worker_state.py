"""Standing, blocks and failures of each worker of a study."""

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from damperlab.studies.faults import counted
from damperlab.worker.outcomes import RETRIES

_NEVER = math.inf
AGAIN_SECONDS = 15.0
"""Time after which an excluded worker is tested again [s], since a store or a connection may have recovered."""

Standing = Literal["joining", "usable", "on trial", "leaving", "out"]
"""Standing of a worker. A joining worker is being tested, and a usable worker computes blocks. A leaving
worker takes no more blocks. An excluded worker is "out". When it passes a later test, it is "on trial" until
it has completed a block.
"""
STANDINGS = ("joining", "usable", "leaving", "out")
"""The reported standings. A worker on trial is reported as usable."""


@dataclass(frozen=True)
class Attempt:
    """An attempt to compute a block.

    Parameters
    ----------
    index : int
        Index of the block.
    errors, crashes : int
        Number of exceptions that the block has raised, and number of processes that crashed while computing the block.
    apart : bool
        Whether a separate process computes the block, because a worker was lost while computing the block. If the
        separate process crashes, the worker survives.
    avoid : frozenset of str
        Addresses of workers at which the block failed.
    tries : int
        Number of earlier attempts.
    moves : int
        Number of earlier attempts that ran far too long.
    """

    index: int
    errors: int = 0
    crashes: int = 0
    apart: bool = False
    avoid: frozenset[str] = frozenset()
    tries: int = 0
    moves: int = 0

    def begun(self, apart: bool = False) -> "Attempt":
        """Return the next attempt at the block; if `apart` is true, the attempt runs in a separate process."""
        return replace(self, tries=self.tries + 1, apart=self.apart or apart)

    def elsewhere(self, address: str) -> "Attempt":
        """Return a copy of this attempt that avoids the given worker."""
        return replace(self, avoid=self.avoid | {address})


@dataclass
class WorkerState:
    """State of one worker.

    Parameters
    ----------
    address : str
        Address of the worker.
    threads : int
        Number of blocks that the worker computes in parallel.
    standing : str
        Standing of the worker, one of `Standing`.
    reason : str
        Reason why the worker was excluded or leaves; empty for a usable worker.
    again_at : float
        Time of the worker's next test by the caller's clock [s].
    held : dict of Attempt
        Blocks sent to the worker by task key, in the order of their computation.
    compiled : bool
        Whether the worker has computed points, so that its kernels are compiled.
    unreadable : int
        Number of consecutive failures to read or write the study's data.
    blamed : set of int
        Indices of blocks that failed at this worker for an unknown reason.
    confirmed : int
        Number of blocks that failed at this worker and that another worker has computed since.
    last_error : str
        Error of the last block that failed at this worker for an unknown reason.
    """

    address: str
    threads: int
    standing: Standing = "joining"
    reason: str = ""
    again_at: float = 0.0
    held: dict[str, Attempt] = field(default_factory=dict)
    compiled: bool = False
    unreadable: int = 0
    blamed: set[int] = field(default_factory=set)
    confirmed: int = 0
    last_error: str = ""

    @property
    def usable(self) -> bool:
        """Whether the worker can get blocks."""
        return self.standing in ("usable", "on trial")

    @property
    def doubtful(self) -> bool:
        """Whether so many blocks failed at the worker that other workers get the next blocks."""
        return len(self.blamed) > RETRIES


class Standings:
    """The present workers of a study, and messages about events such as an exclusion."""

    def __init__(self) -> None:
        self.states: dict[str, WorkerState] = {}
        self.news: list[str] = []
        """Unreported messages about events, such as the exclusion of a worker, without a period at the end."""
        self._threads = 0

    @property
    def usable(self) -> list[WorkerState]:
        """Workers that can get blocks."""
        return [worker for worker in self.states.values() if worker.usable]

    @property
    def able(self) -> bool:
        """Whether a worker can compute. A worker with the standing "on trial" does not count."""
        return any(
            one.standing == "usable" or (one.held and one.standing in ("joining", "leaving"))
            for one in self.states.values()
        )

    def due(self, now: float) -> Iterator[WorkerState]:
        """Yield the workers whose next test is due at the time `now`."""
        for worker in self.states.values():
            if worker.standing in ("joining", "out") and worker.again_at <= now:
                yield worker

    def admit(self, address: str) -> None:
        """Accept a worker that has passed its test. The worker can then get blocks."""
        worker = self.states.get(address)
        if worker is None or worker.standing not in ("joining", "out"):
            return
        if worker.standing == "out":
            self.news.append(f"worker {address} is used again")
            worker.standing = "on trial"  # the reason of the exclusion is kept, since it may still apply
        else:
            self.trust(worker)
        worker.unreadable = 0
        self._threads += worker.threads

    def trust(self, worker: WorkerState) -> None:
        """Set the standing of a worker to usable."""
        worker.standing, worker.reason = "usable", ""

    def leave_out(self, address: str, reason: str, again_at: float = _NEVER) -> None:
        """Exclude a worker from new blocks. The worker may still finish the blocks that it has received.

        The reason is a sentence without a period at the end. The worker is tested again at the time `again_at` of the caller's
        clock; by default it is not tested again.
        """
        worker = self.states.get(address)
        if worker is None or worker.standing == "leaving":
            return
        if (worker.standing, worker.reason) != ("out", reason):
            self.news.append(f"worker {address} is left out: {reason}")
        worker.standing, worker.reason, worker.again_at = "out", reason, again_at
        self._count()

    def examine_again(self) -> None:
        """Require a new test of every usable worker before it gets more blocks."""
        for worker in self.usable:
            worker.standing, worker.again_at = "joining", 0.0
        self._count()

    def words(self) -> str:
        """Return a message for users that explains why no present worker can compute."""
        if not self.states:
            return "the cluster has no worker"
        told = [
            f"{worker.address} is left out: {worker.reason}"
            if worker.standing == "out"
            else f"{worker.address} leaves: {worker.reason}"
            if worker.standing == "leaving"
            else f"{worker.address} was left out and is tried again: {worker.reason}"
            if worker.standing == "on trial"
            else f"{worker.address} has not been examined yet"
            for worker in self.states.values()
            if worker.standing != "usable"
        ]
        if all(worker.standing == "joining" for worker in self.states.values()):
            return f"{counted(len(self.states), 'worker')} being examined"
        return f"none of the {len(self.states)} workers can compute: {_some(told)}"

    def standings(self) -> tuple[tuple[str, int], ...]:
        """Return each reported standing with the number of workers that have this standing."""
        found: list[str] = ["usable" if worker.usable else worker.standing for worker in self.states.values()]
        return tuple((standing, found.count(standing)) for standing in STANDINGS)

    def left_out(self) -> list[WorkerState]:
        """Return the excluded workers."""
        return [worker for worker in self.states.values() if worker.standing == "out"]

    def reasons(self) -> str:
        """Return a message that says which workers are excluded and why; empty if no worker is excluded."""
        return _some([f"{worker.address}: {worker.reason}" for worker in self.left_out()])

    def _cannot_read(self, worker: WorkerState, text: str, now: float, at_once: bool) -> None:
        worker.unreadable += 1
        # if the store was unreachable, the worker has already retried for a while
        if at_once or worker.unreadable > RETRIES:
            reason = f"it cannot read or write the study's data ({text})"
            self.leave_out(worker.address, reason, now + AGAIN_SECONDS)

    def _confirm(self, worker: WorkerState, index: int) -> None:
        """Count a block that failed only at this worker. Exclude the worker after more than `RETRIES` such blocks."""
        worker.blamed.discard(index)
        worker.confirmed += 1
        if worker.confirmed > RETRIES:
            self.leave_out(
                worker.address,
                f"{worker.confirmed} blocks failed there and nowhere else, the last with {worker.last_error}",
            )

    def _meet(self, threads: Mapping[str, int], running: Collection[str]) -> list[WorkerState]:
        """Update the states of the present workers, and return the workers that have begun to leave."""
        ending: list[WorkerState] = []
        for address, count in threads.items():
            worker = self.states.setdefault(address, WorkerState(address, count))
            worker.threads = count
            if address in running:
                if worker.standing == "leaving":
                    worker.standing, worker.reason = "joining", ""
            elif worker.standing != "leaving":
                worker.standing, worker.reason = "leaving", "it was asked to leave, or is short of memory"
                self.news.append(f"worker {address} takes no more blocks: {worker.reason}")
                ending.append(worker)
        self._count()
        return ending

    def _count(self) -> None:
        self._threads = sum(worker.threads for worker in self.usable)


def _some(told: list[str]) -> str:
    """Join the first three messages about workers, and count the other messages."""
    more = f"; and {len(told) - 3} more" if len(told) > 3 else ""
    return "; ".join(told[:3]) + more
