"""Checks in the background whether the service can use its data, so that a readiness request never waits."""

import os
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from damperlab.service.problems import Problem
from damperlab.studies.faults import Fault
from damperlab.studies.store.catalogue.home import disk_gone
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.files.folder import Folder
from damperlab.studies.store.store import Store
from damperlab.worker.run.background import Background

LOOK_SECONDS = 1.0
"""Interval between checks of the store and its folders [s]."""
STALE_SECONDS = 5.0
"""Largest age of the last check [s]. An older check means that the store or the disk does not answer."""
PROBE = ".ready"
"""Name of the file that is written and removed to test whether a folder is writable."""
_PROBE_BYTES = 8192  # large enough to need a new disk block in every file system


@dataclass(frozen=True)
class _Seen:
    fault: Fault | None
    at: float


class Readiness:
    """Checks repeatedly whether the catalogue answers, and whether the folders of the service are writable.

    The checks also detect a folder that was replaced since the start, for example because a disk was unmounted.

    Parameters
    ----------
    store : Store
        Store of the service.
    backgrounds : sequence of Background
        Background threads that must be running.
    """

    def __init__(self, store: Store, backgrounds: Sequence[Background]) -> None:
        self.background = Background("readiness", self._look, LOOK_SECONDS)
        """Thread that makes the checks."""
        self._store = store
        self._backgrounds = (*backgrounds, self.background)
        places = [store.data_dir]
        if isinstance(store.shelf, Folder):
            places.append(Path(store.shelf.address))
        self._places = {place: _identity(place) for place in places}
        self._seen = _Seen(None, time.monotonic())

    def problem(self) -> Problem | None:
        """Return the problem that prevents the service from working; None if there is no problem."""
        seen = self._seen
        if time.monotonic() - seen.at > STALE_SECONDS:
            told = f"The service's store has not answered within {STALE_SECONDS:g} s."
            return Problem(503, "store-unavailable", told)
        if seen.fault is not None:
            return Problem(503, "store-unavailable", "The service cannot use its data.", (seen.fault,))
        down = [_down(each.name, trouble) for each in self._backgrounds if (trouble := each.trouble)]
        if down:
            return Problem(503, "background-down", "A background thread of the service is down.", down)
        return None

    def _look(self) -> None:
        try:
            self._store.page(limit=1)
            fault = self._folder_fault()
        except StoreFault as error:
            fault = error.fault
        self._seen = _Seen(fault, time.monotonic())

    def _folder_fault(self) -> Fault | None:
        gone = disk_gone(self._store.shelf)
        if gone is not None:
            advice = "mount it, or restore the folder"
            return Fault(self._store.shelf.address, gone, "the folder that was opened", advice, f"{gone}.")
        for place, known in self._places.items():
            try:
                found = _identity(place)
                if found == known and not self._store.catalogue.read_only:
                    _write(place / PROBE)
            except OSError as error:
                allowed = "a folder that can be written"
                advice = "make room, or restore the folder and its permissions"
                told = f"{place} cannot be written: {error.strerror or error}."
                return Fault(str(place), str(error), allowed, advice, told)
            if found != known:
                told = f"{place} is not the folder that was opened."
                advice = "restore the first folder, or restart the service"
                return Fault(str(place), "another folder", "the folder that was opened", advice, told)
        return None


def _identity(place: Path) -> tuple[int, int]:
    found = place.stat()
    return found.st_dev, found.st_ino


def _write(file: Path) -> None:
    try:
        # unbuffered, so that an error of a full disk occurs in this function
        descriptor = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        try:
            left = _PROBE_BYTES
            while left:
                left -= os.write(descriptor, bytes(left))
        finally:
            os.close(descriptor)
    finally:
        with suppress(OSError):
            file.unlink()


def _down(name: str, trouble: str) -> Fault:
    return Fault(
        f"thread {name}",
        trouble,
        "a thread that works",
        "it is restarted automatically; if it stays down, read the log and restart the service",
        f"The thread {name} is down: {trouble.rstrip('.')}.",
    )
