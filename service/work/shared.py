"""A look-up whose result is shared by simultaneous callers."""

import asyncio
from collections.abc import Callable
from typing import Generic, TypeVar

from anyio import CapacityLimiter
from anyio.to_thread import run_sync

AT_ONCE = 8
"""Default number of threads for look-ups."""

Found = TypeVar("Found")


class Shared(Generic[Found]):
    """Shares the results of look-ups among simultaneous callers.

    Callers that arrive during a look-up share a new look-up, which begins when the running look-up has ended. So a
    result is never older than the call.

    Parameters
    ----------
    look : callable
        Function that looks up one item, called in a thread.
    at_once : int
        Largest number of threads for look-ups. These threads are separate from the threads of requests.
    """

    def __init__(self, look: Callable[[str], Found], at_once: int = AT_ONCE) -> None:
        self._look = look
        self._at_once = at_once
        self._limiter: CapacityLimiter | None = None
        self._next: dict[str, asyncio.Task[Found]] = {}
        self._under_way: dict[str, asyncio.Task[Found]] = {}

    async def ask(self, what: str) -> Found:
        """Return the result of `look` for an item, or raise the exception of `look`."""
        task = self._next.get(what)
        if task is None:
            task = self._next[what] = asyncio.create_task(self._after(self._under_way.get(what), what))
            task.add_done_callback(
                lambda done: done.cancelled() or done.exception()
            )  # retrieve the exception here, because every caller may have left
        return await asyncio.shield(task)

    async def _after(self, before: asyncio.Task[Found] | None, what: str) -> Found:
        if before is not None:
            await asyncio.wait([before])
        self._under_way[what] = self._next.pop(what)
        mine = self._under_way[what]
        try:
            self._limiter = self._limiter or CapacityLimiter(self._at_once)
            return await run_sync(self._look, what, limiter=self._limiter)
        finally:
            if self._under_way.get(what) is mine:
                del self._under_way[what]
