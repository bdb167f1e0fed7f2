"""A large study begins with its coarse grid, a study of its own: the same bits, and nothing is computed twice."""

import threading
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
from distributed import Client
from tests.worker.run_here import submit

from damperlab.studies.coarse import coarse
from damperlab.studies.definition import Study, parse_study
from damperlab.studies.remarks import read_remarks
from damperlab.studies.store.life_cycle.wanted import Wanted
from damperlab.studies.store.provenance import ASKED_BY_PROGRAMS, COARSE_OF, SUBMITTED_BY, submitter
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.run import runner
from damperlab.worker.run.preview import Preview
from damperlab.worker.run.progress import Progress
from damperlab.worker.run.runner import run_study


def large(damping_ratio: float) -> Study:
    axes = {
        "friction_ratio": {"start": 0.0, "stop": 0.6, "num": 26},
        "frequency_ratio": {"start": 0.8, "stop": 1.2, "num": 60},
    }
    steady = {"max_cycles": 20}
    return parse_study(
        {"name": "large", "damping_ratio": damping_ratio, "axes": axes, "particle": False, "steady": steady}
    )


@pytest.fixture(autouse=True)
def _previewed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Preview every study: what takes a minute otherwise."""
    monkeypatch.setattr(runner, "PREVIEWED_SECONDS", 0.0)


def run(store: Store, client: Client, study: Study, reuse: bool = True, **options: Any) -> Record:
    record = submit(store, study, None, reuse, **options.pop("facts", {}))
    tell = options.pop("tell", lambda now: None)
    stop = options.pop("stop", threading.Event())
    return run_study(store, record.id, lambda: nullcontext(client), tell, stop, **options)


def grid_of(store: Store, study: Study) -> Record:
    """The coarse grid of a study, of which something is stored."""
    first = coarse(study)
    assert first is not None
    found = store.newest(first.digest)
    assert found is not None
    return found


def test_the_coarse_grid_is_there_before_the_first_block_and_is_taken_over(
    store: Store, client: Client, tmp_path: Path
) -> None:
    study = large(0.05)
    first = coarse(study)
    assert first is not None
    seen: list[tuple[str, int, bool]] = []

    def tell(progress: Progress) -> None:
        found = store.newest(first.digest)
        seen.append((progress.phase, progress.points_done, found is not None and found.state == "done"))

    token = submitter.set("someone")
    try:
        record = run(store, client, study, tell=tell)
    finally:
        submitter.reset(token)
    assert (record.state, record.points_failed) == ("done", 0)
    found = grid_of(store, study)
    assert (found.state, found.points_done) == ("done", first.points)
    assert found.provenance[COARSE_OF] == record.id
    assert found.provenance[SUBMITTED_BY] == record.provenance[SUBMITTED_BY] == "someone"
    # what parts of blocks hold is computed again
    assert 0 < record.points_reused <= first.points
    assert "previewing" in {phase for phase, _, _ in seen}
    assert all(there for phase, done, there in seen if done > 0)

    other = Store.open(tmp_path / "alone")
    alone = run(other, client, study, reuse=False)
    assert [each.id for each in other.page().records] == [alone.id]
    one, two = store.cube(record.id).load(), other.cube(alone.id).load()
    for name in one.data_vars:
        if name != "run_time":
            assert one[name].values.tobytes() == two[name].values.tobytes(), name
    other.close()


def test_a_study_that_is_stopped_meanwhile_stops_and_its_coarse_grid_too(
    store: Store, client: Client
) -> None:
    stop = threading.Event()

    def tell(progress: Progress) -> None:
        if progress.phase == "previewing":
            stop.set()

    study = large(0.06)
    record = run(store, client, study, tell=tell, stop=stop)
    found = grid_of(store, study)
    assert (record.state, record.points_done) == ("cancelled", 0)
    assert found.state in ("cancelled", "done")
    # and goes on from there; a coarse grid that was deleted meanwhile is computed again
    store.delete(found.id)
    record = run(store, client, study)
    assert (record.state, grid_of(store, study).state) == ("done", "done")


def test_a_coarse_grid_that_cannot_be_had_costs_the_study_nothing(store: Store, client: Client) -> None:
    study = large(0.07)
    first = coarse(study)
    assert first is not None
    taken = submit(store, first, None)
    assert store.claim(taken.id, "elsewhere:1:00000000")
    record = run(store, client, study)
    assert (record.state, record.points_reused) == ("done", 0)
    assert store.find(taken.id).state == "queued"


def test_a_budget_is_for_the_study_alone(store: Store, client: Client) -> None:
    record = run(store, client, large(0.08), budget_seconds=3600.0)
    assert record.state == "done"
    assert [each.id for each in store.page().records] == [record.id]


def test_what_a_program_asks_for_has_no_map_that_somebody_waits_for(store: Store, client: Client) -> None:
    asked = [
        run(store, client, large(0.09 + 0.01 * place), facts={name: "something"})
        for place, name in enumerate(ASKED_BY_PROGRAMS)
    ]
    assert {each.state for each in asked} == {"done"}
    assert {each.id for each in store.page().records} == {each.id for each in asked}


def test_a_coarse_grid_is_listed_where_it_is_asked_for_and_once_its_study_is_gone(
    store: Store, client: Client
) -> None:
    study = large(0.12)
    record = run(store, client, study)
    grid = grid_of(store, study)

    def listed(**wanted: Any) -> set[str]:
        return {each.id for each in store.page(wanted=Wanted(**wanted)).records}

    assert listed() == {record.id, grid.id}
    assert listed(coarse=False) == {record.id}
    assert listed(coarse=False, name="large") == {record.id}
    assert store.find(grid.id).id == grid.id
    store.remark(grid.id, read_remarks({"tags": ["kept"]}))
    assert listed(coarse=False, tag="kept") == {grid.id}
    store.delete(record.id)
    assert listed(coarse=False) == {grid.id}


def test_whatever_becomes_of_the_coarse_grid_its_study_goes_on(
    store: Store, client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*given: Any, **named: Any) -> tuple[Record, bool]:
        raise ValueError("a defect")

    monkeypatch.setattr(Preview, "_compute", broken)
    assert run(store, client, large(0.08)).state == "done"


def test_a_coarse_grid_that_waits_and_tells_nothing_stops_with_its_study(store: Store) -> None:
    study = large(0.09)
    record = submit(store, study, None)
    cancelled = threading.Event()
    seen: list[bool] = []

    def waiting(
        store: Store, study_id: str, client: Any, tell: Any, stop: threading.Event, **named: Any
    ) -> Record:
        seen.append(stop.is_set())
        cancelled.set()  # as somebody does while this waits for workers
        seen.append(stop.is_set())
        return store.find(study_id)

    nothing: Any = None
    Preview(store, record, study, nothing, cancelled.is_set, waiting).compute(nothing)
    assert seen == [False, True]
