"""Who computes a study: workers are judged one by one, and what they leave behind goes to the others.

Policy alone, without a cluster: what is known of each worker, which block goes to whom, what becomes of a block that has
not ended well. `damperlab.worker.window` brings it to a cluster; a model of a cluster of any size drives it as well.
"""

import math
from collections import deque
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from damperlab.studies.store.shelf import ShelfAway
from damperlab.worker.backlog import Backlog
from damperlab.worker.outcomes import RETRIES, Crashed, Failure, Leaving, Outage, is_full
from damperlab.worker.provenance import WrongCode

BLOCKS_PER_THREAD = 2
"""Blocks at a worker per thread: one runs, one waits there, so that no thread idles while an answer travels."""
AGAIN_SECONDS = 15.0
"""After how long a worker that was left out is examined again: a store or a link may have come back."""
_NEVER = math.inf

Standing = Literal["joining", "usable", "leaving", "out"]
STANDINGS: tuple[Standing, ...] = ("joining", "usable", "leaving", "out")
"""Being examined; computing; finishing what it runs; left out, with a reason."""


@dataclass(frozen=True)
class Attempt:
    """A block on its way.

    Parameters
    ----------
    index : int
        Of the block.
    errors, crashes : int
        How often computing it raised an exception, and how often it is proven to have ended its process.
    apart : bool
        Compute it in a process of its own: a worker has vanished while it ran, and whether that was the block's doing is
        seen there, and seen without a worker being lost.
    avoid : frozenset of str
        Workers at which it failed.
    tries : int
        How often it was begun before.
    """

    index: int
    errors: int = 0
    crashes: int = 0
    apart: bool = False
    avoid: frozenset[str] = frozenset()
    tries: int = 0


@dataclass
class Member:
    """One worker.

    Parameters
    ----------
    address : str
        Where it is.
    threads : int
        How many blocks it computes side by side.
    standing : str
        One of `STANDINGS`.
    reason : str
        Why it is left out, or leaves.
    again_at : float
        When it is to be examined, by the caller's clock.
    held : dict of Attempt
        By task key, in the order in which they were sent; a worker computes them in that order.
    """

    address: str
    threads: int
    standing: Standing = "joining"
    reason: str = ""
    again_at: float = 0.0
    held: dict[str, Attempt] = field(default_factory=dict)
    unreadable: int = 0  # failures to read or write the study's data, in a row
    blamed: set[int] = field(default_factory=set)  # blocks that failed here, nobody knows yet by whose fault
    confirmed: int = 0  # of these, computed elsewhere since
    last_error: str = ""
    admitted: bool = False  # at any time: its kernels are compiled
    failing: bool = False  # left out since it last computed a block

    @property
    def doubtful(self) -> bool:
        """Whether so much has failed here that it should wait for a verdict."""
        return len(self.blamed) > RETRIES


