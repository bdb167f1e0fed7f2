"""Make files survive a power cut: zarr renames whole files into place, but asks the disk for nothing."""

import os
from collections.abc import Iterable
from pathlib import Path


def sync_path(path: str | os.PathLike[str]) -> None:
    """Wait until a file's content, or a folder's list of names, is on the disk.

    Parameters
    ----------
    path : path-like
        An existing file or folder.

    Raises
    ------
    OSError
        If the path is gone or the disk reports a failure.
    """
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def sync_paths(paths: Iterable[str | os.PathLike[str]]) -> None:
    """Wait for every path of `paths`, in their order; see `sync_path`."""
    for path in paths:
        sync_path(path)


def sync_tree(root: Path) -> None:
    """Wait for every file and folder at and below `root`, and for the entry of `root` in its parent."""
    for folder, _, names in os.walk(root):
        sync_paths(Path(folder, name) for name in names)
        sync_path(folder)
    sync_path(root.parent)
