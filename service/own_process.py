"""Resources of this process, under the names that monitors also use for other programs."""

import os
import resource
import sys
import time
from pathlib import Path

_BEGAN = time.time()


def own_process() -> dict[str, tuple[str, str, float]]:
    """Give the values that monitors collect for any process.

    Returns
    -------
    dict
        For each name the kind (counter or gauge), the meaning and the value. Memory and files are given only if the
        system provides them.
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
