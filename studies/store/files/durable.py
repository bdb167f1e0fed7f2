"""Make files survive a power cut."""

import os


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
