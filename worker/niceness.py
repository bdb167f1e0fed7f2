"""Lower priority for processes that compute, so that requests are answered first."""

import os
import sys

NICENESS = 5
"""Increment of the niceness.

A process that answers requests then gets three times as much processor time as a process that computes.
"""


def stand_back() -> None:
    """Lower the priority of this process. Every further call lowers the priority again."""
    if sys.platform != "win32":
        os.nice(NICENESS)
