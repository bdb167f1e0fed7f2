"""Points of earlier studies: taken bit for bit where solver and settings are the same, and never otherwise."""

import time
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.filling import values_of, write, write_behind
from tests.worker.run_here import give_up, planned, run_here, submit

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.store.cube.known_points import known_points
from damperlab.studies.store.record import Record
from damperlab.studies.store.reuse import Overlaps
from damperlab.studies.store.store import Store
from damperlab.worker.worker_process import tasks


def study_of(frequencies: int = 7, start: float = 0.75, stop: float = 1.25, **changes: Any) -> Study:
    axes = {
        "friction_ratio": [0.0, 0.2, 0.4],
        "frequency_ratio": {"start": start, "stop": stop, "num": frequencies},
    }
    document = {"damping_ratio": 0.05, "axes": axes, "particle": False, "steady": {"max_cycles": 200}}
    return parse_study({**document, **changes})


FIRST = study_of()
REFINED = study_of(13)
LONGER = study_of(13, stop=1.75)


def entered(store: Store, study: Study, chunk: int, reuse: bool = True, **facts: str) -> Record:
    return submit(store, study, (1, 1, 1, 1, min(2, study.shape[-2]), chunk), reuse, **facts)


def run(store: Store, study: Study, chunk: int = 4, **options: Any) -> Record:
    return run_here(store, entered(store, study, chunk, **options).id)


def assert_same_bits(one: xr.Dataset, other: xr.Dataset) -> None:
    for name in one.data_vars:
        if name != "run_time":
            assert one[name].values.tobytes() == other[name].values.tobytes(), name


def test_refined_and_longer_axes_take_their_points_and_change_no_bit(store: Store, tmp_path: Path) -> None:
    first = run(store, FIRST)
    assert first.points_reused == 0
    refined = run(store, REFINED, chunk=5)
    assert (refined.state, refined.points_failed) == ("done", 0)
    assert refined.points_reused == 3 * 7
    assert refined.document()["points_reused"] == 21
    # of the band from 0.75 to 1.25 on the twofold coarser grid, and of what the refined one has beside it
    shared = np.intersect1d(
        LONGER.coordinates["frequency_ratio"], REFINED.coordinates["frequency_ratio"]
    ).size
    longer = run(store, LONGER, chunk=6)
    assert longer.points_reused == 3 * shared > 0
    other = Store.open(tmp_path / "alone")
    for record, study in ((refined, REFINED), (longer, LONGER)):
        alone = run(other, study, chunk=5, reuse=False)
        assert alone.points_reused == 0
        assert_same_bits(store.cube(record.id).load(), other.cube(alone.id).load())
    other.close()
    # run times never repeat to the last bit: these were taken, not computed again
    np.testing.assert_array_equal(
        store.cube(refined.id)["run_time"][..., ::2].values, store.cube(first.id)["run_time"].values
    )


@pytest.mark.parametrize(
    ("study", "options"),
    [
        (REFINED, {"reuse": False}),
        (REFINED, {"identity": "of another solver"}),
        (REFINED, {"solver_version": "0.0.0"}),
        (study_of(13, steady={"max_cycles": 201}), {}),
        (study_of(13, damping_ratio=0.051), {}),
        (study_of(13, 0.75000001), {}),
    ],
)
def test_what_is_not_the_same_is_not_taken(store: Store, study: Study, options: dict[str, Any]) -> None:
    first = entered(store, FIRST, 7)
    for index in range(first.blocks_total):
        give_up(store, first, FIRST, index)
    record = entered(store, study, 13, **options)
    plan = planned(study, record.chunk)
    overlaps = Overlaps(store, record)
    shared = [source for index in range(plan.count) for source in overlaps.of(plan.block(index))]
    # only the last frequency of the shifted axis is the same number
    assert sum(source.theirs[-1].size for source in shared) == (
        2 if study.coordinates["frequency_ratio"][0] != 0.75 else 0
    )


def test_points_of_failed_and_of_damaged_blocks_are_computed(store: Store) -> None:
    first = entered(store, FIRST, 4)
    give_up(store, first, FIRST, 0)
    run_here(store, first.id)
    # block 0 failed as a whole; of the three others one is lost
    next(Path(store.cube_path(first.id), "blocks").glob("3~*")).unlink()
    refined = run(store, REFINED, chunk=13)
    frequencies = 7 - 4
    # the one block of friction that meets the lost one takes nothing from this study at all
    assert refined.points_reused == 2 * frequencies
    assert (store.cube(refined.id)["status"] != 5).all()


@pytest.mark.parametrize(
    "damage",
    [
        "UPDATE studies SET name = 'x' WHERE number = 1",
        "UPDATE studies SET box = 'x' WHERE number = 1",
        "DELETE FROM done_blocks WHERE study = 1 AND block = 1",
        "UPDATE studies SET box = '[[1]]' WHERE number = 1",
    ],
)
def test_a_study_is_computed_though_the_catalogue_of_an_earlier_one_is_damaged(
    store: Store, damage: str
) -> None:
    """It takes no points from the damaged one."""
    run(store, FIRST)
    write_behind(store.data_dir, damage)
    with closing(Store.open(store.data_dir)) as again:  # which has read no done-marks yet
        refined = run(again, REFINED, chunk=5)
    assert (refined.state, refined.points_failed, refined.points_reused) == ("done", 0, 0)


def test_known_points_are_found_however_many_studies_came_since(store: Store) -> None:
    fine = {"start": 0.5, "stop": 1.5, "num": 101}
    first = run(store, study_of(axes={"friction_ratio": 0, "frequency_ratio": fine}), chunk=20)
    for place in range(12):
        unrelated = study_of(axes={"friction_ratio": 0, "frequency_ratio": [2.0 + place, 2.5 + place]})
        block = planned(unrelated, 2).block(0)
        write(store, entered(store, unrelated, 2).id, block, values_of(unrelated, block))
    wider = {"start": 0.3, "stop": 1.7, "num": 141}
    longer = run(store, study_of(axes={"friction_ratio": 0, "frequency_ratio": wider}), chunk=20)
    assert longer.points_reused == 101
    tenfold = {"start": 0.5, "stop": 1.5, "num": 1001}
    refined = run(store, study_of(axes={"friction_ratio": 0, "frequency_ratio": tenfold}), chunk=200)
    assert refined.points_reused == 101
    for record in (longer, refined):
        assert np.isin(
            store.cube(first.id)["run_time"].values, store.cube(record.id)["run_time"].values
        ).all()


def test_reading_known_points_counts_as_no_time_in_kernels(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(store, FIRST)

    def slowly(*given: Any) -> Any:
        until = time.thread_time() + 0.3
        while time.thread_time() < until:
            pass
        return known_points(*given)

    monkeypatch.setattr(tasks, "known_points", slowly)
    again = run(store, study_of(4))
    assert again.points_reused == again.points_total
    assert again.kernel_seconds < 0.3
