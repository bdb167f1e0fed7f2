"""Studies of a campaign: submitted one after the other, and watched in the catalogue while faults come."""

import random
import sys
import time
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterable, Iterator

from tests.faults.asking import ask
from tests.faults.compare import compare, unexpected_files
from tests.faults.report import Report

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block
from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.faults import StoreFault, StudyNotFound
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.block import solve_block

FAULTS_WITHOUT_A_BLOCK = 6
"""After so many the next one waits until a block is done."""
LOOK_SECONDS = 0.2
"""Between two looks at processes and done-marks."""
PATIENCE_SECONDS = 600.0
"""In which the last studies end."""
ROWS = 200
"""Size of a study, in rows of 160 points."""
TELL_SECONDS = 10.0
"""Between two lines of progress."""


def study_of(number: int, rows: int) -> Study:
    """A study of some seconds and a few dozen blocks; no two numbers have a point in common."""
    return parse_study(
        {
            "name": f"campaign {number}",
            "particle": False,
            "damping_ratio": 0.004 + 0.0007 * number,
            "axes": {
                "friction_ratio": {"start": 0.05, "stop": 0.75, "num": rows},
                "frequency_ratio": {"start": 0.9, "stop": 1.1, "num": 160},
            },
        }
    )


class Watching(ABC):
    """What campaigns have in common."""

    @abstractmethod
    def keep_up(self) -> None:
        """Start what is down."""

    @abstractmethod
    def do(self, fault: str) -> None:
        """Let a fault happen."""

    def pending(self) -> bool:
        """Whether something beside the studies has not ended yet."""
        return False

    def suffer(self, faults: Iterable[str], between: tuple[float, float]) -> None:
        """Let faults happen, one after the other, and every study end."""
        # a worker that is killed again and again before it has compiled would never get anywhere
        solve_block(study_of(0, 2), Block.whole((1, 1, 1, 1, 1, 2)))
        happened: Counter[str] = Counter()
        for fault in faults:
            # some come while what the last one ended still starts, most after that
            self.go_on(self._random.uniform(*between))
            while not self._going_on() or self._starving():
                self.go_on(LOOK_SECONDS)
            self.do(fault)
            happened[fault] += 1
            self._unrewarded += 1
            self._report.kills = dict(happened)
        give_up = time.monotonic() + PATIENCE_SECONDS
        while (self._going_on() or self.pending()) and time.monotonic() < give_up:
            self.go_on(LOOK_SECONDS, submit=False)

    def go_on(self, seconds: float, *, submit: bool = True) -> None:
        """Start what is down and watch, for so long."""
        until = time.monotonic() + seconds
        while True:
            self.keep_up()
            self._watch()
            if submit:
                self._submit_if_idle()
            self._tell()
            left = until - time.monotonic()
            if left <= 0.0:
                return
            time.sleep(min(LOOK_SECONDS, left))

    def __init__(self, store: Store, url: str, report: Report) -> None:
        self._store, self._url, self._report = store, url, report
        self._random = random.Random(report.seed)
        self._marks: dict[str, dict[int, str]] = {}
        self._studies: dict[str, Study] = {}
        # nothing happens before the first block is done
        self._done, self._unrewarded = 0, FAULTS_WITHOUT_A_BLOCK
        self._began = self._told = time.monotonic()

    def _records(self) -> Iterator[Record | None]:
        for study_id in self._studies:
            try:
                yield self._store.find(study_id)
            except StudyNotFound:
                yield None

    def _going_on(self) -> bool:
        try:
            # nothing happens before there is something to lose
            return any(record is None or not record.ended for record in self._records())
        except StoreFault:
            return True  # the database is away

    def _starving(self) -> bool:
        """Whether a loaded machine needs a while without faults to get anything done at all."""
        done = sum(map(len, self._marks.values()))
        if done != self._done:
            self._done, self._unrewarded = done, 0
        return self._unrewarded >= FAULTS_WITHOUT_A_BLOCK

    def _submit_if_idle(self) -> None:
        """Submit the next study by HTTP, where the service is up to it; it is one study, however often it is sent."""
        try:
            if sum(record is not None and not record.ended for record in self._records()) >= 2:
                return
        except StoreFault:
            return
        number = len(self._studies)
        study = study_of(number, ROWS)
        status, answer = ask("POST", f"{self._url}/api/v1/studies", study.document())
        if status in (200, 201, 202):
            self._studies[str(answer["id"])] = study
        elif status in (0, 503):
            self._report.unavailable += 1
        else:
            self._report.defects += 1
            print(f"POST answered {status}: {answer!r}", file=sys.stderr)

    def _watch(self) -> None:
        for study_id, study in self._studies.items():
            before = self._marks.get(study_id, {})
            try:
                now = dict(self._store.snapshot(study_id)[1])
            except StudyNotFound:
                print(f"study {study_id} ({study.name}) is gone", file=sys.stderr)
                now = {}
            except StoreFault:
                return  # the database is away
            self._report.looks += 1
            for block, generation in before.items():
                if now.get(block) != generation:
                    found = "lost its mark" if block not in now else "was marked anew"
                    print(f"block {block} of study {study_id} {found}", file=sys.stderr)
                    self._report.marks_lost += block not in now
                    self._report.blocks_run_twice += block in now
            self._marks[study_id] = now

    def _tell(self) -> None:
        now = time.monotonic()
        if now - self._told < TELL_SECONDS:
            return
        self._told = now
        done = sum(map(len, self._marks.values()))
        faults = sum(self._report.kills.values())
        print(
            f"{now - self._began:5.0f} s: {faults} faults, {len(self._studies)} studies, {done} blocks",
            file=sys.stderr,
            flush=True,
        )

    def _compare(self) -> Iterator[Record]:
        """Sweep, and compare every study with what the solver gives undisturbed; gives those that are there."""
        report = self._report
        report.studies = len(self._studies)
        report.strays_before_gc = collect_garbage(self._store, -1.0, orphan_seconds=-1.0, dry_run=True).paths
        collect_garbage(self._store, -1.0, orphan_seconds=-1.0)
        report.strays_after_gc = unexpected_files(self._store)
        for record, study in zip(self._records(), self._studies.values(), strict=True):
            if record is None:
                report.studies_lost += 1
                continue
            if (record.state, record.points_failed) != ("done", 0):
                print(f"study {record.id} is {record.state}: {record.message}", file=sys.stderr)
                report.studies_not_done += 1
            else:
                compare(self._store, record, study, report)
            yield record
