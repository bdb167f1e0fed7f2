"""The care of a store while processes are killed: backup, garbage, scrub, and studies that come and are deleted.

A process of its own goes round and round until it is killed, and is started again like the others: `python -m
tests.faults.care DATA BACKUP`, with the place of the catalogue as its third word where it is a database.
"""

import re
import sys
import time
from contextlib import suppress
from pathlib import Path

from tests.faults.processes import Process
from tests.faults.report import Report

from damperlab.service.scrub import Scrub
from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.care.backup import copy_store
from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.faults import StoreFault, StudyBusy
from damperlab.studies.store.life_cycle.lookup import Wanted
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance

PASSING = "passing "
"""Begins the name of a study that comes to be deleted."""

_WRONG = re.compile(r"is damaged|met a defect")


class Care(Process):
    """The process that takes care of a campaign's store."""

    def __init__(self, folder: Path, store: Store, catalogue: str, **environment: str) -> None:
        self._store = store
        self._backup = folder / "backup"
        self._logs = folder / "care.log", folder / "service.log"
        words = (str(store.data_dir), str(self._backup), *([catalogue] if catalogue else ()))
        super().__init__(self._logs[0], sys.executable, "-m", "tests.faults.care", *words, **environment)

    def tidy(self) -> None:
        """Delete the passing studies that are left, also those that were being computed when all was ended."""
        for record in self._store.page(limit=1000, wanted=Wanted(name=PASSING)).records:
            self._store.set_state(record.id, "cancelled")
            self._store.delete(record.id)

    def check(self, report: Report) -> None:
        """Finish the backup and compare it; nothing was ever called damaged, for nothing was."""
        own, service = (log.read_text() if log.exists() else "" for log in self._logs)
        report.rounds = len(re.findall("^round of ", own, re.MULTILINE))
        # the service's cluster tells of what was killed with tracebacks of its own
        report.false_alarms += len(_WRONG.findall(own + service)) + own.count("Traceback")
        scrub = Scrub(self._store, 0.0)
        scrub.look()
        report.false_alarms += sum(map(len, scrub.found.values()))
        copy = Store.open(self._backup)
        copy_store(self._store, copy)
        for record in self._store.page(limit=1000).records:
            kept = copy.find(record.id)
            there, here = (one.cube(record.id) for one in (copy, self._store))
            same = all(there[name].values.tobytes() == here[name].values.tobytes() for name in here.variables)
            report.backups_unlike += not same or bool(list(verify(copy, kept))) or kept.state != record.state
        copy.close()


def passing(number: int) -> Study:
    """A study of a few blocks that nobody waits for."""
    return parse_study(
        {
            "name": f"{PASSING}{number}",
            "particle": False,
            "damping_ratio": 0.3 + 1e-4 * number,
            "axes": {
                "friction_ratio": {"start": 0.05, "stop": 0.75, "num": 8},
                "frequency_ratio": {"start": 0.9, "stop": 1.1, "num": 20},
            },
        }
    )


def take_care(store: Store, backup: Path) -> None:
    """Make one round: a study comes and an older one goes, then backup, garbage and scrub."""
    study = passing(int(time.time()) % 6000)
    chunk = (*study.shape[:-2], 2, study.shape[-1])
    store.submit(study, plan_with_chunk(study, chunk, seconds_per_point), provenance())
    gone = [
        record.id for record in store.page(limit=1000, wanted=Wanted(name=PASSING)).records if record.ended
    ]
    for study_id in gone:
        with suppress(StudyBusy):  # its runner is about to let go
            store.delete(study_id)
    copy = Store.open(backup)
    try:
        copied = copy_store(store, copy)
    finally:
        copy.close()
    swept = collect_garbage(store, 0.0, orphan_seconds=0.0)
    scrub = Scrub(store, 0.0)
    scrub.look()
    for study_id, told in scrub.found.items():
        if told:
            print(f"{study_id} is damaged: {told}")
    for sentence in copied.damaged:
        print(f"for the backup a study is damaged: {sentence}")
    print(f"round of {copied.studies} studies copied, {swept.paths} paths swept, {len(gone)} deleted")


def main() -> None:
    """Go round and round."""
    data, backup, *catalogue = sys.argv[1:]
    while True:
        try:
            store = Store.open(Path(data), *catalogue)
            try:
                take_care(store, Path(backup))
            finally:
                store.close()
        except StoreFault as fault:
            # a server is being restarted, or the disk was asked too much
            print(f"waits: {fault}")
        sys.stdout.flush()
        time.sleep(0.5)


if __name__ == "__main__":
    main()
