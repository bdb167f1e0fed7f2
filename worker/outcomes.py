"""Exceptions for the early end of a block or a run."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from damperlab.studies.faults import Fault
from damperlab.studies.store.files.shelf import ShelfAway

if TYPE_CHECKING:
    from distributed import Client

RETRIES = 2
"""Largest number of retries of a block after an exception or the death of its worker."""


class Interrupted(RuntimeError):
    """Raised if a study cannot continue, and the cause is not one of its points.

    Finished blocks are kept, so the study can resume.
    """


class Outage(Interrupted):
    """Raised if a study cannot continue for a temporary reason, such as a missing cluster or a full disk."""


class SchedulerLost(Outage):
    """Raised if the connection to the Dask scheduler is lost."""

    def __init__(self) -> None:
        super().__init__("the connection to the Dask scheduler was lost")


@contextmanager
def asking_the_cluster(client: "Client") -> Iterator[None]:
    """Replace any error of Dask by `SchedulerLost` if the connection to the scheduler is lost."""
    try:
        yield
    except Exception as error:
        if isinstance(error, OSError | TimeoutError) or client.status != "running":
            raise SchedulerLost from error
        raise


class ClusterUnusable(RuntimeError):
    """Raised if the cluster in the settings cannot be used. The parameters are those of `Fault`."""

    def __init__(self, field: str, found: str, allowed: str, advice: str, message: str = "") -> None:
        self.fault = Fault(field, found, allowed, advice, message)
        super().__init__(str(self.fault))


class Crashed(RuntimeError):
    """Raised if the process that computed a block died, because of the block or because of a lack of memory."""


class Leaving(RuntimeError):
    """Raised if a worker must leave the cluster while it computes a block. Another worker then computes the block."""


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
    """Whether an error means a full disk or an exhausted quota."""
    return error.errno in (errno.ENOSPC, errno.EDQUOT)


def unusable_data(error: OSError, action: str) -> Interrupted:
    """Return the error for a run whose data cannot be read or written.

    If the cause may be temporary, the error is an `Outage`.

    `action` is "read" or "written", whichever is not possible.
    """
    kind = Outage if isinstance(error, ShelfAway) or is_full(error) else Interrupted
    return kind(f"the study's data cannot be {action} ({type(error).__name__}: {error})")
