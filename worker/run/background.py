"""A thread that does one thing again and again, whatever goes wrong with it."""

import logging
import threading
from collections.abc import Callable
from contextlib import suppress

from damperlab.studies.store.faults import StoreFault

AGAIN_SECONDS = 5.0
"""Longest wait after a round that failed."""

_log = logging.getLogger("damperlab.background")


class Background:
    """Runs a function in rounds until it is closed; a round that fails is logged and counted, and the next one follows.

    Parameters
    ----------
    name : str
        Of the thread, in the log and in metrics.
    work : callable
        One round.
    seconds : float
        Between two rounds.
    wanted : callable, optional
        Whether the rounds shall go on; the thread ends where not.
    """

    def __init__(
        self, name: str, work: Callable[[], None], seconds: float, wanted: Callable[[], bool] = lambda: True
    ) -> None:
        self.name = name
        self.failures = 0
        """Rounds that failed so far."""
        self._work = work
        self._seconds = seconds
        self._wanted = wanted
        self._failed: str | None = None
        self._wake = threading.Event()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._keep_going, name=name, daemon=True)

    @property
    def trouble(self) -> str | None:
        """Why the work does not go on: how its last round failed, or that its thread has ended; None while all is well."""
        if self._closing.is_set() or self._thread.ident is None or self._thread.is_alive():
            return self._failed
        return "its thread has ended"

    def start(self, *, at_once: bool = True) -> None:
        """Begin with the first round, at once or after the time between two."""
        if at_once:
            self._wake.set()
        self._thread.start()

    @property
    def closing(self) -> bool:
        """Whether the thread is being closed: a long round shall end."""
        return self._closing.is_set()

    def wake(self) -> None:
        """Begin the next round now."""
        self._wake.set()

    def pause(self, seconds: float) -> bool:
        """Wait within a long round, which has got so far; say whether it shall end because the thread is being closed."""
        self._failed = None
        return self._closing.wait(seconds)

    def tell_to_close(self) -> None:
        """Let no further round begin."""
        self._closing.set()
        self._wake.set()

    def close(self, seconds: float | None = None) -> None:
        """Let no further round begin, and wait for the current one, for a limited time."""
        self.tell_to_close()
        if self._thread.is_alive():
            self._thread.join(seconds)

    def _keep_going(self) -> None:
        # an exception may come at any point, also from another thread: only closing ends this one
        while not self._closing.is_set():
            with suppress(BaseException):
                well = self._failed is None
                self._wake.wait(self._seconds if well else min(self._seconds, AGAIN_SECONDS))
                self._wake.clear()
            with suppress(BaseException):
                if not self._wanted():
                    return
                if not self._closing.is_set():
                    self._round()

    def note(self, error: BaseException) -> str:
        """Log and count what went wrong; give it in a line."""
        self.failures += 1
        told = _in_a_line(error)
        # the store's own words need no trace
        _log.error("%s: %s", self.name, told, exc_info=None if isinstance(error, StoreFault) else error)
        return told

    def _round(self) -> None:
        try:
            self._work()
        except BaseException as error:
            failed = type(error).__name__
            try:
                failed = self.note(error)
            finally:  # an exception that cannot be put into words is told by its name
                self._failed = failed
        else:
            self._failed = None


def _in_a_line(error: BaseException) -> str:
    text = " ".join(str(error).split())
    return text if isinstance(error, StoreFault) else f"{type(error).__name__}: {text}".rstrip(": ")
