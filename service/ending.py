"""Ends the process of the service after a time limit, even if a thread is still running."""

import logging
import os
import threading

_log = logging.getLogger("damperlab.ending")


def end_by(seconds: float) -> None:
    """End this process after the given time. The child processes then end by themselves."""
    timer = threading.Timer(seconds, _end, (seconds,))
    timer.daemon = True
    timer.start()


def _end(seconds: float) -> None:
    _log.error("the shutdown took longer than %g s: the process ends as it is", seconds)
    logging.shutdown()
    os._exit(1)
