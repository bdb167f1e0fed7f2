"""How many cores this process may use."""

import os
import sys


def core_count() -> int:
    """Cores that this process may use.

    Returns
    -------
    int
        At least 1; bounded by the process's affinity where the system has one.
    """
    cores = os.cpu_count() or 1
    if sys.platform == "linux":
        cores = min(cores, len(os.sched_getaffinity(0)))
    return max(1, cores)
