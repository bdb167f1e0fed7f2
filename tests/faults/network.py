"""A fault campaign over hosts: machines die, links are cut, strangers join, and every study must end as if none of it had been.

Storage (PostgreSQL and an S3 server), a scheduler, the service and three workers live in network namespaces of their own,
under TLS. While studies are computed faults are drawn one after the other: hosts are killed, cables pulled and plugged in
again, workers drained, servers killed and started anew, and workers join that hold other sources, no keys to the store, or no
certificate. At the end every study is done without a failed point, and every cube equals bit for bit what the solver gives in
one undisturbed piece (run_time aside); a done-mark that was seen once has stayed as it was.
"""

import argparse
import os
import re
import signal
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

from tests.faults.hosts import Host, NoHosts, hosts
from tests.faults.machines import Machine, PostgreSQL
from tests.faults.processes import ObjectServer, Process, WorkerProcess, end_on_sigterm, until_it_works
from tests.faults.report import Report, traces
from tests.faults.watching import LOOK_SECONDS, Watching
from tests.other_solver import altered

from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.store import Store
from damperlab.worker.cluster.certificates import make_certificates

FAULTS = {
    "worker host killed": 6,
    "worker cut off": 6,
    "worker drained": 5,
    "stale worker joins": 3,
    "worker without keys joins": 3,
    "worker without certificate joins": 1,
    "service killed": 3,
    "service restarted": 2,
    "service cut off": 3,
    "scheduler killed": 1,
    "scheduler cut off": 1,
    "database killed": 2,
    "objects killed": 2,
    "storage cut off": 2,
}
"""How often each is drawn, relative to the others; each comes once before any comes again."""
CUT_SECONDS = 2.0, 25.0
"""How long a cable is out: some cuts are shorter than what the scheduler waits for a worker, some longer."""
STAY_SECONDS = 45.0
"""How long a stranger stays."""
BETWEEN_SECONDS = 1.0, 8.0
"""From one fault to the next."""
_DEFECT = re.compile(r" (?:ERROR|CRITICAL) damperlab|met a defect")
"""In the service's log; Dask logs a scheduler that is lost with its own traceback."""
SCHEDULER_PORT, SERVICE_PORT = 8786, 8000


