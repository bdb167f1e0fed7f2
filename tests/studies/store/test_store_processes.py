"""Several processes at one store: races, readers beside a writer, and a writer that is killed."""

import os
import signal
import subprocess
import sys
import textwrap
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from damperlab.studies.store.store import Store
from damperlab.studies.variables import STANDARD, VARIABLES

SECONDS = 900
"""No process of these tests may live longer."""

PREAMBLE = """
import sys
from pathlib import Path
import numpy as np
from damperlab.studies.definition import parse_study
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.cube.cube import stored_variables, write_region
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.store.store import Store

axes = dict(clearance_ratio={"start": 1, "stop": 9, "num": 9}, friction_ratio={"start": 0, "stop": 0.8, "num": 9},
            restitution=0.5, mass_ratio=0.1, frequency_ratio=[0.9, 1.0, 1.1])
study = parse_study({"name": "race", "damping_ratio": 0.0038, "axes": axes})
plan = plan_with_chunk(study, (1, 1, 1, 2, 2, 3), lambda _, at: np.ones(len(at["mass_ratio"])))
outcome = lambda block: BlockOutcome(block.index, block.points, 0, 0.01, 0.01)

def values(block):
    found = {v.name: np.full(block.shape, block.index, v.dtype) for v in stored_variables(study)}
    return found | {"status": np.zeros(block.shape, "i1")}
"""

BLOCKS = 25


def _start(code: str, *arguments: object) -> subprocess.Popen[str]:
    script = PREAMBLE + textwrap.dedent(code)
    return subprocess.Popen(
        [sys.executable, "-W", "error", "-c", script, *map(str, arguments)],
        cwd=Path(__file__).parents[3],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.fixture
def data_dir(tmp_path: Path) -> Path:
    return tmp_path / "data"


def test_a_reader_beside_a_writer_never_sees_a_torn_block(data_dir):
    code = """
    store = Store.open(Path(sys.argv[1]))
    study_id = store.submit(study, plan, {})[0].id
    print(study_id, flush=True); sys.stdin.readline()
    for index in range(plan.count):
        block = plan.block(index)
        write_region(store.cube_path(study_id), block, values(block))
        store.mark(study_id, outcome(block))
    """
    writer = _start(code, data_dir)
    assert writer.stdout is not None
    assert writer.stdin is not None
    study_id = writer.stdout.readline().strip()
    store = Store.open(data_dir)
    try:
        writer.stdin.write("go\n")
        writer.stdin.flush()
        seen: list[int] = []
        deadline = time.monotonic() + SECONDS
        while not seen or seen[-1] < BLOCKS:
            assert time.monotonic() < deadline, writer.communicate(timeout=1)[1]
            # what the record says is done must be there in full in the cube that is opened after it
            promised = store.find(study_id).points_done
            cube = store.cube(study_id).load()
            there = cube["status"].values == 0
            assert there.sum() >= promised
            blocks = np.unique(cube["amplitude_ratio"].values[there])
            seen.append(blocks.size)
            for name in set(STANDARD) - {"status"}:
                values = cube[name].values
                np.testing.assert_array_equal(values[there], cube["amplitude_ratio"].values[there])
                np.testing.assert_array_equal(values[~there], VARIABLES[name].fill)
        __, err = writer.communicate(timeout=SECONDS)
        assert writer.returncode == 0, err
        assert sorted(seen) == seen
        assert any(0 < number < BLOCKS for number in seen)  # it did look while the writer wrote
    finally:
        writer.kill()
        writer.communicate()
        store.close()


def test_a_killed_writer_loses_nothing_that_was_marked_and_is_taken_over(data_dir):
    code = """
    store = Store.open(Path(sys.argv[1]))
    record, _ = store.submit(study, plan, {})
    assert store.claim(record.id, "writer", seconds=float(sys.argv[2]))
    store.set_state(record.id, "running")
    for index in store.pending(record.id):
        block = plan.block(int(index))
        write_region(store.cube_path(record.id), block, values(block))
        store.mark(record.id, outcome(block))
        print(record.id, index, flush=True)
    store.release(record.id, "writer")
    store.set_state(record.id, "done")
    """
    marked: list[int] = []
    for lines in (3, 5, 2):
        writer = _start(code, data_dir, 0.0)  # its claim is as good as expired once it is dead
        assert writer.stdout is not None
        for _ in range(lines):
            study_id, index = writer.stdout.readline().split()
            marked.append(int(index))
        os.kill(writer.pid, signal.SIGKILL)
        rest, _ = writer.communicate(timeout=SECONDS)
        marked += [int(line.split()[1]) for line in rest.splitlines() if line.endswith("\n") or line]
    store = Store.open(data_dir)
    record = store.find(study_id)
    pending = store.pending(study_id)
    assert record.state == "running"  # nobody was left to say otherwise, but nobody holds it
    assert record.owner is None
    assert set(marked).isdisjoint(pending)
    assert len(marked) == len(set(marked))  # nothing was computed twice
    assert record.blocks_done + pending.size == BLOCKS
    cube = store.cube(study_id).load()
    there = cube["status"].values == 0
    assert there.sum() == record.points_done
    for name in set(STANDARD) - {"status"}:
        np.testing.assert_array_equal(cube[name].values[there], cube["amplitude_ratio"].values[there])
    last = _start(code, data_dir, 60.0)
    _, err = last.communicate(timeout=SECONDS)
    assert last.returncode == 0, err
    assert store.find(study_id).state == "done"
    whole = store.cube(study_id).load()
    assert (whole["status"] == 0).all()
    np.testing.assert_array_equal(np.unique(whole["cycles"]), np.arange(BLOCKS))
    store.close()


def test_threads_share_one_store(data_dir):
    store = Store.open(data_dir)
    setup = _start(
        "print(Store.open(Path(sys.argv[1])).submit(study, plan, {})[0].id)",
        data_dir,
    )
    study_id = setup.communicate(timeout=SECONDS)[0].strip()

    def look(_: int) -> int:
        return int((store.cube(study_id)["status"].values == -1).sum() + store.find(study_id).points_done)

    with ThreadPoolExecutor(8) as threads:
        assert set(threads.map(look, range(40))) == {9 * 9 * 3}
    store.close()
