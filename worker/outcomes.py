"""How a block, or a whole run, can end other than well; known without a cluster."""

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
"""How often a block is tried again after an exception, or after the death of its worker."""


class Interrupted(RuntimeError):
    """The study cannot go on, for a reason outside its points; what is done is kept and it can be resumed."""


class Outage(Interrupted):
    """What keeps a study from going on passes by itself: the cluster is away, or the disk is full."""


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
        Which setting, what was found, what is allowed, what to do.
    """

    def __init__(self, fault: Fault) -> None:
        super().__init__(str(fault))
        self.fault = fault


class Crashed(RuntimeError):
    """A block ended the process that computed it alone, whose parent lives: the block's doing, or want of memory."""


class Leaving(RuntimeError):
    """A worker was asked to leave while it computed a block. It is not at fault, and another worker gets the block."""


@dataclass(frozen=True)
class Failure:
    """A block that failed as often as it may.

    Parameters
    ----------
    index : int
        Of the block.
    message : str
        What happened, in one sentence.
    """

    index: int
    message: str


def is_full(error: OSError) -> bool:
    """Whether a disk refused for want of room: blocks, inodes or a quota."""
    return error.errno in (errno.ENOSPC, errno.EDQUOT)


def judged(error: Exception, index: int, failures: int) -> Failure | None:
    """Decide what becomes of a block whose attempt raised an exception.

    Parameters
    ----------
    error : Exception
        What `damperlab.worker.worker_process.tasks.run_block` raised.
    index : int
        Of the block.
    failures : int
        How often it had failed before.

    Returns
    -------
    Failure or None
        None where it is tried again.

    Raises
    ------
    Interrupted
        Other code than the study's, or data that cannot be read or written: not the points' fault.
    """
    if isinstance(error, WrongCode):
        raise Interrupted(str(error)) from error
    if isinstance(error, ShelfAway):
        # it was tried for a while by the worker
        raise Outage(f"a worker cannot reach the study's data ({error})") from error
    text = f"{type(error).__name__}: {error}"
    if isinstance(error, OSError) and is_full(error):
        raise Outage(f"there is no room for the study's data ({text})") from error
    if failures < RETRIES:
        return None
    if isinstance(error, OSError):
        # Disks and mounts are not the points' fault: nothing is recorded as failed.
        raise Interrupted(f"a worker cannot read or write the study's data ({text})") from error
    return Failure(index, text)
