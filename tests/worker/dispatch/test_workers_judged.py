"""Clusters of other people's machines: whoever cannot compute a study is left out by name, and the study goes on."""

import os
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from tests.other_solver import altered
from tests.worker.dask_processes import dask_process, scheduler_process
from tests.worker.run_here import (
    BLOCKS,
    CHUNK,
    friction_study,
    ignore,
    of_one_piece,
    planned,
    run_here,
    submit,
)

from damperlab.studies.store.store import Store
from damperlab.worker.block import solve_block
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.dispatch.window import Window
from damperlab.worker.provenance import code_hash
from damperlab.worker.run.progress import Progress
from damperlab.worker.run.runner import run_study
from damperlab.worker.worker_process.examination import bits_of, canary_of, examine, majority, stored_bits

ROOT = Path(__file__).parents[3]


@contextmanager
def worker(address: str, *options: str, cwd: Path = ROOT, hidden: Path | None = None) -> Iterator[None]:
    """A worker of Dask's own command, from whose world a folder may be hidden."""
    arguments = (address, "--nthreads=1", "--no-dashboard", *options)
    with dask_process("worker", *arguments, cwd=cwd, hidden=hidden):
        yield


def test_worker_without_keys_to_the_store_cannot_begin_whatever_the_points_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in [name for name in os.environ if name.startswith("AWS_")]:
        monkeypatch.delenv(name)
    study = friction_study()
    canary = canary_of(planned(study, CHUNK), 0)
    with pytest.raises(OSError, match="no keys for the object store"):
        examine("s3://bucket/cubes/of-somebody", study.digest, code_hash(), canary)


WRONG = """
import damperlab.worker.block as block
solve = block.solve_block

def other(*arguments):
    values = solve(*arguments)
    # the last bit
    values["amplitude_ratio"] = values["amplitude_ratio"] * (1.0 + 2.0**-52)
    return values

import damperlab.worker.worker_process.tasks as tasks
tasks.solve_block = other
"""


class AfterABlock(threading.Event):
    """Set once a block of a study is done, however seldom progress is told."""

    def __init__(self, store: Store, study_id: str) -> None:
        super().__init__()
        self._store, self._study_id = store, study_id

    def is_set(self) -> bool:
        return self._store.find(self._study_id).blocks_done > 0


