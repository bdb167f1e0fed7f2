"""Whether the store answers, known within a fixed time whatever becomes of the store."""

import asyncio
import threading
from concurrent.futures import Future

from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.store import Store

ANSWER_SECONDS = 1.5
"""How long the store may take; who asks for readiness hears within two seconds."""


class Readiness:
    """Asks a store one question at a time, in a thread that nothing else waits for.

    Parameters
    ----------
    store : Store
        The service's.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._lock = threading.Lock()
        self._asked: Future[StoreFault | None] | None = None

    async def fault(self) -> StoreFault | None:
        """Give what is wrong with the store; None where it answered.

        Raises
        ------
        TimeoutError
            It has not answered in time; the question stays open, and no other is put meanwhile.
        """
        return await asyncio.wait_for(asyncio.shield(asyncio.wrap_future(self._ask())), ANSWER_SECONDS)

    def _ask(self) -> "Future[StoreFault | None]":
        with self._lock:
            if self._asked is None or self._asked.done():
                self._asked = Future()
                threading.Thread(
                    target=self._answer, args=(self._asked,), name="readiness", daemon=True
                ).start()
            return self._asked

    def _answer(self, asked: "Future[StoreFault | None]") -> None:
        try:
            self._store.page(limit=1)
        except StoreFault as error:
            asked.set_result(error)
        except BaseException as error:
            asked.set_exception(error)
        else:
            asked.set_result(None)
