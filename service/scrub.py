"""Checks all stored data slowly in the background while the service runs, so that damage is detected early."""

import logging

from damperlab.studies.store.care.verify import check_catalogue, verify
from damperlab.studies.store.faults import StoreFault, StudyNotFound
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.run.background import Background

PAUSE_SECONDS = 0.5
"""Pause between the checks of two blocks [s]. The check of a block takes milliseconds, so the load is negligible."""
ROUND_SECONDS = 3600.0
"""Pause between two rounds of checks [s]."""

_log = logging.getLogger("damperlab.scrub")


class _Closing(Exception):
    """Raised to end a round of checks when the service shuts down."""


class Scrub:
    """Checks the blocks of all studies that no process is working on, and logs damage.

    Parameters
    ----------
    store : Store
        Store to check.
    pause_seconds : float
        Pause between the checks of two blocks [s].
    """

    def __init__(self, store: Store, pause_seconds: float = PAUSE_SECONDS) -> None:
        self.found: dict[str, list[str]] = {}
        """Damage found in the last round, by id of the study. Damage of the catalogue has the key "catalogue"."""
        self._store = store
        self._pause_seconds = pause_seconds
        self.background = Background("scrub", self._round, ROUND_SECONDS)
        """Thread that makes the checks."""

    def start(self) -> None:
        """Start the first round of checks."""
        self.background.start()

    def close(self) -> None:
        """Stop the checks, and wait until the check of the present block has ended."""
        self.background.close()

    def look(self) -> None:
        """Check the catalogue and all studies once."""
        self._tell("catalogue", list(check_catalogue(self._store, self._pause)))
        cursor = None
        while True:
            page = self._store.page(limit=100, cursor=cursor)
            for record in page.records:
                try:
                    self._look_at(record)
                except (_Closing, StoreFault, OSError):
                    raise
                except Exception as error:
                    # report the error, and continue with the other studies
                    self.background.note(error)
            cursor = page.cursor
            if cursor is None:
                return

    def _look_at(self, record: Record) -> None:
        try:
            if not self._store.abandoned(record.id):  # the page of records may be hours old
                return
            damages = list(verify(self._store, record, self._pause))
        except StudyNotFound:
            return
        told = [
            f"{damage.part if damage.block is None else f'block {damage.block}'}: {damage.found}"
            for damage in damages
        ]
        self._tell(record.id, told)

    def _tell(self, study_id: str, told: list[str]) -> None:
        if told and told != self.found.get(study_id):
            more = f", and {len(told) - 1} more" if len(told) > 1 else ""
            mend = (
                "damperlab store verify"
                if study_id == "catalogue"
                else f"damperlab store verify {study_id} --repair"
            )
            _log.error("%s is damaged: %s%s; run `%s`", study_id, told[0], more, mend)
        self.found[study_id] = told

    def _pause(self) -> None:
        if self.background.pause(self._pause_seconds):
            raise _Closing

    def _round(self) -> None:
        try:
            self.look()
        except _Closing:
            return
        except (StoreFault, OSError) as error:
            _log.warning("stored data cannot be checked now: %s", error)