class Campaign(Watching):
    """One campaign."""

    def __init__(self, folder: Path, found: Sequence[Host], seed: int) -> None:
        storage, scheduling, service, *working, stranger = found
        self._folder = folder
        self._stranger = stranger
        database = PostgreSQL(folder / "database", storage)
        objects = ObjectServer(folder / "objects", storage)
        self._database = database
        make_certificates(folder / "tls")
        certificates = {"DAMPERLAB_CLUSTER_TLS": str(folder / "tls")}
        # the hosts are nobody else's, and what travels between them is read by nobody
        keys = objects.environment | {"AWS_ALLOW_HTTP": "true"}
        address = f"tls://{scheduling.address}:{SCHEDULER_PORT}"
        files = (("ca-file", "ca"), ("cert", "cert"), ("key", "key"))
        self._worker = (sys.executable, "-m", "damperlab", "admin", "worker", address, "--leave-within", "20")
        python = (sys.executable, "-m")

        def part(host: Host, name: str, *command: str, **environment: str) -> Machine:
            log = folder / f"{host.name.partition('-')[2]}.log"
            kind = WorkerProcess if name == "worker" else Process
            return Machine(host, {name: kind(log, *host.inside(*command), **environment)})

        self._storage = Machine(storage, {"database": database, "objects": objects})
        self._scheduler = part(
            scheduling,
            "scheduler",
            *python,
            *("dask", "scheduler", "--protocol=tls", f"--host={scheduling.address}"),
            *(f"--port={SCHEDULER_PORT}", "--no-dashboard"),
            *(f"--tls-{what}={folder / 'tls' / f'{name}.pem'}" for what, name in files),
            DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL="10s",
            DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES="0",
        )
        self._service = part(
            service,
            "service",
            *python,
            *("damperlab.service.cli.main", "serve"),
            DAMPERLAB_WARM="false",
            DAMPERLAB_HOST=service.address,
            DAMPERLAB_PORT=str(SERVICE_PORT),
            DAMPERLAB_ACCESS="open",
            DAMPERLAB_DATA_DIR=str(folder / "data"),
            DAMPERLAB_CATALOGUE=database.address,
            DAMPERLAB_STORE=objects.address,
            DAMPERLAB_SCHEDULER=address,
            **certificates,
            **keys,
        )
        self._workers = [part(host, "worker", *self._worker, **certificates, **keys) for host in working]
        self._machines = [self._storage, self._scheduler, self._service, *self._workers]
        stale = altered(folder / "stale", "studies/plan.py", "BLOCK_SECONDS = 2.0", "BLOCK_SECONDS = 3.0")
        nothing = keys | {"AWS_ACCESS_KEY_ID": "", "AWS_SECRET_ACCESS_KEY": ""}
        self._strangers = {
            "stale worker joins": {**certificates, **keys, "PYTHONPATH": str(stale)},
            "worker without keys joins": {**certificates, **nothing},
            "worker without certificate joins": {**keys, "DAMPERLAB_CLUSTER_TLS": ""},
        }
        self._guests: list[tuple[float, Process]] = []
        for server in (database, objects):
            server.keep_up()
        os.environ.update(keys)
        objects.wait()
        places = folder / "data", database.address, objects.address
        store = until_it_works(lambda: Store.open(*places), StoreFault, 60.0)
        url = f"http://{service.address}:{SERVICE_PORT}"
        super().__init__(store, url, Report("PostgreSQL, S3, seven hosts", seed))

    def run(self, faults: int) -> Report:
        """Let so many faults happen, let every study end, and compare."""
        try:
            self.suffer(self._draw(faults), BETWEEN_SECONDS)
            while not all(machine.plugged for machine in self._machines):
                self.go_on(LOOK_SECONDS, submit=False)
        finally:
            # storage goes on: what it holds is read below
            for _, guest in self._guests:
                guest.kill()
            for machine in self._machines[1:]:
                machine.kill()
        self._finish()
        self._store.close()
        return self._report

    def close(self) -> None:
        """End the storage."""
        self._storage.kill()
        self._database.close()

    def _draw(self, faults: int) -> list[str]:
        first = list(FAULTS)
        self._random.shuffle(first)
        more = self._random.choices(list(FAULTS), list(FAULTS.values()), k=max(0, faults - len(first)))
        return [*first, *more][:faults]

    def do(self, fault: str) -> None:
        """Let a fault happen."""
        print(f"{time.monotonic() - self._began:5.0f} s: {fault}", file=sys.stderr, flush=True)
        worker = self._random.choice(self._workers)
        seconds = self._random.uniform(*CUT_SECONDS)
        if fault in self._strangers:
            self._invite(fault)
            return
        deeds: dict[str, Callable[[], object]] = {
            "worker host killed": worker.kill,
            "worker cut off": lambda: worker.cut(seconds),
            "worker drained": lambda: worker.parts["worker"].tell(signal.SIGTERM),
            "service killed": self._service.kill,
            "service restarted": lambda: self._service.parts["service"].tell(signal.SIGTERM),
            "service cut off": lambda: self._service.cut(seconds),
            "scheduler killed": self._scheduler.kill,
            "scheduler cut off": lambda: self._scheduler.cut(seconds),
            "database killed": self._storage.parts["database"].kill,
            "objects killed": self._storage.parts["objects"].kill,
            "storage cut off": lambda: self._storage.cut(seconds),
        }
        deeds[fault]()

    def _invite(self, kind: str) -> None:
        """Let somebody join who must not compute."""
        log = self._folder / "strangers.log"
        guest = Process(log, *self._stranger.inside(*self._worker), **self._strangers[kind])
        guest.keep_up()
        self._guests.append((time.monotonic() + STAY_SECONDS, guest))

    def keep_up(self) -> None:
        """Start what is down, and send strangers away when their time is over."""
        for machine in self._machines:
            machine.keep_up()
        now = time.monotonic()
        for leaves, guest in self._guests:
            if leaves < now:
                guest.kill()
        self._guests = [each for each in self._guests if each[0] >= now]

    def _finish(self) -> None:
        report = self._report
        for record in self._compare():
            report.left_out += sum("is left out" in what for _, what in self._store.events(record.id))
        log = (self._folder / "service.log").read_text(errors="replace")
        report.false_alarms = len(_DEFECT.findall(log))
        report.seconds = round(time.monotonic() - self._began, 1)


def run_campaign(faults: int, seed: int) -> Report:
    """Run a campaign in a temporary folder; where it fails, the folder stays and is named.

    Raises
    ------
    NoHosts
        This machine lets nobody make hosts.
    """
    names = ("storage", "scheduler", "service", "first", "second", "third", "stranger", "desk")
    with hosts(*names) as found, traces("network") as (folder, reports):
        # the database's own user must get there
        folder.chmod(0o755)
        found[-1].enter()
        with closing(Campaign(folder, found[:-1], seed)) as campaign:
            report = campaign.run(faults)
        reports.append(report)
    return report


def main() -> int:
    """Run a campaign and print its report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faults", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    end_on_sigterm()
    try:
        report = run_campaign(arguments.faults, arguments.seed)
    except NoHosts as error:
        print(error, file=sys.stderr)
        return 2
    print(report.table())
    return 0 if report.good else 1


if __name__ == "__main__":
    sys.exit(main())
