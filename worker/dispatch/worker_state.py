"""The workers of a study: the standing of each, and its failures."""

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

from damperlab.studies.faults import counted
from damperlab.worker.dispatch.backlog import Attempt
from damperlab.worker.outcomes import RETRIES

_NEVER = math.inf
AGAIN_SECONDS = 15.0
"""Time after which an excluded worker is tested again: a store or a link may have recovered."""

STUCK_SECONDS, STUCK_TIMES = 600.0, 100.0
"""A block that runs longer than this time and this multiple of its expected time is given to another worker too."""

Standing = Literal["joining", "usable", "on trial", "leaving", "out"]
"""The standings of a worker: being tested; computing; computing again after an exclusion, before its first block has
ended; finishing its last blocks; excluded, with a reason.
"""
TOLD: dict[Standing, str] = {
    "joining": "joining",
    "usable": "usable",
    "on trial": "usable",
    "leaving": "leaving",
    "out": "out",
}
"""How each standing is reported."""
STANDINGS = tuple(dict.fromkeys(TOLD.values()))


@dataclass
class Suspicion:
    """Failures of a worker.

    Parameters
    ----------
    unreadable : int
        Consecutive failures to read or write the study's data.
    blamed : set of int
        Blocks that failed there for an unknown reason.
    confirmed : int
        Number of blocks that failed there and that another worker has since computed.
    last_error : str
        Error of the last such block at this worker.
    """

    unreadable: int = 0
    blamed: set[int] = field(default_factory=set)
    confirmed: int = 0
    last_error: str = ""

    @property
    def doubtful(self) -> bool:
        """Whether the worker has so many failures that it gets no blocks until their cause is known."""
        return len(self.blamed) > RETRIES


@dataclass
class WorkerState:
    """One worker.

    Parameters
    ----------
    address : str
        Where it is.
    threads : int
        Number of blocks that it computes in parallel.
    standing : str
        One of `Standing`.
    reason : str
        Reason for its present or earlier exclusion, or for its leaving.
    again_at : float
        Time of its next test, by the caller's clock.
    held : dict of Attempt
        Its blocks by task key, in the order of sending. A worker computes them in this order.
    against : Suspicion
        Its failures.
    compiled : bool
        Whether it has computed points, so that its kernels are compiled.
    """

    address: str
    threads: int
    standing: Standing = "joining"
    reason: str = ""
    again_at: float = 0.0
    held: dict[str, Attempt] = field(default_factory=dict)
    against: Suspicion = field(default_factory=Suspicion)
    compiled: bool = False

    @property
    def usable(self) -> bool:
        """Whether it computes."""
        return self.standing in ("usable", "on trial")


