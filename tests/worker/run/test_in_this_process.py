"""Small studies computed in the process that runs them: the same values as by the solver alone, and no cluster is started."""

import subprocess
import sys
import threading
from contextlib import closing
from itertools import count
from pathlib import Path

import pytest
from tests.worker.run_here import AMPLE_SECONDS

from damperlab.studies.store.files.shelf import ShelfAway
from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.outcomes import RETRIES, Failure, Outage
from damperlab.worker.run.in_this_process import InThisProcess


def test_a_closed_form_study_is_run_without_loading_the_library_of_the_cluster(tmp_path: Path) -> None:
    file = tmp_path / "study.yaml"
    file.write_text("particle: false\naxes: {friction_ratio: 0, frequency_ratio: [0.5, 2]}\n")
    script = f"""
import sys
sys.argv = ["damperlab", "run", {str(file)!r}, "--data-dir", {str(tmp_path / "data")!r}, "--json"]
from damperlab.service.cli.main import main
try:
    main()
finally:
    print([name for name in ("dask", "distributed", "xarray") if name in sys.modules], file=sys.stderr)
"""
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    assert ended.stderr.splitlines()[-1] == "[]"


def test_a_block_is_tried_again_and_given_up_as_on_a_cluster() -> None:
    attempts = count()

    def run() -> BlockOutcome:
        next(attempts)
        raise ArithmeticError("no number")

    with closing(InThisProcess(lambda index, key: (run,), iter([7]))) as here:
        here.fill()
        assert list(here.drain(0.0)) == [Failure(7, "ArithmeticError: no number")]
        assert next(attempts) == RETRIES + 1
        assert here.empty


def test_data_out_of_reach_is_an_outage_at_once() -> None:
    def run() -> BlockOutcome:
        raise ShelfAway("the bucket is away")

    with closing(InThisProcess(lambda index, key: (run,), iter([0]))) as here:
        here.fill()
        with pytest.raises(Outage, match="the bucket is away"):
            list(here.drain(0.0))


def test_every_core_has_a_block(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("damperlab.worker.run.in_this_process.core_count", lambda: 3)
    together = threading.Barrier(3, timeout=AMPLE_SECONDS)

    def run(index: int) -> BlockOutcome:
        if index < 3:
            together.wait()  # each goes on once all three are at it
        return BlockOutcome(index, 1, 0, 1.0, 1.0)

    with closing(InThisProcess(lambda index, key: (run, index), iter(range(4)))) as here:
        ended: set[int] = set()
        here.fill()
        while not here.empty:
            ended |= {outcome.index for outcome in here.collect(AMPLE_SECONDS)}
            here.fill()
    assert ended == {0, 1, 2, 3}
