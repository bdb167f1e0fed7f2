"""A study whose catalogue's server is killed while it runs, and comes back."""

from contextlib import closing
from pathlib import Path

import pytest
from tests.faults.processes import Database
from tests.worker.run.test_runner_lost_scheduler import submitted
from tests.worker.run_here import run_here

from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.store import Store
from damperlab.worker.run.progress import Progress


@pytest.mark.parametrize("patience", [300.0, pytest.param(0.0, marks=pytest.mark.night)])
def test_a_catalogue_that_comes_back_in_time_is_gone_on_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, patience: float
) -> None:
    monkeypatch.setattr("damperlab.worker.run.account.REPORT_SECONDS", 0.0)
    with (
        closing(Database(tmp_path / "postgresql")) as server,
        closing(Store.open(tmp_path / "data", server.address)) as store,
    ):
        record = submitted(store, chunk=200)
        kept: list[int] = []
        waited: list[str] = []

        def kill(progress: Progress) -> None:
            if progress.blocks_done and not kept:
                kept.append(progress.blocks_done)
                server.kill()
            if progress.waits_for and not waited:
                waited.append(progress.waits_for)
                server.keep_up()

        if not patience:
            with pytest.raises(StoreFault):
                run_here(store, record.id, kill, return_seconds=patience)
            return
        run_here(store, record.id, kill, return_seconds=patience)
        ended = store.find(record.id)
        assert (ended.state, ended.points_failed, ended.message) == ("done", 0, None)
        assert 0 < kept[0] < ended.blocks_done == ended.blocks_total
        assert "cannot be read or written" in waited[0]