class Standings:
    """The present workers, by address, and events about them."""

    def __init__(self) -> None:
        self.states: dict[str, WorkerState] = {}
        self.news: list[str] = []
        self._threads = 0

    @property
    def usable(self) -> list[WorkerState]:
        """The workers that compute."""
        return [worker for worker in self.states.values() if worker.usable]

    @property
    def able(self) -> bool:
        """Whether any worker computes; one that must prove itself after an exclusion does not count."""
        return any(
            one.standing == "usable" or (one.held and one.standing in ("joining", "leaving"))
            for one in self.states.values()
        )

    def due(self, now: float) -> Iterator[WorkerState]:
        """Give the workers that are due for a test."""
        for worker in self.states.values():
            if worker.standing in ("joining", "out") and worker.again_at <= now:
                yield worker

    def admit(self, address: str) -> None:
        """Let a worker compute."""
        worker = self.states.get(address)
        if worker is None or worker.standing not in ("joining", "out"):
            return
        if worker.standing == "out":
            self.news.append(f"worker {address} is used again")
        if worker.standing == "out":
            worker.standing = "on trial"  # it keeps the reason of its exclusion, which may still apply
        else:
            self.trust(worker)
        worker.against.unreadable = 0
        self._threads += worker.threads

    def trust(self, worker: WorkerState) -> None:
        """Accept a worker as computing."""
        worker.standing, worker.reason = "usable", ""

    def leave_out(self, address: str, reason: str, again_at: float = _NEVER) -> None:
        """Exclude a worker; it may still finish its blocks.

        Parameters
        ----------
        address : str
            The worker.
        reason : str
            Reason, a sentence without its full stop.
        again_at : float
            Time of the next test.
        """
        worker = self.states.get(address)
        if worker is None or worker.standing == "leaving":
            return
        if (worker.standing, worker.reason) != ("out", reason):
            self.news.append(f"worker {address} is left out: {reason}")
        worker.standing, worker.reason, worker.again_at = "out", reason, again_at
        self._count()

    def examine_again(self) -> None:
        """Let no usable worker compute before it has been tested again."""
        for worker in self.usable:
            worker.standing, worker.again_at = "joining", 0.0
        self._count()

    def words(self) -> str:
        """Describe the present workers to the user of a waiting study."""
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
        """Count the workers by their standing, as reported."""
        found = [TOLD[worker.standing] for worker in self.states.values()]
        return tuple((standing, found.count(standing)) for standing in STANDINGS)

    def take_news(self) -> list[str]:
        """Give the events about workers since the last call, a sentence each without its full stop."""
        news, self.news = self.news, []
        return news

    def left_out(self) -> list[WorkerState]:
        """Give the excluded workers."""
        return [worker for worker in self.states.values() if worker.standing == "out"]

    def reasons(self) -> str:
        """Name the excluded workers with the reasons; empty if there is none."""
        return _some([f"{worker.address}: {worker.reason}" for worker in self.left_out()])

    def _cannot_read(self, worker: WorkerState, text: str, now: float, at_once: bool) -> None:
        worker.against.unreadable += 1
        # the worker has already retried for a while if the store was absent
        if at_once or worker.against.unreadable > RETRIES:
            reason = f"it cannot read or write the study's data ({text})"
            self.leave_out(worker.address, reason, now + AGAIN_SECONDS)

    def _confirm(self, worker: WorkerState, index: int) -> None:
        """Count a block that failed at a worker and that another worker has since computed."""
        against = worker.against
        against.blamed.discard(index)
        against.confirmed += 1
        if against.confirmed > RETRIES:
            self.leave_out(
                worker.address,
                f"{against.confirmed} blocks failed there and nowhere else, the last with {against.last_error}",
            )

    def _meet(self, threads: Mapping[str, int], running: Collection[str]) -> list[WorkerState]:
        """Update the present workers; give those that take no more blocks."""
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
    """Join messages about workers; of many, only a few are given."""
    more = f"; and {len(told) - 3} more" if len(told) > 3 else ""
    return "; ".join(told[:3]) + more


class Patience:
    """Records since when each task has been at the head of its worker's queue."""

    def __init__(self) -> None:
        self._since: dict[str, float] = {}

    def overdue(
        self, states: Iterable[WorkerState], expected: Callable[[int], float], now: float
    ) -> Iterator[tuple[WorkerState, str, float]]:
        """Give the tasks that have run for too long.

        Parameters
        ----------
        states : iterable of WorkerState
            The workers; those that are leaving are ignored, since they will soon be gone.
        expected : callable
            Gives the expected time of a block [s].
        now : float
            By a monotonic clock [s].

        Yields
        ------
        worker, key, seconds : WorkerState, str, float
            The worker, the task, and the time for which it has been there [s].
        """
        running = {key: worker for worker in states for key in list(worker.held)[: worker.threads]}
        self._since = {key: self._since.get(key, now) for key in running}
        for key, worker in running.items():
            seconds = now - self._since[key]
            likely = expected(worker.held[key].index)
            if worker.standing != "leaving" and seconds > max(STUCK_SECONDS, STUCK_TIMES * likely):
                yield worker, key, seconds
