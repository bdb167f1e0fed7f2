"""Turns: whoever has the fewest under way is next, so that nobody who asks for much keeps the others waiting."""

from collections import Counter, deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from anyio import Event


class TooManyWaiting(Exception):
    """One caller has as many requests waiting as may wait."""


class Turns:
    """Turns at something that few can do at a time; for one event loop.

    Parameters
    ----------
    at_once : int
        Most turns at a time.
    waiting : int
        Most requests of one caller that wait.
    """

    def __init__(self, at_once: int, waiting: int) -> None:
        self._free = at_once
        self._most = waiting
        self._waiting: dict[str, deque[Event]] = {}
        self._under_way: Counter[str] = Counter()

    @asynccontextmanager
    async def turn(self, who: str) -> AsyncIterator[None]:
        """Wait for a turn and hold it.

        Raises
        ------
        TooManyWaiting
            If too many of this caller wait already.
        """
        await self._wait(who)
        self._under_way[who] += 1
        try:
            yield
        finally:
            self._under_way[who] -= 1
            if not self._under_way[who]:
                del self._under_way[who]
            self._hand_on()

    async def _wait(self, who: str) -> None:
        if self._free and not self._waiting:
            self._free -= 1
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
            # whoever leaves while it is called hands its turn on
            if called.is_set():
                self._hand_on()
            else:
                line.remove(called)
                self._forget(who)
            raise

    def _hand_on(self) -> None:
        self._free += 1
        self._call()

    def _call(self) -> None:
        called = Counter(self._under_way)
        while self._free and self._waiting:
            # of equals the one that has waited longest: dictionaries keep the order in which they came
            who = min(self._waiting, key=lambda each: called[each])
            self._waiting[who].popleft().set()
            self._free -= 1
            called[who] += 1
            line = self._waiting.pop(who)
            if line:
                self._waiting[who] = line  # behind the others

    def _forget(self, who: str) -> None:
        if not self._waiting.get(who):
            self._waiting.pop(who, None)
