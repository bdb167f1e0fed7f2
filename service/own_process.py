"""Metrics of this process, for example its memory, with the usual names of Prometheus."""

import os
import resource
import sys
import time
from pathlib import Path

_BEGAN = time.time()


def own_process() -> dict[str, tuple[str, str, float]]:
    """Return metrics of this process.

    Returns
    -------
    dict
        Kind ("counter" or "gauge"), description and value of each metric, by name. Memory and open files are included
        only on Linux.
    """
    used = resource.getrusage(resource.RUSAGE_SELF)
    found = {
        "process_cpu_seconds_total": ("counter", "CPU time of this process.", used.ru_utime + used.ru_stime),
        "process_start_time_seconds": ("gauge", "Start of this process, in seconds since 1970.", _BEGAN),
    }
    if sys.platform == "linux":
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        found |= {
            "process_resident_memory_bytes": (
                "gauge",
                "Memory of this process that is in use.",
                float(pages * os.sysconf("SC_PAGE_SIZE")),
            ),
            "process_open_fds": (
                "gauge",
                "Files and connections that this process has open.",
                float(sum(1 for _ in Path("/proc/self/fd").iterdir())),
            ),
        }
    return found
