"""What computes stands back behind what answers, where both share a processor."""

import os
import sys

NICENESS = 5
"""How far: a process that answers gets three times the share of one that computes, and is woken at once."""


def stand_back() -> None:
    """Let this process stand back from now on; once in each process, since the steps add up."""
    if sys.platform != "win32":
        os.nice(NICENESS)
