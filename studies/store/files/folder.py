"""A storage location that is a folder. Each file is synced and renamed, and then the file's folder is synced."""

import math
import os
import shutil
import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

from damperlab.studies.store.files.shelf import AT_ONCE, Entry, Shelf, removed_last


class Folder(Shelf):
    """A folder as a storage location.

    Parameters
    ----------
    address : path-like
        Path of the folder, which need not exist.
    """

    def __init__(self, address: str | os.PathLike[str]) -> None:
        self._path = Path(address)
        super().__init__(str(self._path))

    def __reduce__(self) -> tuple[type["Folder"], tuple[str]]:
        """Pickle only the address."""
        return Folder, (self.address,)

    def at(self, name: str) -> "Folder":
        """Return the subfolder with this name."""
        return Folder(self._path / name)

    def get(self, key: str) -> bytes:
        """Read a file."""
        # use a string as the path, because creating a path object takes longer than opening a file
        with open(f"{self.address}/{key}", "rb") as file:  # noqa: PTH123
            return file.read()

    def read(self, key: str, start: int, length: int) -> bytes:
        """Read a part of a file."""
        descriptor = os.open(f"{self.address}/{key}", os.O_RDONLY)
        try:
            return os.pread(descriptor, length, start)
        finally:
            os.close(descriptor)

    def stamp(self, key: str) -> tuple[int, ...]:
        """Return the time of a file's last change, and the size of the file."""
        now = os.stat(f"{self.address}/{key}")  # noqa: PTH116
        return now.st_mtime_ns, now.st_size

    def put(self, key: str, content: bytes) -> None:
        """Write a file into an existing folder, and wait until the file and its name are on the disk."""
        self._place(key, content, os.replace)

    def put_new(self, key: str, content: bytes) -> bool:
        """Write a file if no file has this name. Return whether the file now has this content."""
        try:
            self._place(key, content, os.link)
        except FileExistsError:
            return self.get(key) == content
        return True

    def _place(
        self, key: str, content: bytes, place: Callable[[Path, Path], None], *, sync: bool = True
    ) -> None:
        target = self._path / key
        partial = target.with_name(f"{target.name}.{uuid.uuid4().hex}.partial")
        try:
            with partial.open("xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            place(partial, target)
        finally:
            with suppress(OSError):
                partial.unlink(missing_ok=True)
        if sync:
            sync_path(target.parent)

    def fill(self, pieces: Mapping[str, bytes], shelves: Iterable[str] = ()) -> None:
        """Write files into a folder that may not exist yet."""
        self._fill(pieces, shelves)
        sync_path(self._path.parent)

    def make(self, shelves: Mapping[str, Mapping[str, bytes]], below: Iterable[str] = ()) -> None:
        """Create subfolders with their initial files, several in parallel, and wait until all files are on the disk."""

        def make_one(name: str, pieces: Mapping[str, bytes]) -> None:
            self.at(name)._fill(pieces, below)

        if len(shelves) == 1:
            for name, pieces in shelves.items():
                make_one(name, pieces)
        else:
            # the threads mostly wait for the disk, which serves several threads at once
            with ThreadPoolExecutor(AT_ONCE) as pool:
                for _ in pool.map(make_one, shelves, shelves.values()):
                    pass
        sync_path(self._path)

    def _fill(self, pieces: Mapping[str, bytes], shelves: Iterable[str]) -> None:
        """Write files and wait until they are on the disk. The caller must sync the parent of this folder."""
        folders = {(self._path / key).parent for key in pieces} | {self._path / name for name in shelves}
        for folder in folders:
            folder.mkdir(parents=True, exist_ok=True)
        for key, content in pieces.items():
            self._place(key, content, os.replace, sync=False)
        # sync this folder and every folder down to the written files, each folder once
        between = {self._path} | {above for folder in folders for above in (folder, *folder.parents)}
        for folder in between:
            if folder.is_relative_to(self._path):
                sync_path(folder)

    def entries(self) -> Iterator[Entry]:
        """List every file at any depth."""
        for folder, _, names in os.walk(self._path):
            for name in names:
                file = Path(folder, name)
                with suppress(FileNotFoundError):
                    found = file.stat()
                    key = file.relative_to(self._path).as_posix()
                    yield Entry(key, found.st_size, found.st_mtime)

    def shelves(self) -> Iterator[str]:
        """Yield the names of the subfolders."""
        with suppress(FileNotFoundError):
            yield from [path.name for path in self._path.iterdir() if path.is_dir()]

    def made(self) -> float:
        """Return the time when a file in the folder was last added or removed; infinity if the folder is absent."""
        try:
            return self._path.stat().st_mtime
        except FileNotFoundError:
            return math.inf

    def remove(self, key: str) -> None:
        """Remove a file."""
        (self._path / key).unlink(missing_ok=True)

    def clear(self) -> None:
        """Remove the folder and its content; the JSON documents are removed last."""
        with suppress(FileNotFoundError):
            if not self._path.is_symlink():
                for file in sorted(self._path.iterdir(), key=lambda file: removed_last(file.name)):
                    if file.is_dir() and not file.is_symlink():
                        shutil.rmtree(file)
                    else:
                        file.unlink()
            shutil.rmtree(self._path)  # raises OSError if the folder is a symbolic link


def sync_path(path: str | os.PathLike[str]) -> None:
    """Wait until a file's content, or a folder's list of names, is on the disk.

    Parameters
    ----------
    path : path-like
        An existing file or folder.

    Raises
    ------
    OSError
        If the path is absent or the disk reports a failure.
    """
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def open_shelf(address: str) -> Shelf:
    """Return the storage location at an address: `s3://bucket/prefix`, or the path of a folder."""
    if address.startswith("s3://"):
        # imported here, because the library is optional
        from damperlab.studies.store.files.bucket import open_bucket

        return open_bucket(address)
    return Folder(address)