class Crew:
    """The workers of one study, and its blocks among them.

    Parameters
    ----------
    backlog : Backlog
        The blocks that nobody computes yet.
    """

    def __init__(self, backlog: Backlog) -> None:
        self.members: dict[str, Member] = {}
        self.retries = 0
        """Blocks that were computed, or begun, again."""
        self.news: list[str] = []
        self._backlog = backlog
        self._again: deque[Attempt] = deque()
        self._where: dict[str, str] = {}
        # of thousands of workers few have room at a time
        self._hungry: dict[str, None] = {}
        self._threads = 0

    @property
    def usable(self) -> list[Member]:
        """The workers that compute."""
        return [member for member in self.members.values() if member.standing == "usable"]

    @property
    def able(self) -> bool:
        """Whether somebody computes; one that was left out and is used again has yet to show that it can."""
        return any(
            (one.standing == "usable" or one.held) and not one.failing for one in self.members.values()
        )

    @property
    def waiting(self) -> int:
        """Blocks that nobody computes."""
        return len(self._again) + self._backlog.left

    def see(self, threads: Mapping[str, int], running: Collection[str]) -> list[str]:
        """Take notice of the workers that are there.

        Parameters
        ----------
        threads : mapping
            Their threads, by address.
        running : collection of str
            Those that take blocks; the others have been told to leave, or are short of memory.

        Returns
        -------
        list of str
            Keys of tasks that will not be computed where they lie; their blocks are given to others.
        """
        lost = [key for address in self.members.keys() - threads.keys() for key in self.vanish(address)]
        for address, count in threads.items():
            member = self.members.setdefault(address, Member(address, count))
            member.threads = count
            if address not in running:
                lost += self.notice(address)
            elif member.standing == "leaving":
                member.standing, member.reason = "joining", ""
        self._count()
        return lost

    def vanish(self, address: str) -> list[str]:
        """Forget a worker that is gone; give the keys of its tasks."""
        member = self.members.pop(address, None)
        if member is None:
            return []
        if member.standing == "usable":
            self._threads -= member.threads
        known = member.standing == "leaving"
        if member.held and not known:
            self.news.append(
                f"worker {address} is gone; its {len(member.held)} blocks are computed by others"
            )
        for place, attempt in enumerate(member.held.values()):
            # it took what waited behind with it, which had no part in it
            began = place < member.threads and not known
            self._give_back(replace(attempt, apart=attempt.apart or began, tries=attempt.tries + began))
        for key in member.held:
            del self._where[key]
        return list(member.held)

    def due(self, now: float) -> Iterator[Member]:
        """Give the workers that are to be examined."""
        for member in self.members.values():
            if member.standing in ("joining", "out") and member.again_at <= now:
                yield member

    def admit(self, address: str) -> None:
        """Let a worker compute."""
        member = self.members.get(address)
        if member is not None and member.standing in ("joining", "out"):
            if member.standing == "out":
                self.news.append(f"worker {address} is used again")
            member.standing, member.reason, member.unreadable, member.admitted = "usable", "", 0, True
            self._hungry[address] = None
            self._threads += member.threads

    def leave_out(self, address: str, reason: str, again_at: float = _NEVER) -> None:
        """Let a worker compute no more; what it holds it may still end.

        Parameters
        ----------
        address : str
            Which.
        reason : str
            Why, a sentence without its end.
        again_at : float
            When to examine it again.
        """
        member = self.members.get(address)
        if member is None or member.standing == "leaving":
            return
        if (member.standing, member.reason) != ("out", reason):
            self.news.append(f"worker {address} is left out: {reason}")
        member.standing, member.reason, member.again_at, member.failing = "out", reason, again_at, True
        self._count()

    def notice(self, address: str) -> list[str]:
        """Hear that a worker takes nothing more: it ends what it runs, and what has not begun there goes to others.

        Returns
        -------
        list of str
            Keys of the tasks that have not begun.
        """
        member = self.members[address]
        if member.standing == "leaving":
            return []
        member.standing, member.reason = "leaving", "it was told to leave, or is short of memory"
        self.news.append(f"worker {address} takes no more blocks: {member.reason}")
        back = list(member.held)[member.threads :]
        for key in back:
            self._give_back(self._take(key))
        return back

    def assignments(self) -> Iterator[tuple[str, Attempt]]:
        """Give the blocks to send now, each with the worker; tell `sent` of each before the next is asked for."""
        trusted = any(not member.doubtful for member in self.members.values() if member.standing == "usable")
        for depth in range(1, BLOCKS_PER_THREAD + 1):
            hungry = list(self._hungry)
            if depth > 1:
                if self._backlog.nears_end(self._threads):
                    return
                # the longest of what waits goes where the least lies
                hungry.sort(key=self._held_seconds)
            for address in hungry:
                member = self.members.get(address)
                if member is None or member.standing != "usable":
                    del self._hungry[address]
                    continue
                if trusted and member.doubtful:
                    continue
                while len(member.held) < depth * member.threads:
                    if depth > 1 and self._backlog.nears_end(self._threads):
                        return
                    attempt = self._next_for(member)
                    if attempt is None:
                        break
                    yield address, attempt
                else:
                    if depth == BLOCKS_PER_THREAD:
                        del self._hungry[address]

    def sent(self, key: str, address: str, attempt: Attempt) -> None:
        """Hear under which key a block went to a worker."""
        self.retries += attempt.tries > 0
        self.members[address].held[key] = attempt
        self._where[key] = address

    def at(self, key: str) -> str | None:
        """Give the worker that holds a task; None where that is no more."""
        return self._where.get(key)

    def ended(self, key: str, kernel_seconds: float = 0.0) -> None:
        """Hear that a block is computed: who failed at it before is to blame.

        Parameters
        ----------
        key : str
            Of the task.
        kernel_seconds : float
            What it took in kernels [s]; 0 where that says nothing about the blocks beside it.
        """
        member = self.members[self._where[key]]
        attempt = self._take(key)
        self._backlog.learn(attempt.index, kernel_seconds)
        member.unreadable, member.failing = 0, member.standing == "out"
        member.blamed.clear()
        for address in attempt.avoid:
            other = self.members.get(address)
            if other is not None and other is not member and attempt.index in other.blamed:
                other.blamed.discard(attempt.index)
                other.confirmed += 1
                if other.confirmed > RETRIES:
                    self.leave_out(
                        address,
                        f"{other.confirmed} blocks failed there and nowhere else, the last with {other.last_error}",
                    )

    def give_back(self, key: str, apart: bool = False) -> None:
        """Hear that a block was not computed, by nobody's fault."""
        attempt = self._take(key)
        self._give_back(replace(attempt, apart=attempt.apart or apart, tries=attempt.tries + 1))

    def failed(self, key: str, error: BaseException, now: float) -> Failure | None:
        """Decide what an exception says: of the worker, of the block, or of the study's data.

        Parameters
        ----------
        key : str
            Of the task.
        error : BaseException
            What it ended with.
        now : float
            By the caller's clock.

        Returns
        -------
        Failure or None
            None where the block is tried again.

        Raises
        ------
        Outage
            There is no room for the study's data.
        """
        member = self.members[self._where[key]]
        attempt = self._take(key)
        attempt = replace(attempt, tries=attempt.tries + 1)
        text = f"{type(error).__name__}: {error}"
        if isinstance(error, Leaving):
            self._give_back(attempt)
        elif isinstance(error, WrongCode):
            self.leave_out(member.address, str(error))
            self._give_back(attempt)
        elif isinstance(error, OSError):
            if is_full(error):
                self._give_back(attempt)
                raise Outage(f"there is no room for the study's data ({text})") from error
            member.unreadable += 1
            # a store that is away was asked for a while already
            if isinstance(error, ShelfAway) or member.unreadable > RETRIES:
                self.leave_out(
                    member.address, f"it cannot read or write the study's data ({text})", now + AGAIN_SECONDS
                )
            self._give_back(replace(attempt, avoid=attempt.avoid | {member.address}))
        elif isinstance(error, Crashed):
            if attempt.crashes == RETRIES:
                return Failure(attempt.index, f"its process died {attempt.crashes + 1} times ({error})")
            self._give_back(
                replace(attempt, crashes=attempt.crashes + 1, avoid=attempt.avoid | {member.address})
            )
        else:
            if attempt.errors == RETRIES:
                for each in self.members.values():
                    each.blamed.discard(attempt.index)
                return Failure(attempt.index, text)
            member.blamed.add(attempt.index)
            member.last_error = text
            self._give_back(
                replace(attempt, errors=attempt.errors + 1, avoid=attempt.avoid | {member.address})
            )
        return None

    def words(self) -> str:
        """Say who is there, for somebody who waits."""
        if not self.members:
            return "the cluster has no worker"
        told = [
            f"{member.address} is left out: {member.reason}"
            if member.standing == "out"
            else f"{member.address} leaves: {member.reason}"
            if member.standing == "leaving"
            else f"{member.address} has not been examined yet"
            for member in self.members.values()
            if member.standing != "usable"
        ]
        return f"none of the {len(self.members)} workers can compute: {_some(told)}"

    def standings(self) -> tuple[tuple[str, int], ...]:
        """Count the workers by their standing."""
        found = [member.standing for member in self.members.values()]
        return tuple((standing, found.count(standing)) for standing in STANDINGS)

    @property
    def in_flight(self) -> int:
        """Blocks at workers."""
        return len(self._where)

    def take_news(self) -> list[str]:
        """Give what has happened to workers since somebody last asked, a sentence each without its end."""
        news, self.news = self.news, []
        return news

    def left_out(self) -> list[Member]:
        """Give the workers that are left out."""
        return [member for member in self.members.values() if member.standing == "out"]

    def reasons(self) -> str:
        """Say who is left out and why; empty where nobody is."""
        return _some([f"{member.address}: {member.reason}" for member in self.left_out()])

    def _count(self) -> None:
        self._threads = sum(member.threads for member in self.members.values() if member.standing == "usable")

    def _held_seconds(self, address: str) -> float:
        member = self.members.get(address)
        return (
            0.0 if member is None else sum(self._backlog.expected(one.index) for one in member.held.values())
        )

    def _take(self, key: str) -> Attempt:
        address = self._where.pop(key)
        self._hungry[address] = None
        return self.members[address].held.pop(key)

    def _give_back(self, attempt: Attempt) -> None:
        self._again.append(attempt)

    def _next_for(self, member: Member) -> Attempt | None:
        """Choose for a worker: first what was given back, but nothing that failed there while another may compute it."""
        for place, attempt in enumerate(self._again):
            if member.address not in attempt.avoid or attempt.avoid.issuperset(
                one.address for one in self.usable
            ):
                del self._again[place]
                return attempt
        index = self._backlog.take()
        return None if index is None else Attempt(index)


def _some(told: list[str]) -> str:
    """Join what is told of workers; a few stand for many."""
    more = f"; and {len(told) - 3} more" if len(told) > 3 else ""
    return "; ".join(told[:3]) + more
