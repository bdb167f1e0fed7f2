"""A study whose catalogue's server is killed while it runs, and comes back."""

import threading
from contextlib import closing
from pathlib import Path

import pytest
from tests.faults.processes import Database
from tests.worker.run.test_runner_lost_scheduler import submitted

from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.store import Store
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.run.progress import Progress
from damperlab.worker.run.runner import run_study


@pytest.mark.parametrize("patience", [300.0, 0.0])
def test_a_catalogue_that_comes_back_in_time_is_gone_on_with(tmp_path: Path, patience: float) -> None:
    with (
        closing(Database(tmp_path / "postgresql")) as server,
        closing(Store.open(tmp_path / "data", server.address)) as store,
    ):
        record = submitted(store)
        kept: list[int] = []
        waited: list[str] = []

        def kill(progress: Progress) -> None:
            if progress.blocks_done and not kept:
                kept.append(progress.blocks_done)
                server.kill()
            if progress.waits_for and not waited:
                waited.append(progress.waits_for)
                server.keep_up()

        def run() -> None:
            # in this process
            arguments = store, record.id, connect, kill, threading.Event()
            run_study(*arguments, here_seconds=1e9, return_seconds=patience)

        if not patience:
            with pytest.raises(StoreFault):
                run()
            return
        run()
        ended = store.find(record.id)
        assert (ended.state, ended.points_failed, ended.message) == ("done", 0, None)
        assert 0 < kept[0] < ended.blocks_done == ended.blocks_total
        assert "cannot be read or written" in waited[0]
