"""Exceptions for the early end of a block or a run, and the decision on retries."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from damperlab.studies.faults import Fault
from damperlab.studies.store.files.shelf import ShelfAway
from damperlab.worker.provenance import WrongCode

if TYPE_CHECKING:
    from distributed import Client

RETRIES = 2
"""Largest number of retries of a block after an exception or the death of its worker."""


class Interrupted(RuntimeError):
    """Raised if a study cannot continue for a reason outside its points. Finished blocks are kept for resuming."""


class Outage(Interrupted):
    """Raised if a study cannot continue for a temporary reason, such as a missing cluster or a full disk."""


class SchedulerLost(Outage):
    """Raised if the connection to the Dask scheduler is lost."""

    def __init__(self) -> None:
        super().__init__("the connection to the Dask scheduler was lost")


@contextmanager
def asking_the_cluster(client: "Client") -> Iterator[None]:
    """Raise `SchedulerLost` if the connection to the scheduler is lost during a request, whatever error Dask raises."""
    try:
        yield
    except Exception as error:
        if isinstance(error, OSError | TimeoutError) or client.status != "running":
            raise SchedulerLost from error
        raise


class ClusterUnusable(RuntimeError):
    """Raised if the cluster in the settings cannot be used.

    Parameters
    ----------
    fault : Fault
        Fault with the setting, the value found, the allowed values and the advice.
    """

    def __init__(self, fault: Fault) -> None:
        super().__init__(str(fault))
        self.fault = fault


class Crashed(RuntimeError):
    """Raised if the separate process that computed a block died, because of the block or of a lack of memory."""


class Leaving(RuntimeError):
    """Raised if a worker was asked to leave while it computed a block, which another worker then computes."""


@dataclass(frozen=True)
class Failure:
    """A block that failed in all allowed attempts.

    Parameters
    ----------
    index : int
        Index of the block.
    message : str
        Reason of the failure as a sentence.
    """

    index: int
    message: str


def is_full(error: OSError) -> bool:
    """Return whether an error means a full disk or an exhausted quota."""
    return error.errno in (errno.ENOSPC, errno.EDQUOT)


def judged(error: Exception, index: int, failures: int) -> Failure | None:
    """Decide whether a block is tried again after an exception.

    Parameters
    ----------
    error : Exception
        Exception from `damperlab.worker.worker_process.tasks.run_block`.
    index : int
        Index of the block.
    failures : int
        Number of earlier failures of the block.

    Returns
    -------
    Failure or None
        Failure of the block, or None if the block is to be tried again.

    Raises
    ------
    Interrupted
        If the code differs from that of the study, or data cannot be read or written. The points are not the cause.
    """
    if isinstance(error, WrongCode):
        raise Interrupted(str(error)) from error
    if isinstance(error, ShelfAway):
        # the worker has already retried for a while
        raise Outage(f"a worker cannot reach the study's data ({error})") from error
    text = f"{type(error).__name__}: {error}"
    if isinstance(error, OSError) and is_full(error):
        raise Outage(f"there is no room for the study's data ({text})") from error
    if failures < RETRIES:
        return None
    if isinstance(error, OSError):
        # a disk error is not caused by the points, so no block is recorded as failed
        raise Interrupted(f"a worker cannot read or write the study's data ({text})") from error
    return Failure(index, text)
