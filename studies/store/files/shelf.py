"""Location of cubes: named pieces of bytes, in a folder or in a bucket of an object store.

When a write returns, the piece is on the disk or acknowledged by the server. A visible piece is always complete. All
reading and writing of cubes uses this interface, so both kinds give the same guarantees.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

AT_ONCE = 16
"""Pieces written or read in parallel, since each one mostly waits for a disk or a server."""


TOMBSTONE = "deleted.json"
"""The key of the piece that records the deletion of a cube's study, so that a lost catalogue does not restore it."""


class ShelfAway(OSError):
    """An object store does not answer, or is temporarily unavailable."""


@dataclass(frozen=True)
class Entry:
    """One piece on a shelf.

    Parameters
    ----------
    key : str
        Its name, relative to the shelf.
    size : int
        Bytes.
    changed : float
        Time of writing, in seconds since 1970 by the clock of the disk or the server.
    """

    key: str
    size: int
    changed: float


def removed_last(key: str) -> tuple[bool, bool]:
    """Give the sort key of a piece, by which the pieces of a cube are removed.

    Pieces that describe others are removed after those, and the record of the deletion is removed last. So a cube with
    missing pieces never counts as complete, and its study never as existing.
    """
    return key.endswith(".json"), key.endswith(TOMBSTONE)


class Shelf(ABC):
    """A location for pieces of bytes by name; names have parts, like paths.

    Every method raises `FileNotFoundError` if a piece is absent, `PermissionError` without permission, `ShelfAway` if
    an object store does not answer, and other `OSError`s of the disk.

    Parameters
    ----------
    address : str
        A folder's path, or the URL of a location in a bucket; it is sent to the workers, and contains no secret.
    """

    readers = 1
    """Best number of pieces to read in parallel."""
    first_bytes = 4096
    """Best number of bytes to read if only the beginning of a piece is needed."""

    def __init__(self, address: str) -> None:
        self.address = address

    def __eq__(self, other: object) -> bool:
        """Compare shelves by their addresses."""
        return isinstance(other, Shelf) and self.address == other.address

    def __hash__(self) -> int:
        """Hash the address, in agreement with equality."""
        return hash(self.address)

    @property
    def name(self) -> str:
        """The last part of the address."""
        return self.address.rpartition("/")[2]

    @abstractmethod
    def at(self, name: str) -> "Shelf":
        """Give the shelf below this one, which may be absent."""

    @abstractmethod
    def get(self, key: str) -> bytes:
        """Read a piece."""

    @abstractmethod
    def read(self, key: str, start: int, length: int) -> bytes:
        """Read a part of a piece; less if it ends earlier."""

    @abstractmethod
    def stamp(self, key: str) -> tuple[int, ...]:
        """Give a value that changes with the content under a name, if that needs no request."""

    @abstractmethod
    def put(self, key: str, content: bytes) -> None:
        """Write a piece, replacing one of the same name; never create an absent shelf if this can be detected."""

    @abstractmethod
    def put_new(self, key: str, content: bytes) -> bool:
        """Write a piece unless one has its name; say whether the name now has this content."""

    @abstractmethod
    def fill(self, pieces: Mapping[str, bytes], shelves: Iterable[str] = ()) -> None:
        """Write the first pieces on a shelf and create it if it is absent, together with the named shelves below it."""

    @abstractmethod
    def make(self, shelves: Mapping[str, Mapping[str, bytes]], below: Iterable[str] = ()) -> None:
        """Create new shelves below this one, given by name with their first pieces; each also gets the named shelves
        below it.
        """

    @abstractmethod
    def entries(self) -> Iterator[Entry]:
        """List every piece; those added or removed meanwhile may be missing."""

    @abstractmethod
    def shelves(self) -> Iterator[str]:
        """List the names of the shelves below this one."""

    @abstractmethod
    def made(self) -> float:
        """Give the time when the shelf itself was created or last changed, in seconds since 1970; 0 if shelves
        exist only through their pieces.
        """

    @abstractmethod
    def remove(self, key: str) -> None:
        """Remove a piece; an absent one is no error."""

    @abstractmethod
    def clear(self) -> None:
        """Remove every piece, and the shelf itself."""

    def put_all(self, pieces: Mapping[str, bytes]) -> None:
        """Write several pieces in parallel, and wait for all."""
        with ThreadPoolExecutor(AT_ONCE) as pool:
            for _ in pool.map(self.put, pieces, pieces.values()):
                pass
