"""Preload of a campaign's workers: every attempt at a block is written down before it begins.

A done-mark says which attempt counts; this says which others there were, and when, so that a block that is computed
again after it was acknowledged is seen even where the product hides it well.
"""

import json
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any

FOLDER = "CAMPAIGN_ATTEMPTS"
"""Environment variable that names the folder."""


@dataclass(frozen=True)
class Attempt:
    """One beginning of one block, and when [s since 1970], by the clock that all processes of a campaign share."""

    digest: str
    block: int
    generation: str
    began: float


def dask_setup(worker: object) -> None:
    """Dask's hook as a worker starts: tasks find the function below under the name of the real one."""
    import damperlab.worker.worker_process.tasks

    run_block = damperlab.worker.worker_process.tasks.run_block
    if hasattr(run_block, "__wrapped__"):
        return  # the process has joined again
    log = os.open(
        Path(os.environ[FOLDER]) / f"attempts-{os.getpid()}.jsonl", os.O_CREAT | os.O_APPEND | os.O_WRONLY
    )

    @wraps(run_block)
    def noted(cube_path: str, digest: str, block: Any, code: str, generation: str, *rest: Any) -> Any:
        line = json.dumps([digest, block.index, generation, time.time()])
        # one write: a process that is killed leaves a whole line or none
        os.write(log, f"{line}\n".encode())
        return run_block(cube_path, digest, block, code, generation, *rest)

    damperlab.worker.worker_process.tasks.run_block = noted


def read_attempts(folder: Path) -> Iterator[Attempt]:
    """Give every attempt that any worker began."""
    for file in folder.glob("attempts-*.jsonl"):
        for line in file.read_text().splitlines():
            yield Attempt(*json.loads(line))
