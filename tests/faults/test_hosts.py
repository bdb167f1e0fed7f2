"""A study over several hosts that are cut off, killed, drained and of other people's making: the same bits, nothing failed."""

import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from tests.faults.hosts import Host, NoHosts, hosts
from tests.worker.dispatch.test_workers_judged import ROOT, altered

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.store import Store
from damperlab.worker.block import solve_block
from damperlab.worker.cluster.certificates import make_certificates
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance
from damperlab.worker.worker_process.examination import bits_of

pytestmark = pytest.mark.night

PORT = 8786
WITHOUT_CABLE_SECONDS = 6.0
COORDINATOR = """
import sys, threading
from pathlib import Path
from damperlab.studies.store.store import Store
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.run.runner import run_study

store = Store.open(Path(sys.argv[1]))
last = []

def tell(progress):
    if last != [progress.blocks_done]:
        last[:] = [progress.blocks_done]
        print("done", progress.blocks_done, flush=True)

record = run_study(
    store, sys.argv[2], lambda: connect(scheduler=sys.argv[3]), tell, threading.Event(), wait_seconds=600.0
)
print("ended", record.state, record.points_failed, flush=True)
"""


def hybrid_study() -> Study:
    """36 blocks of 120 points, most of which rattle without end."""
    return parse_study(
        {
            "damping_ratio": 0.0038,
            "axes": {
                "clearance_ratio": {"start": 10, "stop": 20, "num": 12},
                "friction_ratio": [0.2, 0.4, 0.6],
                "frequency_ratio": {"start": 0.98, "stop": 1.02, "num": 120},
                "restitution": 0.47,
                "mass_ratio": 0.1,
            },
        }
    )


@pytest.fixture
def network() -> Iterator[list[Host]]:
    try:
        with hosts("scheduler", "service", "first", "second", "third", "stranger") as found:
            yield found
    except NoHosts as error:
        pytest.skip(str(error))


def until(process: subprocess.Popen[str], says: str) -> list[str]:
    """Read what a process prints until a line begins so; the lines, that one the last."""
    assert process.stdout is not None
    lines: list[str] = []
    for line in process.stdout:
        lines.append(line.rstrip())
        if line.startswith(says) or says in line:
            return lines
    raise AssertionError(f"it ended before it said {says!r}:\n" + "\n".join(lines[-40:]))


def drained(process: subprocess.Popen[str]) -> subprocess.Popen[str]:
    """Read away what a process prints, so that it does not stand still."""
    assert process.stdout is not None
    threading.Thread(target=process.stdout.read, daemon=True).start()
    return process


def test_study_over_hosts_that_fail_has_the_bits_of_an_undisturbed_one(
    network: list[Host], tmp_path: Path
) -> None:
    pytest.importorskip("cryptography")
    scheduling, service, first, second, third, stranger = network
    tls = tmp_path / "tls"
    make_certificates(tls)
    known = {"PYTHONPATH": str(ROOT), "DAMPERLAB_CLUSTER_TLS": str(tls)}
    study = hybrid_study()
    store = Store.open(tmp_path / "data")
    plan = plan_with_chunk(study, (1, 1, 1, 1, 1, 120), seconds_per_point)
    record, _ = store.submit(study, plan, provenance())

    files = [
        f"--tls-{what}={tls / f'{name}.pem'}"
        for what, name in (("ca-file", "ca"), ("cert", "cert"), ("key", "key"))
    ]
    quick = {
        "DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": "10s",
        "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0",
    }
    command = [
        sys.executable,
        "-m",
        "dask",
        "scheduler",
        "--protocol=tls",
        f"--host={scheduling.address}",
        f"--port={PORT}",
    ]
    scheduler = scheduling.start([*command, "--no-dashboard", *files], known | quick)
    until(scheduler, "Scheduler at:")
    drained(scheduler)
    address = f"tls://{scheduling.address}:{PORT}"

    def work(host: Host, environment: dict[str, str] | None = None, *before: str) -> subprocess.Popen[str]:
        command = [*before, sys.executable, "-m", "damperlab", "worker", address, "--leave-within", "30"]
        return drained(host.start(command, known | (environment or {})))

    stale = altered(tmp_path / "stale", "studies/plan.py", "BLOCK_SECONDS = 2.0", "BLOCK_SECONDS = 3.0")
    cover = f'mount -t tmpfs tmpfs "{store.data_dir}" && exec "$0" "$@"'
    work(stranger, {"PYTHONPATH": str(stale)})
    # one without the data
    work(stranger, None, "unshare", "--mount", "sh", "-c", cover)
    work(first)
    work(second)
    leaving = work(third)

    deeds: list[tuple[int, Callable[[], object]]] = [
        (3, lambda: first.cable(False)),
        (6, second.kill),
        (9, lambda: leaving.send_signal(signal.SIGTERM)),
        (9, lambda: work(second)),
        (18, lambda: first.cable(True)),
        (20, lambda: service.cable(False)),
        (20, lambda: threading.Timer(8.0, service.cable, (True,)).start()),
    ]
    running = service.start(
        [sys.executable, "-c", COORDINATOR, str(store.data_dir), record.id, address], known
    )
    assert running.stdout is not None
    said: list[str] = []
    for line in running.stdout:
        said.append(line.rstrip())
        if line.startswith("done "):
            while deeds and int(line.split()[1]) >= deeds[0][0]:
                deeds.pop(0)[1]()
        if line.startswith("ended "):
            break
    assert said[-1] == "ended done 0", "\n".join(said[-30:])
    assert not deeds
    whole = solve_block(study, plan_with_chunk(study, study.shape, seconds_per_point).block(0))
    assert bits_of(whole) == bits_of({name: store.cube(record.id)[name].values for name in whole})
    events = " ".join(what for _, what in store.events(record.id))
    assert "sources" in events
    assert "cannot begin" in events
    store.close()


def test_worker_that_starts_while_its_cable_is_out_joins_by_the_address_at_which_others_reach_it(
    network: list[Host],
) -> None:
    scheduling, _, first, *_ = network
    known = {"PYTHONPATH": str(ROOT), "DAMPERLAB_CLUSTER_TLS": ""}
    address = f"tcp://{scheduling.address}:{PORT}"
    command = [sys.executable, "-m", "dask", "scheduler", f"--host={scheduling.address}", f"--port={PORT}"]
    scheduler = scheduling.start([*command, "--no-dashboard"], known)
    until(scheduler, "Scheduler at:")
    first.cable(False)
    worker = first.start([sys.executable, "-m", "damperlab", "worker", address], known)
    until(worker, f"there is no way to {address} yet")
    # time to take the loopback address, where it would
    time.sleep(WITHOUT_CABLE_SECONDS)
    first.cable(True)
    assert f"tcp://{first.address}:" in until(scheduler, "Register worker addr:")[-1]
