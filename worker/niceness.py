"""Lowers the priority of processes that compute, so that requests are answered first."""

import os
import sys

NICENESS = 5
"""Increment of the niceness, with which a process that answers requests gets three times as much processor time."""


def stand_back() -> None:
    """Lower the priority of this process. A second call would lower the priority further."""
    if sys.platform != "win32":
        os.nice(NICENESS)
