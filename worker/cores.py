"""The number of cores that this process may use."""

import os
import sys


def core_count() -> int:
    """Return the number of cores for this process, at least 1. On Linux, the number respects the CPU affinity."""
    cores = os.cpu_count() or 1
    if sys.platform == "linux":
        cores = min(cores, len(os.sched_getaffinity(0)))
    return max(1, cores)
