"""A folder's changes are on the disk when they are called done: each list of names that changed was synced."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.shelf import Shelf as Records
from damperlab.studies.store.files.folder import Folder

MOTION = GroundMotion("short", 0.01, np.array([0.0, 1.0, 0.0]))


@pytest.mark.parametrize(
    ("change", "changed"),
    [
        (lambda folder: folder.put("a", b"1"), {"."}),
        (lambda folder: folder.put_new("a", b"1"), {"."}),
        (lambda folder: folder.at("new").fill({"c/0": b"1"}), {".", "new", "new/c"}),
        (lambda folder: folder.make({"one": {"z": b"1"}, "two": {"z": b"2"}}), {".", "one", "two"}),
        (lambda folder: Records(folder.address).put(MOTION), {".", "records"}),
        (lambda folder: (records := Records(folder.address)).remove(records.put(MOTION)[0]), {"records"}),
    ],
    ids=["put", "put_new", "fill", "make", "record", "no record"],
)
def test_each_list_of_names_that_changes_is_synced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: Callable[[Folder], object], changed: set[str]
) -> None:
    (tmp_path / "there").mkdir()
    synced: dict[Path, list[Path]] = {}
    real = os.fsync

    def record(descriptor: int) -> None:
        path = Path(f"/proc/self/fd/{descriptor}").readlink()
        synced[path] = sorted(path.iterdir()) if path.is_dir() else []
        real(descriptor)

    monkeypatch.setattr(os, "fsync", record)
    change(Folder(tmp_path))
    for folder in (tmp_path / name for name in changed):
        assert synced.get(folder) == sorted(folder.iterdir()), "its names have changed since"
