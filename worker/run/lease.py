"""The claim of one runner on one study, renewed by a thread as long as the study runs."""

import logging
import os
import re
import socket
import threading
import uuid
from collections.abc import Iterator
from contextlib import contextmanager

from damperlab.studies.faults import Fault
from damperlab.studies.store.faults import StoreFault, StudyBusy, StudyNotFound
from damperlab.studies.store.store import Store
from damperlab.worker.run.background import Background

logger = logging.getLogger(__name__)

_held: set[str] = set()  # the owners in this process

RENEW_SECONDS = 5.0
"""Interval between renewals. Many fit into a claim's duration, so that a busy catalogue does not end a claim."""


class Lease:
    """A runner's claim on a study, and what the renewing thread has found; made by `hold`.

    Parameters
    ----------
    store : Store
        Where the study is.
    study_id : str
        Its id.
    """

    def __init__(self, store: Store, study_id: str) -> None:
        self.store = store
        self.study_id = study_id
        self.owner = _new_owner()
        self.begun = threading.Event()
        """Set by the runner once the study is `running`; from then on, another state means that the run was withdrawn."""
        self.withdrawn = threading.Event()
        """Set when another process cancelled or deleted the study."""
        self.lost = threading.Event()
        """Set when another runner has the claim: this one must not change the study any more."""
        runner = threading.current_thread()
        # if the runner's thread ends without releasing the claim, renewal stops and another runner can take over
        self.renewing = Background(f"lease-{study_id}", self._renew, RENEW_SECONDS, runner.is_alive)
        """The thread that renews the claim."""

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


def _new_owner() -> str:
    return f"{socket.gethostname()}:{os.getpid()}:{uuid.uuid4().hex[:8]}"


@contextmanager
def held_owner() -> Iterator[str]:
    """Give the name of a new owner, valid within the context."""
    owner = _new_owner()
    _held.add(owner)
    try:
        yield owner
    finally:
        _held.discard(owner)


@contextmanager
def hold(store: Store, study_id: str) -> Iterator[Lease]:
    """Claim a study within the context.

    Parameters
    ----------
    store : Store
        Where the study is.
    study_id : str
        Its full id.

    Yields
    ------
    Lease
        The caller watches it for the loss of the claim.

    Raises
    ------
    StudyBusy
        If another runner holds it.
    """
    lease = Lease(store, study_id)
    if not store.claim(study_id, lease.owner) and not _take_over(lease):
        raise StudyBusy(
            Fault(
                "id",
                f"study {study_id}, which another process is running",
                "a study that no other process runs",
                "wait for it, or cancel it there; the claim of a process that died expires by itself",
                f"Study {study_id} is run by another process.",
            )
        )
    _held.add(lease.owner)
    lease.renewing.start(at_once=False)
    try:
        yield lease
    finally:
        lease.renewing.close()
        _held.discard(lease.owner)
        try:
            store.release(study_id, lease.owner)
        except StoreFault as error:
            # The next owner takes over the claim of a dead one.
            logger.warning("the claim on study %s could not be released: %s", study_id, error)


def _take_over(lease: Lease) -> bool:
    # After a kill, a study can be run again on the same machine without waiting for the claim to expire.
    owner = lease.store.find(lease.study_id).owner
    if owner is not None and owner_is_dead(owner):
        lease.store.release(lease.study_id, owner)
    return lease.store.claim(lease.study_id, lease.owner)


def owner_is_dead(owner: str) -> bool:
    """Whether a claim's owner is certainly dead, before its claim expires.

    Parameters
    ----------
    owner : str
        As in `Record.owner`.

    Returns
    -------
    bool
        True for an ended process of this host; False for any other host's, which cannot be checked.
    """
    if not re.fullmatch(r".+:\d+:[0-9a-f]{8}", owner):
        return False
    host, pid, _ = owner.rsplit(":", 2)
    if host != socket.gethostname() or os.name != "posix":
        return False
    if int(pid) == os.getpid():
        # In a restarted container, the earlier process had the same number.
        return owner not in _held
    try:
        os.kill(int(pid), 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        return False
    return False
