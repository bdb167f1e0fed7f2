"""A disk that is full: the study says so, loses nothing, and goes on when there is room."""

import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from tests.worker.run_here import run_here, submit

import damperlab.studies.store.cubes
from damperlab.studies.definition import parse_study
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.catalogue.home import MARKER
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.run.progress import Progress

STUDY = parse_study(
    {
        "damping_ratio": 0.05,
        "axes": {"friction_ratio": [0.0, 0.2, 0.4, 0.6], "frequency_ratio": [0.8, 0.9, 1.1, 1.2]},
        "particle": False,
        "steady": {"max_cycles": 200},
    }
)


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A small disk of its own."""
    folder = tmp_path / "disk"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=24m", "tmpfs", str(folder)]
    try:
        subprocess.run(command, check=True, capture_output=True, timeout=20)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("a small disk can be mounted by root alone: run the tests in a container with SYS_ADMIN")
    yield folder
    subprocess.run(["umount", "--lazy", str(folder)], check=True, timeout=20)


def fill(disk: Path, leave: int) -> Path:
    """Leave so many bytes free."""
    ballast = disk / "ballast"
    with ballast.open("wb") as file:
        free = shutil.disk_usage(disk).free
        file.write(bytes(max(0, free - leave)))
    return ballast


def run(store: Store, study_id: str, watch: Callable[[Progress], None], continues: bool = False) -> Record:
    """Run a study in this process, which tells after each block how far it is."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("damperlab.worker.run.progress.REPORT_SECONDS", 0.0)
        return run_here(store, study_id, watch, continues=continues)


@pytest.mark.parametrize("reserve", [16 * 2**20, 0])
def test_a_full_disk_stops_a_study_that_goes_on_when_there_is_room(
    disk: Path, monkeypatch: pytest.MonkeyPatch, reserve: int
) -> None:
    monkeypatch.setattr(damperlab.studies.store.cubes, "RESERVE_BYTES", reserve)
    store = Store.open(disk / "data")
    study_id = submit(store, STUDY, 1).id

    def fill_up(progress: Progress) -> None:
        if not ballast:
            # with a reserve too little room for the next block, without one no room even for the catalogue's journal
            ballast.append(fill(disk, reserve - 2**20 if reserve else 0))

    ballast: list[Path] = []
    if reserve:
        record = run(store, study_id, fill_up)
        assert (record.state, record.blocks_done < record.blocks_total) == ("failed", True)
        assert "is full" in record.message
        assert "make room" in record.message
    else:
        # whatever is told, and to whomever: nothing that was acknowledged may be lost
        with suppress(StoreFault):
            run(store, study_id, fill_up)
    kept = store.cube(study_id).load()
    done = store.find(study_id).blocks_done
    assert (kept["status"] == 0).sum() == done < STUDY.points
    ballast[0].unlink()
    record = run(store, study_id, lambda progress: None)
    assert (record.state, record.message, record.blocks_done) == ("done", None, STUDY.points)
    assert list(verify(store, record)) == []
    whole = store.cube(study_id).load()
    times = kept["run_time"].values
    # run times never repeat: what was done before was not computed again
    np.testing.assert_array_equal(times[~np.isnan(times)], whole["run_time"].values[~np.isnan(times)])
    assert sum(1 for _ in Path(store.cube_path(study_id), "blocks").iterdir()) == STUDY.points
    store.close()


def test_a_disk_that_takes_no_more_files_is_full_wherever_it_is_mounted(disk: Path) -> None:
    store = Store.open(disk.parent / "data")
    cubes = disk.parent / "data" / "cubes"
    command = ["mount", "-t", "tmpfs", "-o", "size=64m,nr_inodes=80", "tmpfs", str(cubes)]
    marker = (cubes / MARKER).read_bytes()
    subprocess.run(command, check=True, capture_output=True, timeout=20)
    (cubes / MARKER).write_bytes(marker)
    try:
        assert store.trouble() is None
        for number in range(30):
            (cubes / str(number)).write_text("")
        assert "more files" in (store.trouble() or "")
        for number in range(30):
            (cubes / str(number)).unlink()
        assert store.trouble() is None
    finally:
        subprocess.run(["umount", "--lazy", str(cubes)], check=True, timeout=20)
        store.close()


def test_a_study_waits_while_the_disk_of_the_cubes_is_not_mounted(tmp_path: Path) -> None:
    """The disk goes while a study is computed: nothing is written below its mount point, and what was done goes on."""
    store = Store.open(tmp_path / "data")
    study_id = submit(store, STUDY, 1).id
    cubes, disk = tmp_path / "data" / "cubes", tmp_path / "disk"

    def unmount(progress: Progress) -> None:
        if progress.blocks_done and not disk.exists():
            cubes.rename(disk)
            cubes.mkdir()

    record = run(store, study_id, unmount, continues=True)
    assert record.state == "queued"
    assert "mounted" in (record.message or "")
    assert 1 <= record.blocks_done < STUDY.points
    other = parse_study({**STUDY.document(), "damping_ratio": 0.06})
    with pytest.raises(StoreFault, match="mounted"):
        submit(store, other, 1)
    assert list(cubes.iterdir()) == []
    cubes.rmdir()
    disk.rename(cubes)
    assert run(store, study_id, lambda progress: None).state == "done"
    assert list(verify(store, store.find(study_id))) == []
    store.close()
