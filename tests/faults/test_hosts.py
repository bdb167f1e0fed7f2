"""A worker of a host whose cable is out when it starts; `make faults` does the rest to hosts."""

import subprocess
import sys
import time
from collections.abc import Iterator

import pytest
from tests.faults.hosts import Host, NoHosts, hosts
from tests.worker.dispatch.test_workers_judged import ROOT

pytestmark = pytest.mark.night

PORT = 8786
WITHOUT_CABLE_SECONDS = 6.0


@pytest.fixture
def network() -> Iterator[list[Host]]:
    try:
        with hosts("scheduler", "first") as found:
            yield found
    except NoHosts as error:
        pytest.skip(str(error))


def until(process: subprocess.Popen[str], says: str) -> str:
    """Read what a process prints until a line says so; that line."""
    assert process.stdout is not None
    return next(line for line in process.stdout if says in line)


def test_worker_that_starts_while_its_cable_is_out_joins_by_the_address_at_which_others_reach_it(
    network: list[Host],
) -> None:
    scheduling, first = network
    known = {"PYTHONPATH": str(ROOT), "DAMPERLAB_CLUSTER_TLS": ""}
    address = f"tcp://{scheduling.address}:{PORT}"
    command = [sys.executable, "-m", "dask", "scheduler", f"--host={scheduling.address}", f"--port={PORT}"]
    scheduler = scheduling.start([*command, "--no-dashboard"], known)
    until(scheduler, "Scheduler at:")
    first.cable(False)
    worker = first.start([sys.executable, "-m", "damperlab", "admin", "worker", address], known)
    until(worker, f"there is no route to {address} yet")
    # time to take the loopback address, where it would
    time.sleep(WITHOUT_CABLE_SECONDS)
    first.cable(True)
    assert f"tcp://{first.address}:" in until(scheduler, "Register worker addr:")
