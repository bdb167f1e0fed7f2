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
import os
import sys
import time
from contextlib import ExitStack, closing
from pathlib import Path

from tests.faults.attempts import FOLDER, read_attempts
from tests.faults.care import Care
from tests.faults.compare import run_again
from tests.faults.deeds import Deeds
from tests.faults.processes import (
    Database,
    ObjectServer,
    Process,
    Victim,
    WorkerProcess,
    dask,
    end_on_sigterm,
)
from tests.faults.report import Report, traces
from tests.faults.watching import Watching, study_of
from tests.ports import free_port

from damperlab.studies.store.store import Store

VICTIMS = {"worker": 5, "service": 3, "care": 3, "scheduler": 1, "all": 1, "database": 1, "store": 1}
"""How often each is killed, relative to the others; a lost scheduler costs the service a longer wait."""
DEEDS_A_LOOK = 0.05
"""How often, a look, what users ask of the stored studies is asked: at random, so that kills come before and after."""


class Campaign(Watching):
    """One campaign."""

    def __init__(
        self, folder: Path, seed: int, database: Database | None, objects: ObjectServer | None
    ) -> None:
        self._folder = folder
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
                WorkerProcess(
                    folder / f"worker-{number}.log",
                    *(sys.executable, "-m", "damperlab", "admin", "worker", address),
                    **{FOLDER: str(folder), "DASK_DISTRIBUTED__WORKER__PRELOAD": "['tests.faults.attempts']"},
                    **secrets,
                )
                for number in range(2)
            ],
            "service": [
                Process(
                    folder / "service.log",
                    *(sys.executable, "-m", "damperlab.service.cli.main", "serve"),
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
        super().__init__(store, f"http://127.0.0.1:{self._port}", Report(backend, seed))
        self._care = Care(folder, self._store, database.address if database else "", **secrets)
        self._victims["care"] = [self._care]
        self._victims["all"] = [each for kind in self._victims.values() for each in kind]
        # before anything is killed: what is asked of it is asked while that happens
        catalogue = {"DAMPERLAB_CATALOGUE": settings["DAMPERLAB_CATALOGUE"]} if database else {}
        self._deeds = Deeds(folder, self._store, study_of, **secrets, **catalogue)

    def run(self, kills: int) -> Report:
        """Kill so often, let the last studies end, and compare."""
        weights = {name: weight for name, weight in VICTIMS.items() if name in self._victims}
        drawn = (self._random.choices(list(weights), list(weights.values()))[0] for _ in range(kills))
        try:
            self.suffer(drawn, (0.0, 5.0))
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

    def pending(self) -> bool:
        """Whether something that users ask has not been answered yet."""
        return self._deeds.pending

    def do(self, fault: str) -> None:
        """Kill one of a kind, or all."""
        chosen = self._victims[fault]
        for process in chosen if fault == "all" else [self._random.choice(chosen)]:
            process.kill()

    def keep_up(self) -> None:
        """Start what is down, and now and then do what users do."""
        for process in self._victims["all"]:
            process.keep_up()
        if self._deeds.pending and self._random.random() < DEEDS_A_LOOK:
            self._deeds.step(self._port)
            self._studies |= self._deeds.studies

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


def run_campaign(kills: int, seed: int, *, postgresql: bool, s3: bool) -> Report:
    """Run a campaign in a temporary folder; where it fails, the folder stays and is named."""
    with traces("faults") as (folder, reports), ExitStack() as stack:
        database = stack.enter_context(closing(Database(folder / "postgresql"))) if postgresql else None
        objects = None
        if s3:
            objects = ObjectServer(folder / "s3")
            stack.callback(objects.kill)
            # this process reads the bucket too
            os.environ.update(objects.environment)
            objects.wait()
        report = Campaign(folder, seed, database, objects).run(kills)
        reports.append(report)
    return report


def main() -> int:
    """Run a campaign and print its report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--postgresql", action="store_true", help="the catalogue in PostgreSQL, not SQLite")
    parser.add_argument("--s3", action="store_true", help="the cubes in an S3 server instead of a folder")
    arguments = parser.parse_args()
    end_on_sigterm()
    report = run_campaign(**vars(arguments))
    print(report.table())
    return 0 if report.good else 1


if __name__ == "__main__":
    sys.exit(main())
