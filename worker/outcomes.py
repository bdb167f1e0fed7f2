"""Abnormal ends of a block or of a run; this module does not depend on a cluster."""

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
"""Largest number of retries of a block after an exception, or after the death of its worker."""


class Interrupted(RuntimeError):
    """The study cannot continue, for a reason outside its points; finished blocks are kept and it can be resumed."""


class Outage(Interrupted):
    """A temporary reason prevents a study from continuing: the cluster is absent, or the disk is full."""


class SchedulerLost(Outage):
    """The connection to the Dask scheduler was lost."""

    def __init__(self) -> None:
        super().__init__("the connection to the Dask scheduler was lost")


@contextmanager
def asking_the_cluster(client: "Client") -> Iterator[None]:
    """Raise `SchedulerLost` if the scheduler is lost during a request, whatever error the library raises."""
    try:
        yield
    except Exception as error:
        if isinstance(error, OSError | TimeoutError) or client.status != "running":
            raise SchedulerLost from error
        raise


class ClusterUnusable(RuntimeError):
    """There is no cluster to compute on; a user error.

    Parameters
    ----------
    fault : Fault
        The setting, the value found, the allowed values, the advice.
    """

    def __init__(self, fault: Fault) -> None:
        super().__init__(str(fault))
        self.fault = fault


class Crashed(RuntimeError):
    """A block ended the separate process that computed it, while the parent survived. The cause is the block, or lack
    of memory.
    """


class Leaving(RuntimeError):
    """A worker was asked to leave while it computed a block. It is not at fault, and another worker gets the block."""


@dataclass(frozen=True)
class Failure:
    """A block that failed as often as allowed.

    Parameters
    ----------
    index : int
        Of the block.
    message : str
        The reason, in one sentence.
    """

    index: int
    message: str


def is_full(error: OSError) -> bool:
    """Whether a disk lacks space: blocks, inodes or a quota."""
    return error.errno in (errno.ENOSPC, errno.EDQUOT)


def judged(error: Exception, index: int, failures: int) -> Failure | None:
    """Decide how to continue with a block whose attempt raised an exception.

    Parameters
    ----------
    error : Exception
        The exception of `damperlab.worker.worker_process.tasks.run_block`.
    index : int
        Of the block.
    failures : int
        Number of its earlier failures.

    Returns
    -------
    Failure or None
        None if it is tried again.

    Raises
    ------
    Interrupted
        If the code differs from the study's, or data cannot be read or written; the points are not at fault.
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
        # Points are not at fault for disks and mounts, so nothing is recorded as failed.
        raise Interrupted(f"a worker cannot read or write the study's data ({text})") from error
    return Failure(index, text)
