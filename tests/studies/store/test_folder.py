"""A folder's changes are on the disk when they are called done: each list of names that changed was synced."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from damperlab.studies.store.files.folder import Folder


@pytest.mark.parametrize(
    ("change", "changed"),
    [
        (lambda folder: folder.put("a", b"1"), {"."}),
        (lambda folder: folder.put_new("a", b"1"), {"."}),
        (lambda folder: folder.move("there", "away/there"), {".", "away"}),
        (lambda folder: folder.at("new").fill({"c/0": b"1"}), {".", "new", "new/c"}),
        (lambda folder: folder.make({"one": {"z": b"1"}, "two": {"z": b"2"}}), {".", "one", "two"}),
    ],
    ids=["put", "put_new", "move", "fill", "make"],
)
def test_each_list_of_names_that_changes_is_synced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: Callable[[Folder], object], changed: set[str]
) -> None:
    (tmp_path / "there").mkdir()
    synced = set()
    real = os.fsync

    def record(descriptor: int) -> None:
        synced.add(Path(f"/proc/self/fd/{descriptor}").readlink())
        real(descriptor)

    monkeypatch.setattr(os, "fsync", record)
    change(Folder(tmp_path))
    assert {tmp_path / name for name in changed} <= synced
