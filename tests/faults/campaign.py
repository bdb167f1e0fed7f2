"""A fault campaign: processes are killed with SIGKILL at random times, and every study must end as if none had been.

A scheduler, two workers and a service run as processes, and a PostgreSQL server where the catalogue is there. While
studies are computed, one of the processes, or all of them, is killed again and again, and started anew. Beside them
this process watches the catalogue: a done-mark that was seen once must stay as it is. At the end every study is done,
every cube equals bit for bit what the solver gives in one undisturbed piece (run_time aside), every checksum holds, no
block was begun again after it was acknowledged, and no file is left that no study needs. Meanwhile an outdated study is
recomputed, blocks that were given up are tried again, studies are deleted, and a process, killed like the others, backs up,
sweeps and scrubs without a pause.
"""

import argparse
import json
import os
import random
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

from tests.faults.attempts import FOLDER, read_attempts
from tests.faults.care import Care
from tests.faults.compare import run_again
from tests.faults.deeds import Deeds
from tests.faults.processes import Database, Member, ObjectServer, Process, Victim, dask, end_on_sigterm
from tests.faults.report import Report
from tests.faults.watching import Watching, study_of
from tests.ports import free_port

from damperlab.studies.plan import Block
from damperlab.studies.store.store import Store
from damperlab.worker.block import solve_block

VICTIMS = {"worker": 5, "service": 3, "care": 3, "scheduler": 1, "all": 1, "database": 1, "store": 1}
"""How often each is killed, relative to the others; a lost scheduler costs the service a longer wait."""
LOOK_SECONDS = 0.2
"""Between two looks at the done-marks."""
DEEDS_A_LOOK = 0.05
"""How often, a look, what users ask of the stored studies is asked: at random, so that kills come before and after."""


class Campaign(Watching):
    """One campaign."""

    def __init__(
        self, folder: Path, seed: int, database: Database | None, objects: ObjectServer | None, rows: int
    ) -> None:
        self._folder = folder
        self._random = random.Random(seed)
        scheduler, self._port = free_port(), free_port()
        address = f"tcp://127.0.0.1:{scheduler}"
        settings = {
            "DAMPERLAB_DATA_DIR": str(folder / "data"),
            "DAMPERLAB_PORT": str(self._port),
            "DAMPERLAB_SCHEDULER": address,
            "DAMPERLAB_WORKERS": "",
            "DAMPERLAB_CATALOGUE": database.address if database else "",
        }
        secrets = objects.environment if objects else {}
        self._victims: dict[str, list[Victim]] = {
            "scheduler": [dask(folder / "scheduler.log", "scheduler", "--port", str(scheduler))],
            "worker": [
                Member(
                    folder / f"worker-{number}.log",
                    *(sys.executable, "-m", "damperlab", "worker", address),
                    **{FOLDER: str(folder), "DASK_DISTRIBUTED__WORKER__PRELOAD": "['tests.faults.attempts']"},
                    **secrets,
                )
                for number in range(2)
            ],
            "service": [
                Process(
                    folder / "service.log",
                    sys.executable,
                    "-m",
                    "damperlab.service.cli.main",
                    "serve",
                    **settings,
                    **secrets,
                )
            ],
        }
        if database:
            self._victims["database"] = [database]
        if objects:
            self._victims["store"] = [objects]
        store = Store.open(
            folder / "data",
            database.address if database else None,
            # the catalogue remembers where the cubes are
            objects.address if objects else None,
        )
        backend = f"{'PostgreSQL' if database else 'SQLite'}, {'S3' if objects else 'disk'}"
        super().__init__(store, f"http://127.0.0.1:{self._port}", rows, Report(backend, seed))
        self._care = Care(folder, self._store, database.address if database else "", **secrets)
        self._victims["care"] = [self._care]
        self._victims["all"] = [each for kind in self._victims.values() for each in kind]
        # before anything is killed: what is asked of it is asked while that happens
        catalogue = {"DAMPERLAB_CATALOGUE": settings["DAMPERLAB_CATALOGUE"]} if database else {}
        self._deeds = Deeds(folder, self._store, study_of, **secrets, **catalogue)

    def run(self, kills: int | Sequence[str], patience: float) -> Report:
        """Kill so often, or these, let the last studies end within `patience` seconds, and compare."""
        killed: Counter[str] = Counter()
        # a worker that is killed again and again before it has compiled would never get anywhere
        solve_block(study_of(0, 2), Block(0, (0,) * 6, (1, 1, 1, 1, 1, 2)))
        try:
            for victim in self._drawn(kills) if isinstance(kills, int) else kills:
                # some kills come while the killed of before still starts, most after that
                self._go_on(self._random.uniform(0.0, 5.0))
                while not self._going_on() or self._starving():
                    self._go_on(LOOK_SECONDS)
                chosen = self._victims[victim]
                for process in chosen if victim == "all" else [self._random.choice(chosen)]:
                    process.kill()
                killed[victim] += 1
                self._unrewarded += 1
                self._report.kills = dict(killed)
            give_up = time.monotonic() + patience
            while (self._going_on() or self._deeds.pending) and time.monotonic() < give_up:
                self._go_on(LOOK_SECONDS, submit=False)
        finally:
            # the servers go on: what they hold is read below
            for name in ("care", "service", "worker", "scheduler"):
                for process in self._victims[name]:
                    process.kill()
        for servers in ("database", "store"):
            for server in self._victims.get(servers, ()):
                server.keep_up()
        self._finish()
        self._store.close()
        return self._report

    def _drawn(self, kills: int) -> Iterator[str]:
        weights = {name: weight for name, weight in VICTIMS.items() if name in self._victims}
        for _ in range(kills):
            yield self._random.choices(list(weights), list(weights.values()))[0]

    def _go_on(self, seconds: float, *, submit: bool = True) -> None:
        """Start what is down and watch, for so long."""
        until = time.monotonic() + seconds
        while True:
            for process in self._victims["all"]:
                process.keep_up()
            self._watch()
            if submit:
                self._submit_if_idle()
            if self._deeds.pending and self._random.random() < DEEDS_A_LOOK:
                self._deeds.step(self._port)
                self._studies |= self._deeds.studies
            self._tell()
            left = until - time.monotonic()
            if left <= 0.0:
                return
            time.sleep(min(LOOK_SECONDS, left))

    def _finish(self) -> None:
        report = self._report
        attempts = list(read_attempts(self._folder))
        report.attempts = len(attempts)
        self._care.tidy()
        for record in self._compare():
            report.blocks_run_twice += run_again(self._store, record, attempts)
        self._deeds.check(report)
        self._care.check(report)
        report.seconds = round(time.monotonic() - self._began, 1)