def test_whoever_is_there_is_asked_at_once_each_time(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not a second later because somebody has just looked who is there: every study begins with both questions."""
    record = submit(store)
    canary = canary_of(planned(friction_study(), CHUNK), 0)
    monkeypatch.setattr("damperlab.worker.dispatch.window.LOOK_SECONDS", float("inf"))
    with connect(workers=1) as client:
        window = Window(client, lambda index, key: (abs, index), [0])
        for points in (None, canary):
            asked = examine, store.cube_path(record.id), record.digest, code_hash(), points
            facts = window.assemble(asked, "", "", partial(next, iter([True] * 3000), False))
            assert facts is not None, "nobody was asked"
        window.close()


def test_what_workers_compile_is_no_want_of_workers(store: Store) -> None:
    """Kernels may take longer to compile than a study waits for workers: before their points are asked for, and after."""
    record = submit(store)
    canary = canary_of(planned(friction_study(), CHUNK), 0)
    wait_seconds = 2.0
    with connect(workers=1) as client:
        # whatever it loads first is no part of this
        asked = examine, store.cube_path(record.id), record.digest, code_hash()
        client.run(*asked, canary)
        window = Window(client, lambda index, key: (abs, index), [0], wait_seconds=wait_seconds)
        facts = window.assemble((*asked, None), "", "", lambda: True)
        busy = client.submit(time.sleep, 2.5 * wait_seconds, pure=False)
        time.sleep(1.2 * wait_seconds)
        assert not busy.done()
        assert window.assemble((*asked, canary), facts["identity"], "", lambda: True) == facts
        window.close()


def test_study_goes_on_without_the_stale_the_wrong_and_the_blind(
    store: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One holds other sources, one computes other bits, one has no data folder; two compute."""
    # on a busy machine they come one after the other; no time is lost once all have answered
    monkeypatch.setattr("damperlab.worker.dispatch.examiner.LATE_SECONDS", 600.0)
    record = submit(store)
    # a block or more are known when the workers come
    stop = AfterABlock(store, record.id)
    record = run_here(store, record.id, stop=stop)
    known = record.blocks_done
    assert record.state == "cancelled"
    assert 1 <= known < BLOCKS

    stale = altered(tmp_path / "stale", "studies/plan.py", "BLOCK_SECONDS = 2.0", "BLOCK_SECONDS = 3.0")
    wrong = tmp_path / "wrong.py"
    wrong.write_text(WRONG)
    with ExitStack() as stack:
        address, _ = stack.enter_context(scheduler_process())
        stack.enter_context(worker(address, "--name=stale", cwd=stale))
        stack.enter_context(worker(address, "--name=wrong", f"--preload={wrong}"))
        stack.enter_context(worker(address, "--name=blind", hidden=store.data_dir))
        stack.enter_context(worker(address, "--name=good"))
        with connect(scheduler=address) as client:
            client.wait_for_workers(4, timeout=300)
            at = {one["name"]: at for at, one in client.scheduler_info(n_workers=-1)["workers"].items()}
        record = run_study(store, record.id, lambda: connect(scheduler=address), ignore, threading.Event())
    assert (record.state, record.points_failed, record.blocks_done) == ("done", 0, BLOCKS)
    events = [what for _, what in store.events(record.id)]
    reasons = {
        name: [what for what in events if what.startswith(f"worker {at[name]} is left out")] for name in at
    }
    assert not reasons.pop("good")
    assert "sources" in reasons["stale"][0]
    assert "different bits there" in reasons["wrong"][0]
    assert "cannot begin" in reasons["blind"][0]
    assert all(at[name] in record.message for name in reasons)
    assert of_one_piece(store, record.id, friction_study())


def test_study_waits_for_a_worker_and_says_so(store: Store) -> None:
    record = submit(store)
    told: list[str] = []
    with ExitStack() as stack:
        address, scheduler = stack.enter_context(scheduler_process())

        def hire(progress: Progress) -> None:
            now = store.find(record.id)
            if now.phase == "waiting" and not told:
                told.append(now.message or "")
                stack.enter_context(worker(address))

        ended = run_study(
            store, record.id, lambda: connect(scheduler=address), hire, threading.Event(), wait_seconds=600.0
        )
        assert scheduler.poll() is None, "it is somebody else's, and goes on"
    assert told == ["the cluster has no worker"]
    assert (ended.state, ended.points_failed, ended.message) == ("done", 0, None)


def test_study_that_waits_in_vain_can_be_resumed(store: Store) -> None:
    record = submit(store)
    with scheduler_process() as (address, _):
        record = run_study(
            store, record.id, lambda: connect(scheduler=address), ignore, threading.Event(), wait_seconds=1.0
        )
    assert record.state == "failed"
    assert "no worker could compute for 1 s: the cluster has no worker" in (record.message or "")


def test_stored_answers_have_the_bits_that_workers_compute(store: Store) -> None:
    record = submit(store)
    run_here(store, record.id)
    plan = planned(friction_study(), CHUNK)
    for index in (0, 3, BLOCKS - 1):
        canary = canary_of(plan, index)
        assert 1 < canary.points < plan.block(index).points
        values = solve_block(friction_study(), canary)
        truth = stored_bits(store.cube(record.id), friction_study(), canary, values)
        assert truth == bits_of(values)
        values["amplitude_ratio"].flat[0] = np.nextafter(values["amplitude_ratio"].flat[0], np.inf)
        assert truth != bits_of(values)


def test_more_than_half_must_agree() -> None:
    assert majority({}) is None
    assert majority({"a": "1"}) == "1"
    assert majority({"a": "1", "b": "2"}) is None
    assert majority({"a": "1", "b": "2", "c": "2"}) == "2"
