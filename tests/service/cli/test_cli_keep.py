"""verify, backup, restore, gc: as users run them, on a copy of a study that `damperlab run` has computed."""

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.faults.damage import make_store
from tests.service.cli.commands import run

from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.store import Store


@pytest.fixture
def store(stored: tuple[Path, dict[str, Any]], tmp_path: Path) -> Iterator[Store]:
    shutil.copytree(stored[0], tmp_path / "data")
    opened = Store.open(tmp_path / "data")
    yield opened
    opened.close()


def test_damage_is_found_and_repaired(store: Store) -> None:
    (record,) = store.page().records
    before = store.cube(record.id).load()
    file = next(Path(store.cube_path(record.id), "blocks").iterdir())
    file.write_bytes(file.read_bytes()[:40])
    # never a curve of fill values
    assert "verify --repair" in run("response", record.id, "--data-dir", store.data_dir, status=1).stderr
    assert "lock 0" in run("verify", "--data-dir", store.data_dir, status=1).stderr
    answer = run("verify", record.id, "--repair", "--workers", "1", "--data-dir", store.data_dir, "--json")
    (mended,) = json.loads(answer.stdout)["studies"]
    assert (mended["repaired"], [damage["block"] for damage in mended["damaged"]]) == (True, [0])
    after = store.cube(record.id).load()
    assert after.drop_vars("run_time").equals(before.drop_vars("run_time"))
    assert list(verify(store, store.find(record.id))) == []


@pytest.mark.parametrize("state", ["done", "cancelled"])
def test_a_lost_block_is_computed_again(store: Store, linear_study: Path, state: str) -> None:
    (record,) = store.page().records
    before = store.cube(record.id).load()
    store.set_state(record.id, state)
    shutil.rmtree(Path(store.cube_path(record.id), "blocks"))
    said = run("run", linear_study, "--data-dir", store.data_dir).stderr
    assert "lost the file" in said
    assert "nothing was computed" not in said
    assert store.cube(record.id).load().drop_vars("run_time").equals(before.drop_vars("run_time"))
    assert list(verify(store, store.find(record.id))) == []
    again = run("run", linear_study, "--data-dir", store.data_dir).stderr
    assert "nothing was computed" in again


def test_results_of_another_solver_are_repaired_as_far_as_nothing_is_computed(tmp_path: Path) -> None:
    data = tmp_path / "data"
    make_store(data)
    store = Store.open(data)
    record = store.find("done")
    before = store.cube(record.id).load()
    description = Path(store.cube_path(record.id), "zarr.json")
    description.write_bytes(description.read_bytes().replace(b"0.47", b"0.57", 1))
    said = run(
        "map", record.id, "--x", "clearance_ratio", "--y", "friction_ratio", "--data-dir", data, status=1
    )
    assert "verify" in said.stderr
    run("verify", record.id, "--repair", "--data-dir", data)
    assert list(verify(store, record)) == []
    assert store.cube(record.id).load().identical(before)
    next(Path(store.cube_path(record.id), "blocks").iterdir()).unlink()
    refused = run("verify", record.id, "--repair", "--data-dir", data, status=1).stderr
    assert "damperlab recompute" in refused
    refused = run("resume", record.id, "--data-dir", data, status=1).stderr
    assert "damperlab recompute" in refused
    assert store.find(record.id).blocks_done == 12  # nothing is given up that this solver may not compute
    store.close()


def test_a_study_that_another_solver_began_is_left_as_it_is_with_one_advice(tmp_path: Path) -> None:
    make_store(tmp_path)
    said = run("resume", "half", "--data-dir", tmp_path, status=1).stderr
    assert "damperlab recompute" in said
    assert "damperlab resume" not in said
    store = Store.open(tmp_path)
    assert (store.find("half").state, store.find("half").message) == ("cancelled", None)
    store.close()


def test_backup_and_restore(store: Store, tmp_path: Path) -> None:
    run("backup", tmp_path / "safe", "--data-dir", store.data_dir)
    again = run("backup", tmp_path / "safe", "--data-dir", store.data_dir, "--json")
    assert json.loads(again.stdout)["bytes"] == 0
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "notes").write_text("mine")
    refused = run("backup", tmp_path / "other", "--data-dir", store.data_dir, status=2).stderr
    assert "holds other files" in refused
    restored = run("restore", tmp_path / "safe", "--data-dir", tmp_path / "new", "--json")
    assert json.loads(restored.stdout)["studies"] == 1
    new = Store.open(tmp_path / "new")
    (record,) = new.page().records
    assert new.cube(record.id).load().identical(store.cube(record.id).load())
    new.close()


def test_gc_removes_what_is_old_enough(store: Store) -> None:
    orphan = store.data_dir / "cubes" / "000000000000-1.zarr"  # study 1 is another one
    orphan.mkdir()
    young = run("gc", "--json", "--data-dir", store.data_dir)
    assert (json.loads(young.stdout)["paths"], orphan.exists()) == (0, True)
    swept = run("gc", "--older-than", "0s", "--json", "--data-dir", store.data_dir)
    assert (json.loads(swept.stdout)["paths"], orphan.exists()) == (1, False)


def test_a_study_beyond_the_quota_is_refused_with_what_to_do(tmp_path: Path, linear_study: Path) -> None:
    refused = run("run", linear_study, "--quota", "1kB", "--data-dir", tmp_path, status=1).stderr
    assert "1,000 bytes" in refused
    assert "damperlab delete" in refused
    unread = run("run", linear_study, "--quota", "much", "--data-dir", tmp_path, status=2).stderr
    assert '`--quota` must be a size, such as 50GB, not the text "much".' in unread
    assert [path.name for path in (tmp_path / "cubes").iterdir()] == ["damperlab.json"]
