"""Fair division of a limited resource between callers. The caller with the fewest running requests is served next."""

from collections import Counter, deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from anyio import Event


class TooManyWaiting(Exception):
    """Too many requests of a caller are already waiting."""


class Turns:
    """Divides a limited resource between callers. All calls must come from one event loop.

    Parameters
    ----------
    at_once : int
        Largest number of requests that use the resource at the same time.
    waiting : int
        Largest number of waiting requests of one caller.
    each : int, optional
        Largest number of requests of one caller that use the resource at the same time; by default `at_once`.
    """

    def __init__(self, at_once: int, waiting: int, each: int | None = None) -> None:
        self._free = at_once
        self._most = waiting
        self._each = at_once if each is None else each
        self._waiting: dict[str, deque[Event]] = {}
        self._under_way: Counter[str] = Counter()

    @asynccontextmanager
    async def turn(self, who: str) -> AsyncIterator[None]:
        """Wait for the resource, and hold it within the context.

        Raises
        ------
        TooManyWaiting
            If too many requests of this caller are already waiting.
        """
        await self._wait(who)
        try:
            yield
        finally:
            self._hand_on(who)

    async def _wait(self, who: str) -> None:
        if who not in self._waiting and self._may_begin(who):
            self._begin(who)
            return
        line = self._waiting.setdefault(who, deque())
        if len(line) >= self._most:
            raise TooManyWaiting
        called = Event()
        line.append(called)
        self._call()
        try:
            await called.wait()
        except BaseException:
            # a caller may leave after its turn has come; the turn then passes to another caller
            if called.is_set():
                self._hand_on(who)
            else:
                line.remove(called)
                self._forget(who)
            raise

    def _may_begin(self, who: str) -> bool:
        return self._free > 0 and self._under_way[who] < self._each

    def _begin(self, who: str) -> None:
        self._free -= 1
        self._under_way[who] += 1

    def _hand_on(self, who: str) -> None:
        self._free += 1
        self._under_way[who] -= 1
        if not self._under_way[who]:
            del self._under_way[who]
        self._call()

    def _call(self) -> None:
        while ready := [who for who in self._waiting if self._may_begin(who)]:
            # if there is a tie, `min` returns the first caller in the dictionary, which has waited longest
            who = min(ready, key=lambda each: self._under_way[each])
            self._waiting[who].popleft().set()
            self._begin(who)
            line = self._waiting.pop(who)
            if line:
                self._waiting[who] = line  # insert the caller again, at the end of the dictionary

    def _forget(self, who: str) -> None:
        if not self._waiting.get(who):
            self._waiting.pop(who, None)
