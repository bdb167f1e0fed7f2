"""A runner that stands still for longer than its claim holds, and wakes while another one is at its study."""

import os
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import psutil
import pytest
from tests.worker.run_here import of_one_piece, submit

import damperlab.studies.store.life_cycle.claims
import damperlab.worker.run.lease
from damperlab.studies.definition import parse_study
from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.store import Store
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.run.progress import Progress
from damperlab.worker.run.runner import run_study

STUDY = parse_study(
    {
        "damping_ratio": 0.05,
        "axes": {
            "friction_ratio": [0.0, 0.2, 0.4, 0.6],
            "frequency_ratio": {"start": 0.7, "stop": 1.3, "num": 60},
        },
        "particle": False,
        "steady": {"max_cycles": 200},
    }
)

_RUN = """
import sys, threading
from pathlib import Path
import damperlab.studies.store.life_cycle.claims, damperlab.worker.run.lease
damperlab.studies.store.life_cycle.claims.CLAIM_SECONDS = 2.0
damperlab.worker.run.lease.RENEW_SECONDS = 0.3
from damperlab.studies.store.store import Store
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.run.runner import run_study

def tell(progress):
    print(progress.blocks_done, flush=True)

if __name__ == "__main__":
    store = Store.open(Path(sys.argv[1]))
    try:
        run_study(store, sys.argv[2], lambda: connect(workers=1), tell, threading.Event())
    finally:
        print("over", flush=True)
"""


def stop_between_transactions(pid: int, catalogue: Path) -> None:
    """Stop a process while it does not hold the catalogue's write lock: nobody else could write until it goes on."""
    while True:
        os.kill(pid, signal.SIGSTOP)
        # the signal takes effect when the process is next scheduled
        while psutil.Process(pid).status() != psutil.STATUS_STOPPED:
            time.sleep(0.001)
        with closing(sqlite3.connect(catalogue, isolation_level=None, timeout=0.0)) as other:
            try:
                other.execute("BEGIN IMMEDIATE")
            except sqlite3.OperationalError:
                os.kill(pid, signal.SIGCONT)
                time.sleep(0.01)
                continue
            other.execute("ROLLBACK")
            return


@pytest.mark.night
def test_a_runner_that_wakes_up_after_its_claim_was_taken_spoils_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(damperlab.studies.store.life_cycle.claims, "CLAIM_SECONDS", 2.0)
    monkeypatch.setattr(damperlab.worker.run.lease, "RENEW_SECONDS", 0.3)
    store = Store.open(tmp_path / "data")
    study_id = submit(store, STUDY, 2).id
    script = tmp_path / "run.py"
    script.write_text(_RUN)
    root = Path(__file__).parents[3]
    first = subprocess.Popen(
        [sys.executable, str(script), str(store.data_dir), study_id],
        stdout=subprocess.PIPE,
        text=True,
        cwd=root,
        env={**os.environ, "PYTHONPATH": str(root)},
        start_new_session=True,
    )
    woken = threading.Event()

    def wake(progress: Progress) -> None:
        if progress.blocks_done > kept and not woken.is_set():
            woken.set()
            # now it finds results of its workers waiting, whose files were swept as the next one began
            os.kill(first.pid, signal.SIGCONT)

    try:
        assert first.stdout is not None
        with first.stdout:
            for line in first.stdout:
                if int(line) >= 5:
                    break
            assert first.poll() is None
            # the coordinator alone: its worker goes on with what it was sent
            stop_between_transactions(first.pid, store.data_dir / "catalogue.sqlite")
            time.sleep(2.5)
            before = store.cube(study_id)["run_time"].values
            kept = store.find(study_id).blocks_done
            record = run_study(store, study_id, lambda: connect(workers=1), wake, threading.Event())
            assert woken.is_set()
            for line in first.stdout:
                if line == "over\n":
                    break
        first.wait(60)
    finally:
        os.killpg(first.pid, signal.SIGKILL) if first.poll() is None else None
        first.wait()
    record = store.find(study_id)
    assert (record.state, record.blocks_done, record.owner) == ("done", record.blocks_total, None)
    collect_garbage(store, -1.0)
    assert list(verify(store, record)) == []
    cube = store.cube(study_id).load()
    done = ~np.isnan(before)
    np.testing.assert_array_equal(before[done], cube["run_time"].values[done])
    assert of_one_piece(store, study_id, STUDY)
    store.close()
