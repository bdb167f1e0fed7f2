"""Studies that are run in the process of a test, where no cluster may be asked for."""

import threading
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

from distributed import Client

from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.run.progress import Progress
from damperlab.worker.run.runner import run_study

AMPLE_SECONDS = 60.0
"""What any study of a test is expected to take at most."""


def never() -> AbstractContextManager[Client]:
    raise AssertionError("a cluster was asked for")


def ignore(progress: Progress) -> None:
    pass


def run_here(
    store: Store,
    study_id: str,
    tell: Callable[[Progress], None] = ignore,
    stop: threading.Event | None = None,
    **more: Any,
) -> Record:
    """Run a study in this process to its end, or until it is stopped."""
    return run_study(
        store, study_id, never, tell, stop or threading.Event(), here_seconds=AMPLE_SECONDS, **more
    )
