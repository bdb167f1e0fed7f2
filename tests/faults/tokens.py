"""Preload of workers whose values say which attempt wrote them, so that a reader sees what it should not see."""

import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import plan_with_chunk

METRICS = ("amplitude_ratio", "cycles", "run_time")
"""The variables that carry the token; the fourth is the status."""
STUDY = parse_study(
    {
        "name": "read while it is written",
        "particle": False,
        "damping_ratio": 0.05,
        "metrics": list(METRICS),
        "axes": {
            "friction_ratio": {"start": 0.0, "stop": 0.5, "num": 6},
            "frequency_ratio": {"start": 0.7, "stop": 1.3, "num": 8},
        },
        "steady": {"max_cycles": 50},
    }
)
"""What is written and read; it computes in no time."""
PLAN = plan_with_chunk(STUDY, (1, 1, 1, 1, 2, 3), lambda _, at: np.ones(len(at["mass_ratio"])))
"""Nine blocks, some of them smaller than the others."""


def token(generation: str) -> float:
    """Give the number that all points of a block hold in one generation; any float type keeps it exactly."""
    return float(1 + (zlib.crc32(generation.encode()) & 0x7FFFFF))


def dask_setup(worker: object) -> None:
    """Dask's hook as a worker starts: what it writes is the token instead of the solver's values."""
    import damperlab.worker.worker_process.tasks

    write_region = damperlab.worker.worker_process.tasks.write_region

    def tell(
        cube_path: str, block: Any, values: Mapping[str, np.ndarray], generation: str, *more: Any
    ) -> Any:
        told = {
            name: column if name == "status" else np.full_like(column, token(generation))
            for name, column in values.items()
        }
        return write_region(cube_path, block, told, generation, *more)

    damperlab.worker.worker_process.tasks.write_region = tell
