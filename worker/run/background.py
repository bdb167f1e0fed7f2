"""A background thread that repeats one task and continues after errors."""

import logging
import threading
from collections.abc import Callable
from contextlib import suppress

from damperlab.studies.store.faults import StoreFault, may_pass

AGAIN_SECONDS = 5.0
"""Longest pause after a failed call of the function [s]."""

_log = logging.getLogger("damperlab.background")


class Background:
    """Thread that calls a function again and again until it is closed.

    Each call is one round. If a round raises an exception, the error is logged and counted, and the thread continues.

    Parameters
    ----------
    name : str
        Name of the thread, in the log and in metrics.
    work : callable
        Function that is called in each round.
    seconds : float
        Pause between two rounds [s].
    wanted : callable, optional
        Called before each round. If it returns False, the thread ends.
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
        """Error of the last round, or the message that the thread has ended; None if the last round succeeded."""
        if self._closing.is_set() or self._thread.ident is None or self._thread.is_alive():
            return self._failed
        return "its thread has ended"

    def start(self, *, at_once: bool = True) -> None:
        """Start the thread. Its first round begins immediately, or after one pause if `at_once` is false."""
        if at_once:
            self._wake.set()
        self._thread.start()

    @property
    def closing(self) -> bool:
        """Whether the thread was told to close. A long round should then end early."""
        return self._closing.is_set()

    def wake(self) -> None:
        """Start the next round now."""
        self._wake.set()

    def pause(self, seconds: float) -> bool:
        """Wait between two steps of a long round, and return whether the round must end because the thread closes."""
        self._failed = None
        return self._closing.wait(seconds)

    def tell_to_close(self) -> None:
        """Tell the thread to end after its current round, and return immediately."""
        self._closing.set()
        self._wake.set()

    def close(self, seconds: float | None = None) -> None:
        """Let the thread end after its current round, and wait until it has ended.

        Parameters
        ----------
        seconds : float, optional
            Longest wait [s]; by default the wait has no limit.
        """
        self.tell_to_close()
        if self._thread.is_alive():
            self._thread.join(seconds)

    def _keep_going(self) -> None:
        # exceptions do not end this thread. It ends after `tell_to_close`, or when `wanted` returns False
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
        """Log and count an error, and return its description in one line."""
        self.failures += 1
        told = _in_a_line(error)
        # messages of the store explain the error, so the log needs no traceback
        if isinstance(error, StoreFault):
            _log.log(logging.WARNING if may_pass(error) else logging.ERROR, "%s: %s", self.name, told)
        else:
            _log.error("%s: %s", self.name, told, exc_info=error)
        return told

    def _round(self) -> None:
        try:
            self._work()
        except BaseException as error:
            failed = type(error).__name__
            try:
                failed = self.note(error)
            finally:  # if the error has no readable message, report the name of its class
                self._failed = failed
        else:
            self._failed = None


def _in_a_line(error: BaseException) -> str:
    text = " ".join(str(error).split())
    return text if isinstance(error, StoreFault) else f"{type(error).__name__}: {text}".rstrip(": ")
