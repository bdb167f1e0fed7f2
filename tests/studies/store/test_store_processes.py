"""Several processes at one store: races, readers beside a writer, and a writer that is killed."""

import subprocess
import sys
import textwrap
import time
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
from tests.filling import enter, make_plan_of, make_study, put
from damperlab.studies.store.store import Store

axes = dict(clearance_ratio={"start": 1, "stop": 9, "num": 9}, friction_ratio={"start": 0, "stop": 0.8, "num": 9},
            restitution=0.5, mass_ratio=0.1, frequency_ratio=[0.9, 1.0, 1.1])
study = make_study("race", axes=axes)
plan = make_plan_of(study)
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
    study_id = enter(store, study).id
    for index in range(plan.count):
        if index in (0, plan.count // 2):
            print(study_id, flush=True); sys.stdin.readline()
        put(store, study, index)
    """
    writer = _start(code, data_dir)
    assert writer.stdout is not None
    assert writer.stdin is not None
    study_id = writer.stdout.readline().strip()
    store = Store.open(data_dir)

    def look() -> int:
        # what the record says is done must be there in full in the cube that is opened after it
        promised = store.find(study_id).points_done
        cube = store.cube(study_id).load()
        there = cube["status"].values == 0
        assert there.sum() >= promised
        for name in set(STANDARD) - {"status"}:
            values = cube[name].values
            np.testing.assert_array_equal(values[there], cube["amplitude_ratio"].values[there])
            np.testing.assert_array_equal(values[~there], VARIABLES[name].fill)
        return int(np.unique(cube["amplitude_ratio"].values[there]).size)

    try:
        writer.stdin.write("go\n")
        writer.stdin.flush()
        writer.stdout.readline()
        seen = [look()]
        assert seen == [BLOCKS // 2]
        writer.stdin.write("go\n")
        writer.stdin.flush()
        deadline = time.monotonic() + SECONDS
        while seen[-1] < BLOCKS:
            assert time.monotonic() < deadline, writer.communicate(timeout=1)[1]
            seen.append(look())
        __, err = writer.communicate(timeout=SECONDS)
        assert writer.returncode == 0, err
        assert sorted(seen) == seen
    finally:
        writer.kill()
        writer.communicate()
        store.close()
