"""Detects damage early: all stored data are read and checked, slowly, as long as the service runs."""

import logging

from damperlab.studies.store.care.verify import check_catalogue, verify
from damperlab.studies.store.faults import StoreFault, StudyNotFound
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.run.background import Background

PAUSE_SECONDS = 0.5
"""Pause between two blocks. Reading a block takes milliseconds, so the load is negligible."""
ROUND_SECONDS = 3600.0
"""Pause between two rounds."""

_log = logging.getLogger("damperlab.scrub")


class _Closing(Exception):
    """Raised when the service ends."""


class Scrub:
    """Reads every study without an owner, block by block, and reports damage.

    Parameters
    ----------
    store : Store
        The store.
    pause_seconds : float
        Pause between two blocks [s].
    """

    def __init__(self, store: Store, pause_seconds: float = PAUSE_SECONDS) -> None:
        self.found: dict[str, list[str]] = {}
        """Findings of the last round for each study, by its id; findings about the catalogue are under "catalogue"."""
        self._store = store
        self._pause_seconds = pause_seconds
        self.background = Background("scrub", self._round, ROUND_SECONDS)
        """The thread that checks."""

    def start(self) -> None:
        """Start the first round."""
        self.background.start()

    def close(self) -> None:
        """Stop after the present block."""
        self.background.close()

    def look(self) -> None:
        """Make one round."""
        self._tell("catalogue", list(check_catalogue(self._store, self._pause)))
        cursor = None
        while True:
            page = self._store.page(limit=100, cursor=cursor)
            for record in page.records:
                if record.owner is None:
                    try:
                        self._look_at(record)
                    except (_Closing, StoreFault, OSError):
                        raise
                    except Exception as error:
                        # a study that cannot be checked does not prevent the checks of others
                        self.background.note(error)
            cursor = page.cursor
            if cursor is None:
                return

    def _look_at(self, record: Record) -> None:
        try:
            record = self._store.find(record.id)  # the list may be hours old
            damages = list(verify(self._store, record, self._pause)) if record.owner is None else []
            now = self._store.find(record.id)
            if now.owner is not None or (now.revision, now.provenance) != (
                record.revision,
                record.provenance,
            ):
                return  # a process worked on it meanwhile, so the findings may mix two moments
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
