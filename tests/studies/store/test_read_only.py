"""A data folder on a disk that cannot be written is read like any other, and nothing of it is changed."""

import os
import shutil
import sqlite3
import subprocess
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest
from tests.filling import enter, entered, make_study, put

from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.catalogue.catalogue import SQLITE_FILE
from damperlab.studies.store.catalogue.quota import Quota
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.store import Store


@pytest.fixture
def frozen(tmp_path: Path) -> Iterator[Callable[[Path], Path]]:
    """Give a copy of a folder that nobody can write; root needs a disk of its own for that."""
    folder = tmp_path / "frozen"
    folder.mkdir()
    mounted = os.geteuid() == 0
    if mounted:
        command = ["mount", "-t", "tmpfs", "tmpfs", str(folder)]
        if subprocess.run(command, capture_output=True, timeout=20, check=False).returncode:
            pytest.skip("root writes everywhere, and may not mount a disk here")

    def freeze(source: Path) -> Path:
        shutil.copytree(source, folder / "data")
        if mounted:
            subprocess.run(["mount", "-o", "remount,ro", str(folder)], check=True, timeout=20)
        else:
            for path in (folder / "data", *(folder / "data").rglob("*")):
                path.chmod(0o555 if path.is_dir() else 0o444)
        return folder / "data"

    yield freeze
    if mounted:
        subprocess.run(["umount", "--lazy", str(folder)], check=True, timeout=20)
    else:
        for path in (p for p in (folder, *folder.rglob("*")) if p.is_dir()):
            path.chmod(0o755)


def test_a_folder_that_cannot_be_written_is_read(frozen, store):
    study, plan, study_id = entered(store, metrics=["amplitude_ratio"])
    put(store, study, *range(plan.count), generation="g")
    done = store.set_state(study_id, "done")
    expected = store.cube(study_id).load()
    # copied while it is open: the last marks are in SQLite's log
    data = frozen(store.data_dir)
    copy = Store.open(data)
    assert copy.find(study_id) == done
    assert copy.cube(study_id).load().identical(expected)
    assert list(verify(copy, done)) == []
    with pytest.raises(StoreFault, match="opened for reading only"):
        copy.set_state(study_id, "queued")
    other = make_study(damping_ratio=0.3)
    with pytest.raises(StoreFault, match="opened for reading only"):
        enter(copy, other)
    assert "cannot be written" in (copy.trouble() or "")
    copy.close()


def test_a_catalogue_that_is_written_while_it_is_copied_is_copied_again(store, monkeypatch):
    """Who may not write a folder reads it beside who may: the file and its log must be of one moment."""
    names = [enter(store, study).name for study in [make_study("first")]]
    copyfile, written = shutil.copyfile, []

    def copy_and_write(source, target):
        copied = copyfile(source, target)
        if str(source).endswith(SQLITE_FILE) and len(written) < 3:
            # between the two files: pages go from the log into the file, and the log begins again
            with closing(sqlite3.connect(source)) as other:
                other.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            study = make_study(f"later {len(written)}", damping_ratio=0.1 + 0.1 * len(written))
            written.append(enter(store, study).name)
        return copied

    monkeypatch.setattr(shutil, "copyfile", copy_and_write)
    copy = Store._open_read_only(store.data_dir, Quota())
    assert {record.name for record in copy.page().records} == {*names, *written}
    assert copy.catalogue.integrity() == []
    assert len(written) == 3
    copy.close()
