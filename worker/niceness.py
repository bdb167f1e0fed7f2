"""Gives computing processes a lower priority than answering ones on a shared processor."""

import os
import sys

NICENESS = 5
"""The increment: an answering process then gets three times the share of a computing one, and is woken immediately."""


def stand_back() -> None:
    """Lower the priority of this process from now on; call it only once in each process, since the steps add up."""
    if sys.platform != "win32":
        os.nice(NICENESS)