def run_campaign(
    kills: int | Sequence[str],
    seed: int,
    patience: float,
    *,
    postgresql: bool = False,
    s3: bool = False,
    rows: int = 200,
) -> Report:
    """Run a campaign in a temporary folder; where it fails, the folder stays and is named."""
    folder = Path(tempfile.mkdtemp(prefix="damperlab-faults-"))
    with ExitStack() as stack:
        database = None
        if postgresql:
            database = Database(folder / "postgresql")
            stack.callback(database.close)
        objects = None
        if s3:
            objects = ObjectServer(folder / "s3")
            stack.callback(objects.kill)
            # this process reads the bucket too
            stack.callback(
                os.environ.update, {name: os.environ.get(name, "") for name in objects.environment}
            )
            os.environ.update(objects.environment)
            objects.wait()
        try:
            report = Campaign(folder, seed, database, objects, rows).run(kills, patience)
        except BaseException:
            print(f"data and logs are left in {folder}", file=sys.stderr)
            raise
    if report.good:
        shutil.rmtree(folder)
    else:
        print(f"data and logs are left in {folder}", file=sys.stderr)
    return report


def main() -> int:
    """Run a campaign and print its report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--patience", type=float, default=300.0, help="for the last studies, in seconds")
    parser.add_argument("--rows", type=int, default=200, help="size of a study, in rows of 160 points")
    parser.add_argument(
        "--postgresql", action="store_true", help="the catalogue in PostgreSQL instead of SQLite"
    )
    parser.add_argument("--s3", action="store_true", help="the cubes in an S3 server instead of a folder")
    parser.add_argument("--json", action="store_true", help="the report as JSON instead of a table")
    arguments = parser.parse_args()
    end_on_sigterm()
    report = run_campaign(
        arguments.kills,
        arguments.seed,
        arguments.patience,
        postgresql=arguments.postgresql,
        s3=arguments.s3,
        rows=arguments.rows,
    )
    print(json.dumps(report.document(), indent=2) if arguments.json else report.table())
    return 0 if report.good else 1


if __name__ == "__main__":
    sys.exit(main())
