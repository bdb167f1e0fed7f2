"""Number of cores that this process may use."""

import os
import sys


def core_count() -> int:
    """Cores that this process may use.

    Returns
    -------
    int
        At least 1; limited by the process's affinity if the system has one.
    """
    cores = os.cpu_count() or 1
    if sys.platform == "linux":
        cores = min(cores, len(os.sched_getaffinity(0)))
    return max(1, cores)
