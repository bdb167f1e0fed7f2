"""A thread that repeats one task, whatever errors occur."""

import logging
import threading
from collections.abc import Callable
from contextlib import suppress

from damperlab.studies.store.faults import StoreFault

AGAIN_SECONDS = 5.0
"""Longest wait after a failed round."""

_log = logging.getLogger("damperlab.background")


class Background:
    """Runs a function in rounds until it is closed; a failed round is logged and counted, and the next one follows.

    Parameters
    ----------
    name : str
        Name of the thread, in the log and in metrics.
    work : callable
        One round.
    seconds : float
        Pause between two rounds.
    wanted : callable, optional
        Returns whether the rounds continue; if not, the thread ends.
    """

    def __init__(
        self, name: str, work: Callable[[], None], seconds: float, wanted: Callable[[], bool] = lambda: True
    ) -> None:
        self.name = name
        self.failures = 0
        """Number of failed rounds."""
        self._work = work
        self._seconds = seconds
        self._wanted = wanted
        self._failed: str | None = None
        self._wake = threading.Event()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._keep_going, name=name, daemon=True)

    @property
    def trouble(self) -> str | None:
        """Reason why no work is done: the error of the last round, or the end of the thread; None if all is well."""
        if self._closing.is_set() or self._thread.ident is None or self._thread.is_alive():
            return self._failed
        return "its thread has ended"

    def start(self, *, at_once: bool = True) -> None:
        """Start the first round, immediately or after the interval."""
        if at_once:
            self._wake.set()
        self._thread.start()

    @property
    def closing(self) -> bool:
        """Whether the thread is being closed, so that a long round must end."""
        return self._closing.is_set()

    def wake(self) -> None:
        """Start the next round now."""
        self._wake.set()

    def pause(self, seconds: float) -> bool:
        """Wait within a long round after a step; say whether it must end because the thread is being closed."""
        self._failed = None
        return self._closing.wait(seconds)

    def tell_to_close(self) -> None:
        """Start no further round."""
        self._closing.set()
        self._wake.set()

    def close(self, seconds: float | None = None) -> None:
        """Start no further round, and wait for the current one, for a limited time."""
        self.tell_to_close()
        if self._thread.is_alive():
            self._thread.join(seconds)

    def _keep_going(self) -> None:
        # whatever exception occurs, at any point, only closing ends this thread
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
        """Log and count an error; describe it in one line."""
        self.failures += 1
        told = _in_a_line(error)
        # the store's own messages need no traceback
        _log.error("%s: %s", self.name, told, exc_info=None if isinstance(error, StoreFault) else error)
        return told

    def _round(self) -> None:
        try:
            self._work()
        except BaseException as error:
            failed = type(error).__name__
            try:
                failed = self.note(error)
            finally:  # an exception that cannot be formatted is described by its name
                self._failed = failed
        else:
            self._failed = None


def _in_a_line(error: BaseException) -> str:
    text = " ".join(str(error).split())
    return text if isinstance(error, StoreFault) else f"{type(error).__name__}: {text}".rstrip(": ")
