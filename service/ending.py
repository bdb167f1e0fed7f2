"""Ends the process on time, even if something still computes in it."""

import logging
import os
import threading

_log = logging.getLogger("damperlab.ending")


def end_by(seconds: float) -> None:
    """End this process after some seconds, unless it has already ended; its children end by themselves."""
    timer = threading.Timer(seconds, _end, (seconds,))
    timer.daemon = True
    timer.start()


def _end(seconds: float) -> None:
    _log.error("the shutdown took longer than %g s: the process ends as it is", seconds)
    logging.shutdown()
    os._exit(1)
