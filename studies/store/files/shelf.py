"""Interface of a storage location for cubes: files in a folder, or objects in a bucket of an object store.

Objects of a bucket are called files, too. When a write returns, the file is on the disk, or the server has confirmed
the write. A visible file is always complete.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

AT_ONCE = 16
"""Number of files that are written or read in parallel."""


TOMBSTONE = "deleted.json"
"""Name of the file that marks a cube as deleted, so that a rebuilt catalogue does not contain the study."""


class ShelfAway(OSError):
    """An object store does not answer, or is temporarily unavailable."""


@dataclass(frozen=True)
class Entry:
    """A file in the listing of a storage location.

    Parameters
    ----------
    key : str
        Name of the file, relative to the storage location.
    size : int
        Number of bytes.
    changed : float
        Time of writing, in seconds since 1970, by the clock of the disk or the server.
    """

    key: str
    size: int
    changed: float


def removed_last(key: str) -> tuple[bool, bool]:
    """Return the key by which the files of a cube are sorted before they are removed.

    JSON documents come after the other files. `TOMBSTONE` comes last, so that a partly removed cube keeps this mark.
    """
    return key.endswith(".json"), key.endswith(TOMBSTONE)


class Shelf(ABC):
    """A storage location for files. The names of files have parts separated by slashes, like paths.

    Methods raise `FileNotFoundError` if the file is absent, `PermissionError` if access is denied, `ShelfAway` if an
    object store does not answer, and another `OSError` if the disk reports an error.

    Parameters
    ----------
    address : str
        Path of a folder, or URL of a location in a bucket. The address is sent to workers, and contains no secret.
    """

    readers = 1
    """Best number of files to read in parallel."""
    first_bytes = 4096
    """Best number of bytes to read if only the beginning of a file is needed."""

    def __init__(self, address: str) -> None:
        self.address = address

    def __eq__(self, other: object) -> bool:
        """Compare storage locations by their addresses."""
        return isinstance(other, Shelf) and self.address == other.address

    def __hash__(self) -> int:
        """Return the hash of the address, so that equal locations have equal hashes."""
        return hash(self.address)

    @property
    def name(self) -> str:
        """The last part of the address."""
        return self.address.rpartition("/")[2]

    @abstractmethod
    def at(self, name: str) -> "Shelf":
        """Return the storage location `name` below this location. The location need not exist."""

    @abstractmethod
    def get(self, key: str) -> bytes:
        """Read a file."""

    @abstractmethod
    def read(self, key: str, start: int, length: int) -> bytes:
        """Read `length` bytes of a file from `start`; fewer bytes if the file ends earlier."""

    @abstractmethod
    def stamp(self, key: str) -> tuple[int, ...]:
        """Return a value that changes if the file is changed. For an object of a bucket, return an empty tuple."""

    @abstractmethod
    def put(self, key: str, content: bytes) -> None:
        """Write a file, replacing an existing file. In a folder that does not exist, raise `FileNotFoundError`."""

    @abstractmethod
    def put_new(self, key: str, content: bytes) -> bool:
        """Write a file if no file has this name. Return whether the file now has this content."""

    @abstractmethod
    def fill(self, pieces: Mapping[str, bytes], shelves: Iterable[str] = ()) -> None:
        """Write files into a storage location that may be absent. In a folder, also create the subfolders `shelves`."""

    @abstractmethod
    def make(self, shelves: Mapping[str, Mapping[str, bytes]], below: Iterable[str] = ()) -> None:
        """Create storage locations below this location, with initial files.

        In a folder, also create the subfolders `below` of every new location.
        """

    @abstractmethod
    def entries(self) -> Iterator[Entry]:
        """Yield every file. A file that is added or removed during the listing may be missing."""

    @abstractmethod
    def shelves(self) -> Iterator[str]:
        """Yield the names of the storage locations directly below this location."""

    @abstractmethod
    def made(self) -> float:
        """Return the time of a folder's last change, in seconds since 1970; 0 for a bucket."""

    @abstractmethod
    def remove(self, key: str) -> None:
        """Remove a file, if the file exists."""

    @abstractmethod
    def clear(self) -> None:
        """Remove every file, and also the folder if the storage location is a folder."""
