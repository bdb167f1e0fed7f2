"""A runner's claim on a study. A thread renews the claim while the study runs."""

import logging
import os
import re
import socket
import threading
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from damperlab.studies.store.faults import StoreFault, StudyBusy, StudyNotFound
from damperlab.studies.store.store import Store
from damperlab.worker.run.background import Background

logger = logging.getLogger(__name__)

_held: set[str] = set()  # owners of claims that this process holds

RENEW_SECONDS = 5.0
"""Interval between renewals of a claim [s]. A claim lasts much longer, so it does not expire
while the catalogue is busy.
"""


class Lease:
    """A runner's claim on a study, made by the function `hold`.

    Parameters
    ----------
    store : Store
        Store that holds the study.
    study_id : str
        Id of the study.
    """

    def __init__(self, store: Store, study_id: str) -> None:
        self.store = store
        self.study_id = study_id
        self.owner = new_owner()
        self.begun = threading.Event()
        """Event that the runner sets once the study is `running`. If the state then changes, the run ends."""
        self.withdrawn = threading.Event()
        """Event that is set when another process has cancelled or deleted the study."""
        self.lost = threading.Event()
        """Event that is set when another runner has taken the claim. This runner must then not change the study."""
        self.renewing = renewer(f"lease-{study_id}", self._renew)
        """Thread that renews the claim."""

    @property
    def over(self) -> bool:
        """Whether the runner must stop."""
        return self.withdrawn.is_set() or self.lost.is_set()

    def _renew(self) -> None:
        try:
            if not self.store.renew(self.study_id, self.owner):
                self.lost.set()
            elif self.begun.is_set() and self.store.find(self.study_id).state != "running":
                self.withdrawn.set()
        except StudyNotFound:
            self.withdrawn.set()


def new_owner() -> str:
    """Return a unique name for an owner of claims in this process."""
    return f"{socket.gethostname()}:{os.getpid()}:{uuid.uuid4().hex[:8]}"


def renewer(name: str, renew: Callable[[], None]) -> Background:
    """Return a thread, not started yet, that calls `renew` again and again as long as the calling thread lives."""
    # if the runner's thread ends without releasing its claims, renewal stops and another runner can take over
    return Background(name, renew, RENEW_SECONDS, threading.current_thread().is_alive)


@contextmanager
def renewed(owner: str, renewing: Background, release: Callable[[], object]) -> Iterator[None]:
    """Let a thread renew an owner's claims within the context, and release the claims afterwards.

    Within the context, `owner_is_dead` returns False for this owner.
    """
    _held.add(owner)
    renewing.start(at_once=False)
    try:
        yield
    finally:
        renewing.close()
        _held.discard(owner)
        try:
            release()
        except StoreFault as error:
            # the next runner can take over the claims, because `owner_is_dead` is now true for their owner
            logger.warning("the claims of %s could not be released: %s", owner, error)


@contextmanager
def hold(store: Store, study_id: str) -> Iterator[Lease]:
    """Hold the claim on a study within the context.

    The caller must check `Lease.over` repeatedly, because the claim can be lost.

    Raises
    ------
    StudyBusy
        If another runner holds a claim on the study.
    """
    lease = Lease(store, study_id)
    if not store.claim(study_id, lease.owner) and not _take_over(lease):
        raise StudyBusy(
            "id",
            f"study {study_id}, which another process is running",
            "a study that no other process runs",
            "wait for it, or cancel it there; the claim of a process that died expires by itself",
            f"Study {study_id} is run by another process.",
        )
    with renewed(lease.owner, lease.renewing, lambda: store.release(study_id, lease.owner)):
        yield lease


def _take_over(lease: Lease) -> bool:
    # the claim of a dead process of this machine is released before it expires
    owner = lease.store.find(lease.study_id).owner
    if owner is not None and owner_is_dead(owner):
        lease.store.release(lease.study_id, owner)
    return lease.store.claim(lease.study_id, lease.owner)


def owner_is_dead(owner: str) -> bool:
    """Return whether the owner of a claim was a process of this host that has ended; see `Record.owner`.

    The function returns False for processes of other hosts, which cannot be checked.
    """
    if not re.fullmatch(r".+:\d+:[0-9a-f]{8}", owner):
        return False
    host, pid, _ = owner.rsplit(":", 2)
    if host != socket.gethostname() or os.name != "posix":
        return False
    if int(pid) == os.getpid():
        # In a restarted container, this process may have the same process id as an earlier process.
        return owner not in _held
    try:
        os.kill(int(pid), 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        return False
    return False
