"""Clusters of real processes on loopback: what connects, what is refused, and what is left behind."""

import os
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import psutil
import pytest

from damperlab.worker.cluster.cluster import connect
from damperlab.worker.cores import core_count
from damperlab.worker.niceness import NICENESS
from damperlab.worker.outcomes import ClusterUnusable, SchedulerLost

ROOT = Path(__file__).parents[3]


def _threads_environment() -> dict[str, str | None]:
    return {
        name: os.environ.get(name)
        for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
    }


def _working(parent: psutil.Process) -> list[psutil.Process]:
    # multiprocessing's own tracker stays until the process ends and holds nothing.
    return [
        child
        for child in parent.children(recursive=True)
        if "resource_tracker" not in " ".join(child.cmdline())
    ]


def _gone(processes: list[psutil.Process], seconds: float = 120.0) -> bool:
    _, alive = psutil.wait_procs(processes, timeout=seconds)
    return not alive


@pytest.mark.usefixtures("anew")
def test_local_workers_have_one_thread_each_and_listen_on_loopback_only() -> None:
    with connect(workers=1) as client:
        assert list(client.nthreads().values()) == [1]
        for environment in client.run(_threads_environment).values():
            assert set(environment.values()) == {"1"}
        # what computes stands back behind the process that answers; 19 is the end of the scale
        assert set(client.run(os.nice, 0).values()) == {min(19, os.nice(0) + NICENESS)}
        # Ctrl-C in a terminal reaches a worker that still loads its modules, too
        for worker in client.run(os.getpid).values():
            status = Path(f"/proc/{worker}/status").read_text()
            blocked = int(status.partition("SigBlk:")[2].split()[0], 16)
            assert blocked & 1 << signal.SIGINT - 1
        me = psutil.Process()
        listening = [
            connection.laddr.ip
            for process in (me, *_working(me))
            for connection in process.net_connections()
            if connection.status == psutil.CONN_LISTEN
        ]
        assert listening
        assert set(listening) == {"127.0.0.1"}


@pytest.mark.parametrize("dies", [True, False])
def test_what_the_library_meets_where_its_scheduler_has_died_is_a_lost_scheduler(dies: bool) -> None:
    """A connection that ends before it is encrypted is a ValueError; one that the scheduler does not explain stays one.

    No process is left in either case.
    """
    begun: list[psutil.Process] = []

    def meet() -> None:
        with connect(workers=1) as client:
            scheduler = client.run_on_scheduler(os.getpid)
            begun.extend(map(psutil.Process, (scheduler, *client.run(os.getpid).values())))
            if dies:
                begun[0].kill()
            raise ValueError("IOStream is not idle; cannot convert to SSL")

    with pytest.raises(SchedulerLost if dies else ValueError) as seen:
        meet()
    assert "IOStream" in str(seen.value.__cause__ if dies else seen.value)
    assert len(begun) == 2
    assert _gone(begun)


# A shell ignores Ctrl-C for what it starts in the background, and its children inherit that.
_HOLD = """
import signal, sys, time
from damperlab.studies.store.solver import identity_of
from damperlab.worker.cluster.cluster import connect
if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with connect(workers=2) as client:
        print(" ".join(str(pid) for pid in client.run(__import__("os").getpid).values()), flush=True)
        time.sleep(600)
"""


@pytest.mark.usefixtures("anew")
@pytest.mark.parametrize(
    ("number", "whole_group"),
    [pytest.param(signal.SIGINT, True, marks=pytest.mark.night), (signal.SIGKILL, False)],
)
def test_no_worker_outlives_its_coordinator(tmp_path: Path, number: int, whole_group: bool) -> None:
    script = tmp_path / "hold.py"
    script.write_text(_HOLD)
    process = subprocess.Popen(
        [sys.executable, str(script)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        start_new_session=True,
    )
    try:
        workers = [psutil.Process(int(pid)) for pid in process.stdout.readline().split()]
        assert len(workers) == 2
        # A terminal's Ctrl-C reaches every process of the group, the workers too.
        (os.killpg if whole_group else os.kill)(process.pid, number)
        _, errors = process.communicate(timeout=120)
        assert _gone(workers)
        if whole_group:
            assert errors.count("Traceback") == 1, errors
    finally:
        process.kill()
        process.wait()


@pytest.mark.parametrize("address", ["garbage", "", "ftp://127.0.0.1:3", "tcp://127.0.0.1:1", "mute"])
def test_what_is_no_scheduler_is_refused_and_leaves_no_thread(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("damperlab.worker.cluster.cluster.SCHEDULER_TIMEOUT_SECONDS", 1.0)
    before = threading.active_count()
    with socket.create_server(("127.0.0.1", 0)) as mute:
        if address == "mute":
            address = f"tcp://127.0.0.1:{mute.getsockname()[1]}"
        with pytest.raises(ClusterUnusable) as refused, connect(scheduler=address):
            pass
    assert repr(address) in refused.value.fault.found
    assert threading.active_count() <= before


@pytest.mark.parametrize(
    "asked", [{"workers": 0}, {"workers": -3}, {"workers": 2, "scheduler": "tcp://127.0.0.1:8786"}], ids=str
)
def test_what_can_be_no_cluster_is_refused(asked: dict[str, Any]) -> None:
    with pytest.raises(ClusterUnusable), connect(**asked):
        pass


@pytest.mark.skipif(sys.platform != "linux", reason="affinity is read on Linux only")
def test_core_count_follows_the_affinity() -> None:
    allowed = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {min(allowed)})
        assert core_count() == 1
    finally:
        os.sched_setaffinity(0, allowed)
